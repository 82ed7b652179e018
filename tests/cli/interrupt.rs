//! A command that is told to stop takes all that it started with it.

use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use super::harness::Place;

/// Starts a check whose simulator never ends, has a child of its own, and says when it runs.
fn hanging_check(place: &Place) -> Child {
    place.fake_tool(
        "bin/iverilog",
        "if [ \"$1\" = -V ]; then echo 'Icarus Verilog version 12.0'; exit; fi
         echo design > icarus.vvp; pwd > \"$MARKS/compiled-in\"
         [ \"$TMPDIR\" = \"$(pwd)\" ] || exit 9",
    );
    place.fake_tool(
        "bin/vvp",
        "if [ \"$1\" = -V ]; then echo 'Icarus Verilog runtime version 12.0'; exit; fi
         (/bin/sleep 3; echo late > \"$MARKS/late\") &
         echo running > \"$MARKS/running\"; exec /bin/sleep 60",
    );
    std::fs::create_dir(place.path("marks")).expect("created");
    place
        .command(&["verify", "build/tiny"])
        .env(
            "PATH",
            format!("{}:/usr/bin:/bin", place.path("bin").display()),
        )
        .env("MARKS", place.path("marks"))
        .env("TMPDIR", place.path("marks"))
        .args(["--simulators", "icarus"])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("starts")
}

fn until(what: &str, mut happened: impl FnMut() -> bool) {
    let start = Instant::now();
    while !happened() {
        assert!(start.elapsed() < Duration::from_secs(60), "not {what}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

fn send(signal: &str, child: &Child) {
    let command = format!("kill -{signal} {}", child.id());
    let status = Command::new("sh").args(["-c", &command]).status();
    assert!(status.expect("a shell").success());
}

#[test]
fn nothing_outlives_a_check_that_is_told_to_stop() {
    for (signal, code) in [("INT", 130), ("TERM", 143)] {
        let place = Place::with_bundle();
        let mut check = hanging_check(&place);
        until("running", || place.path("marks/running").exists());
        send(signal, &check);
        let ended = check.wait().expect("ends");
        assert_eq!(ended.code(), Some(code), "{signal}");
        // The simulator's own child would write this.
        std::thread::sleep(Duration::from_secs(4));
        assert!(!place.path("marks/late").exists(), "{signal}");
        let compiled_in = place.read("marks/compiled-in");
        assert!(!std::path::Path::new(compiled_in.trim()).exists());
        let left: Vec<_> = std::fs::read_dir(place.path("marks"))
            .expect("a directory")
            .map(|entry| entry.expect("an entry").file_name())
            .collect();
        assert_eq!(left.len(), 2, "{left:?}");
        // The work directory is free again.
        let again = place.run(&["verify", "build/tiny", "--simulators", "icarus"]);
        again.exits(0);
    }
}

#[test]
fn two_checks_do_not_share_a_work_directory() {
    let place = Place::with_bundle();
    let mut check = hanging_check(&place);
    until("running", || place.path("marks/running").exists());
    let arguments = ["verify", "build/tiny", "--simulators", "icarus"];
    place.run(&[&arguments[..], &["-q"]].concat()).fails(
        2,
        "error: build/.verify/tiny: a directory that nobody works in expected, another check is \
         running\nhelp: wait for its end, or choose another --work\n",
    );
    assert!(
        place
            .path("build/.verify/tiny/icarus-build/icarus.vvp")
            .is_file()
    );
    place
        .run(&[&arguments[..], &["--work", "mine"]].concat())
        .exits(0);
    send("TERM", &check);
    assert_eq!(check.wait().expect("ends").code(), Some(143));
}
