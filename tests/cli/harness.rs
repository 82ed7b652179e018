//! Runs the built binary in a directory of its own.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;
use tempfile::TempDir;

/// A 3-7-2 sigmoid network.
pub fn tiny() -> String {
    let row = |n: usize, seed: usize| {
        let cells: Vec<String> = (0..n)
            .map(|i| format!("{}", ((seed * 7 + i * 5) % 13) as f64 / 8.0 - 0.75))
            .collect();
        format!("[{}]", cells.join(","))
    };
    let rows = |o: usize, n: usize| {
        let rows: Vec<String> = (0..o).map(|s| row(n, s + 1)).collect();
        format!("[{}]", rows.join(","))
    };
    format!(
        r#"{{"format": "hwgen-weights/1", "name": "tiny",
  "inputs": {{"names": ["a", "b", "c"], "unit": "V", "min": [-1, -1, -1], "max": [1, 1, 1]}},
  "networks": [{{"name": "net", "layers": [
    {{"activation": "sigmoid", "weights": {}}},
    {{"activation": "linear", "weights": {}, "bias": [0.5, -0.25]}}],
    "outputs": {{"names": ["x", "y"], "unit": "m"}}}}]}}
"#,
        rows(7, 3),
        rows(2, 7)
    )
}

/// Two outputs of very different scales in one layer: both share its output format, so that the
/// small one has few steps. `frames` are rows of calibration, none for none.
pub fn scales(frames: &[[f64; 2]]) -> String {
    let rows: Vec<String> = frames.iter().map(|[a, b]| format!("[{a},{b}]")).collect();
    let calibration = match frames {
        [] => String::new(),
        _ => format!(r#", "calibration": {{"inputs": [{}]}}"#, rows.join(",")),
    };
    format!(
        r#"{{"format": "hwgen-weights/1", "name": "scales",
  "inputs": {{"names": ["a", "b"], "min": [-1, -1], "max": [1, 1]}},
  "networks": [{{"name": "n", "layers": [
    {{"activation": "tanh", "weights": [[1, 0.5], [-0.5, 1], [0.25, -0.75]]}},
    {{"activation": "linear", "weights": [[1, -1, 0.5], [0.5, 1, -1]]}}],
    "outputs": {{"names": ["large", "small"], "unit": "m", "scale": [1e5, 0.1]}}}}]{calibration}}}
"#
    )
}

/// Frames of [`scales`] in its box.
pub fn frames(count: u32) -> Vec<[f64; 2]> {
    let frame = |i: u32| {
        [
            f64::from(i * 7 % 64) / 32.0 - 1.0,
            f64::from(i * 13 % 50) / 25.0 - 1.0,
        ]
    };
    (0..count).map(frame).collect()
}

/// The same as a CSV file.
pub fn csv(frames: &[[f64; 2]]) -> String {
    let rows: Vec<String> = frames.iter().map(|[a, b]| format!("{a},{b}\n")).collect();
    format!("a,b\n{}", rows.concat())
}

/// A directory in which the binary runs.
pub struct Place {
    directory: TempDir,
}

/// What a run of the binary left.
pub struct Ran {
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

impl Place {
    /// With `w.json`, the tiny network, in it.
    pub fn new() -> Self {
        let directory = tempfile::tempdir().expect("a directory");
        let place = Self { directory };
        place.write("w.json", &tiny());
        place
    }

    /// The same, and its bundle in `build/tiny`.
    pub fn with_bundle() -> Self {
        let place = Self::new();
        place.run(&["emit", "--weights", "w.json"]).exits(0);
        place
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.directory.path().join(name)
    }

    pub fn write(&self, name: &str, text: &str) {
        let path = self.path(name);
        fs::create_dir_all(path.parent().expect("a parent")).expect("created");
        fs::write(path, text).expect("written");
    }

    pub fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).expect(name)
    }

    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_hwgen"));
        command
            .args(arguments)
            .current_dir(self.directory.path())
            .env("XDG_CACHE_HOME", self.path("cache"))
            .env_remove("VIRTUAL_ENV");
        command
    }

    pub fn run(&self, arguments: &[&str]) -> Ran {
        ran(self.command(arguments).output().expect("starts"))
    }

    /// With nothing but this directory to find tools in.
    pub fn run_with_path(&self, path: &Path, arguments: &[&str]) -> Ran {
        let mut command = self.command(arguments);
        ran(command.env("PATH", path).output().expect("starts"))
    }

    /// With `--json`.
    pub fn json(&self, arguments: &[&str]) -> (Ran, Value) {
        let ran = self.run(&[arguments, &["--json"]].concat());
        let value = ran.json();
        (ran, value)
    }

    /// An executable that does what the shell lines say.
    pub fn fake_tool(&self, name: &str, script: &str) {
        use std::os::unix::fs::PermissionsExt;
        self.write(name, &format!("#!/bin/sh\n{script}\n"));
        let mode = fs::Permissions::from_mode(0o755);
        fs::set_permissions(self.path(name), mode).expect("executable");
    }
}

pub fn ran(output: Output) -> Ran {
    Ran {
        code: output.status.code(),
        stdout: String::from_utf8(output.stdout).expect("UTF-8"),
        stderr: String::from_utf8(output.stderr).expect("UTF-8"),
    }
}

impl Ran {
    #[track_caller]
    pub fn exits(&self, code: i32) -> &Self {
        let Self { stdout, stderr, .. } = self;
        assert_eq!(
            self.code,
            Some(code),
            "stdout:\n{stdout}\nstderr:\n{stderr}"
        );
        assert!(!stderr.contains("panicked"), "{stderr}");
        self
    }

    /// Fails with exactly this on standard error, and says nothing else.
    #[track_caller]
    pub fn fails(&self, code: i32, stderr: &str) {
        self.exits(code);
        assert_eq!(self.stderr, stderr);
        assert_eq!(self.stdout, "");
    }

    /// The one object on standard output.
    #[track_caller]
    pub fn json(&self) -> Value {
        serde_json::from_str(&self.stdout)
            .unwrap_or_else(|e| panic!("{e}: {}\n{}", self.stdout, self.stderr))
    }
}
