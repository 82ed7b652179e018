//! What `hwgen verify` believes: no old dump, no broken one, no edited script, and no structure that
//! nobody listed.

use std::os::unix::fs::symlink;

use super::harness::{Place, Ran, ran};

const VERIFY: [&str; 6] = [
    "verify",
    "build/tiny",
    "--random",
    "2",
    "--simulators",
    "icarus",
];

/// Runs `verify` in Icarus with a runtime that does what it shall, and then `after` with the path
/// of the dump in `$dump`.
fn verify_with(place: &Place, after: &str) -> Ran {
    let path = std::env::var("PATH").expect("a path");
    place.fake_tool(
        "bin/vvp",
        &format!(
            "PATH='{path}'\n\
             for word in \"$@\"; do case $word in +dump=*) dump=${{word#+dump=}};; esac; done\n\
             vvp \"$@\" || exit\n\
             if [ -z \"$dump\" ]; then exit 0; fi\n\
             {after}"
        ),
    );
    let own = place.path("bin");
    let mut command = place.command(&VERIFY);
    command.env("PATH", format!("{}:{path}", own.display()));
    ran(command.output().expect("starts"))
}

#[test]
fn a_dump_of_an_earlier_run_is_not_believed() {
    let place = Place::with_bundle();
    let old = place.path("old");
    std::fs::create_dir(&old).expect("created");
    let keep = format!("cp \"$dump\" '{}'", old.display());
    verify_with(&place, &keep).exits(0);
    // The same stimuli and the same core: nothing but the nonce tells the dumps apart.
    let replay = format!("cp '{}'/\"$dump\" \"$dump\"", old.display());
    let ran = verify_with(&place, &replay);
    ran.exits(3);
    assert!(!ran.stdout.contains("verified"), "{}", ran.stdout);
    assert!(ran.stderr.contains("expected nonce"), "{}", ran.stderr);
}

#[test]
fn a_dump_that_ends_early_is_an_error_and_no_panic() {
    let place = Place::with_bundle();
    for bytes in [1, 100, 20_000] {
        let cut = format!("head -c {bytes} \"$dump\" > cut.$$; mv cut.$$ \"$dump\"");
        let ran = verify_with(&place, &cut);
        ran.exits(3);
        assert!(!ran.stdout.contains("verified"), "{}", ran.stdout);
        assert!(!ran.stderr.contains("panicked"), "{}", ran.stderr);
        assert!(ran.stderr.contains(".icarus.vcd: "), "{}", ran.stderr);
    }
}

#[test]
fn without_yosys_the_verdict_says_that_the_structure_was_not_checked() {
    let place = Place::with_bundle();
    let (own, path) = (place.path("few"), std::env::var("PATH").expect("a path"));
    std::fs::create_dir(&own).expect("created");
    for tool in ["iverilog", "vvp"] {
        let real = std::env::split_paths(&path)
            .map(|directory| directory.join(tool))
            .find(|path| path.is_file());
        symlink(real.expect(tool), own.join(tool)).expect("linked");
    }
    let ran = place.run_with_path(&own, &VERIFY);
    ran.exits(0);
    let verdict = ran.stdout.lines().last().expect("a verdict");
    assert!(verdict.starts_with("verified: "), "{verdict}");
    assert!(verdict.contains("structure: not checked"), "{verdict}");
    let json = place
        .run_with_path(&own, &[&VERIFY[..], &["--json"]].concat())
        .json();
    assert_eq!(json["structure"]["checked"], false, "{json}");

    let (ran, json) = place.json(&VERIFY);
    ran.exits(0);
    assert_eq!(json["structure"]["checked"], true, "{json}");
}

#[test]
fn a_file_around_the_verilog_that_says_something_else_is_refused() {
    let place = Place::with_bundle();
    for (path, find, replace) in [
        ("tiny.core", "rtl/tiny__hwg_slice.v", "rtl/../evil.v"),
        ("syn/tiny.ys", "read_verilog", "chparam\nread_verilog"),
        ("tb/tiny_tb.v", "initial", "initial $finish;\n  initial"),
    ] {
        let (file, manifest) = (format!("build/tiny/{path}"), "build/tiny/manifest.json");
        let (text, listed) = (place.read(&file), place.read(manifest));
        let changed = text.replacen(find, replace, 1);
        assert_ne!(text, changed, "{path}");
        place.write(&file, &changed);
        let [old, new] = [&text, &changed].map(|text| hwgen_gen::sha256(text));
        place.write(manifest, &listed.replace(&old, &new));
        let ran = place.run(&["verify", "build/tiny", "-q"]);
        ran.exits(2);
        let message = "expected the text that hwgen generates, found another";
        assert!(ran.stderr.contains(message), "{}", ran.stderr);
        assert!(ran.stderr.contains(&format!("{file}:")), "{}", ran.stderr);
        place.write(&file, &text);
        place.write(manifest, &listed);
    }
}
