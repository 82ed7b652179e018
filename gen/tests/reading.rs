//! What a bundle on the disk is checked for, and what is never deleted from it.

use std::fs;
use std::path::{Path, PathBuf};

use hwgen_gen::{Bundle, BundleError, Source, generate, sha256};
use hwgen_spec::design::Design;
use hwgen_spec::options::Options;
use hwgen_spec::weights;

/// A small bundle, written to `out` below `root`.
fn written(root: &Path) -> (Bundle, PathBuf) {
    let text = br#"{"format": "hwgen-weights/1", "name": "tiny",
        "inputs": {"min": [-1, 0], "max": [1, 1000]},
        "networks": [{"name": "net", "layers": [
          {"activation": "tanh", "weights": [[1, 0.002], [-2, 0.001]]},
          {"activation": "linear", "weights": [[1, 0.5]]}]}]}"#;
    let net = weights::read(text).expect("a weights file");
    let design = Design::new(&net, &Options::default()).expect("a design");
    let bundle = generate(&design, &net);
    let out = root.join("out");
    bundle.write(&out).expect("written");
    (bundle, out)
}

/// Puts `to` in the place of the first `from` of a file.
fn edit(path: &Path, from: &str, to: &str) {
    let text = fs::read_to_string(path).expect("read");
    assert!(text.contains(from), "{}: no {from}", path.display());
    fs::write(path, text.replacen(from, to, 1)).expect("written");
}

#[test]
fn every_field_of_the_manifest_is_checked() {
    let root = tempfile::tempdir().expect("a directory");
    let (bundle, out) = written(root.path());
    let manifest = out.join("manifest.json");
    let text = &bundle.files().last().expect("files").text;
    let cases = [
        (
            "\"latency_cycles\": ",
            "\"latency_cycles\": 1",
            "latency_cycles",
        ),
        (
            "\"format\": \"Q1.14\"",
            "\"format\": \"Q0.15\"",
            "streams[0].words[0].format",
        ),
        (
            "\"min_code\": 0",
            "\"min_code\": 1",
            "streams[0].words[1].min_code",
        ),
        ("\"aresetn\"", "\"reset\"", "reset"),
        ("\"rom_bits\"", "\"more\": 1,\n  \"rom_bits\"", "more"),
        (
            "\"path\": \"syn/tiny.ys\"",
            "\"path\": \"tb/sim_main.cpp\"",
            "files[",
        ),
    ];
    for (from, to, field) in cases {
        fs::write(&manifest, text).expect("written");
        edit(&manifest, from, to);
        if field == "files[" {
            // The digest is another file's too.
            let cpp = fs::read_to_string(out.join("tb/sim_main.cpp")).expect("read");
            let script = fs::read_to_string(out.join("syn/tiny.ys")).expect("read");
            edit(&manifest, &sha256(&script), &sha256(&cpp));
        }
        match Source::read(&out) {
            Err(BundleError::Altered { field: found, .. }) if found.starts_with(field) => {}
            other => panic!("{field}: {:?}", other.map(|_| "accepted")),
        }
    }
}

/// Whether edited Verilog is still right is for a verification to say.
#[test]
fn a_renewed_digest_of_a_file_is_accepted() {
    let root = tempfile::tempdir().expect("a directory");
    let (_, out) = written(root.path());
    let rom = out.join("rtl/tiny__net_l0_bias.v");
    let before = sha256(&fs::read_to_string(&rom).expect("read"));
    edit(&rom, "endmodule", "// mine\nendmodule");
    assert!(matches!(
        Source::read(&out),
        Err(BundleError::Changed { .. })
    ));
    let after = sha256(&fs::read_to_string(&rom).expect("read"));
    edit(&out.join("manifest.json"), &before, &after);
    Source::read(&out).expect("a renewed digest");
}

#[test]
fn sources_that_are_not_listed_are_refused() {
    let root = tempfile::tempdir().expect("a directory");
    for stray in ["rtl/stray.v", "tb/deeper/stray.v"] {
        let (_, out) = written(root.path());
        let path = out.join(stray);
        fs::create_dir_all(path.parent().expect("a directory")).expect("made");
        fs::write(&path, "module stray; endmodule\n").expect("written");
        match Source::read(&out) {
            Err(BundleError::Unlisted { path: found }) => assert_eq!(found, path),
            other => panic!("{stray}: {:?}", other.map(|_| "accepted")),
        }
        fs::remove_dir_all(&out).expect("removed");
    }
}

#[test]
fn files_that_no_emission_wrote_are_not_deleted() {
    let root = tempfile::tempdir().expect("a directory");
    let (bundle, out) = written(root.path());
    fs::write(out.join("rtl/mine.v"), "// mine").expect("written");
    fs::write(out.join("notes.txt"), "mine").expect("written");
    let refused = bundle.replace(&out).expect_err("files of the user");
    assert!(
        refused
            .to_string()
            .ends_with("others found: notes.txt, rtl/mine.v"),
        "{refused}"
    );
    assert!(out.join("notes.txt").exists() && out.join("rtl/mine.v").exists());
    fs::remove_file(out.join("notes.txt")).expect("removed");
    fs::remove_file(out.join("rtl/mine.v")).expect("removed");
    bundle.replace(&out).expect("nothing but the bundle");
    assert_eq!(fs::read_dir(root.path()).expect("read").count(), 1);
}

#[test]
fn a_path_without_a_name_is_refused() {
    let root = tempfile::tempdir().expect("a directory");
    let (bundle, out) = written(root.path());
    for path in [out.join(".."), PathBuf::from("/"), PathBuf::from(".")] {
        for refused in [bundle.replace(&path), bundle.write(&path)] {
            assert!(
                matches!(refused, Err(BundleError::NoName { .. })),
                "{refused:?}"
            );
        }
    }
    assert_eq!(fs::read_dir(root.path()).expect("read").count(), 1);
}
