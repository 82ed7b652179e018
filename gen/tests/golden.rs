//! Bundles byte for byte, and how they come to the disk.
//!
//! `BLESS=1 cargo test -p hwgen-gen --test golden` writes the expected bundles anew; then read the
//! diff. The tool's version is part of every digest, so a new version changes each file.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use hwgen_gen::{Bundle, BundleError, Source, generate};
use hwgen_spec::design::Design;
use hwgen_spec::network::FloatNet;
use hwgen_spec::weights;

const DESIGNS: [&str; 3] = ["gate", "line", "pair"];

fn golden() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/golden")
}

fn design(name: &str) -> (Design, FloatNet) {
    let read = |ending: &str| fs::read(golden().join(format!("{name}{ending}"))).expect(name);
    let net = weights::read(&read(".json")).expect(name);
    let options = serde_json::from_slice(&read(".options.json")).expect(name);
    (Design::new(&net, &options).expect(name), net)
}

fn bundle(name: &str) -> Bundle {
    let (design, net) = design(name);
    generate(&design, &net)
}

/// All files below a directory, by path with `/`.
fn tree(root: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = BTreeMap::new();
    let mut left = vec![root.to_owned()];
    while let Some(directory) = left.pop() {
        for entry in fs::read_dir(&directory).expect("a directory") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                left.push(path);
                continue;
            }
            let below = path.strip_prefix(root).expect("below the root");
            let parts: Vec<_> = below.iter().map(|p| p.to_str().expect("UTF-8")).collect();
            files.insert(parts.join("/"), fs::read(&path).expect("a file"));
        }
    }
    files
}

fn files(bundle: &Bundle) -> BTreeMap<String, Vec<u8>> {
    let files = bundle.files().iter();
    files
        .map(|f| (f.path.clone(), f.text.clone().into_bytes()))
        .collect()
}

fn names(directory: &Path) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(directory)
        .expect("a directory")
        .map(|e| {
            e.expect("an entry")
                .file_name()
                .into_string()
                .expect("UTF-8")
        })
        .collect();
    names.sort();
    names
}

#[test]
fn bundles_are_as_they_were() {
    for name in DESIGNS {
        let bundle = bundle(name);
        let directory = golden().join(name);
        if std::env::var_os("BLESS").is_some_and(|v| v == "1") {
            if directory.exists() {
                fs::remove_dir_all(&directory).expect("removed");
            }
            bundle.write(&directory).expect("written");
        }
        assert!(directory.is_dir(), "{name}: no bundle; run with BLESS=1");
        let (expected, found) = (tree(&directory), files(&bundle));
        let paths = |files: &BTreeMap<String, Vec<u8>>| files.keys().cloned().collect::<Vec<_>>();
        assert_eq!(paths(&found), paths(&expected), "files of {name}");
        assert!(found.len() > 20, "{name}");
        for (path, text) in &expected {
            if found[path] != *text {
                let found = String::from_utf8_lossy(&found[path]).into_owned();
                let expected = String::from_utf8_lossy(text);
                let line = found
                    .lines()
                    .zip(expected.lines())
                    .position(|(f, e)| f != e);
                let line =
                    line.unwrap_or_else(|| found.lines().count().min(expected.lines().count()));
                panic!(
                    "{name}/{path}:{}: expected\n  {}\nfound\n  {}\nIf it is meant: BLESS=1 cargo test -p hwgen-gen --test golden",
                    line + 1,
                    expected.lines().nth(line).unwrap_or("(the end)"),
                    found.lines().nth(line).unwrap_or("(the end)")
                );
            }
        }
    }
}

/// The designs are there for what they cover.
#[test]
fn the_designs_cover_what_they_are_meant_to() {
    let (line, _) = design("line");
    assert_eq!(
        (line.source().words, line.sink().words, line.macs()),
        (1, 1, 1)
    );
    let (gate, _) = design("gate");
    assert!(gate.perceptron().layers().all(|l| l.quant.table.is_some()));
    let (pair, _) = design("pair");
    let layers: Vec<_> = pair.perceptron().layers().collect();
    assert_eq!(
        (
            pair.perceptron().shared.len(),
            pair.perceptron().networks.len()
        ),
        (1, 2)
    );
    assert!(
        layers
            .iter()
            .any(|l| l.fold.simd > 1 && l.fold.simd < l.quant.inputs())
    );
    assert!(layers.iter().any(|l| l.quant.outputs() % l.fold.pe != 0));
    assert!(layers.iter().any(|l| l.quant.max_extra_shift() > 0));
    assert!(layers.iter().any(|l| l.quant.name == "turn_out"));
}

/// Same bytes twice, in two directories, in two threads.
#[test]
fn the_same_design_gives_the_same_bytes() {
    let root = tempfile::tempdir().expect("a directory");
    for name in DESIGNS {
        let reference = files(&bundle(name));
        let directories = ["a", "b/c"].map(|d| root.path().join(name).join(d));
        std::thread::scope(|scope| {
            let threads = directories.each_ref().map(|directory| {
                scope.spawn(move || {
                    let bundle = bundle(name);
                    bundle.write(directory).expect("written");
                })
            });
            for thread in threads {
                thread.join().expect("no panic");
            }
        });
        for directory in directories {
            assert_eq!(tree(&directory), reference, "{name}");
            // Nothing in it tells where it was made.
            let here = root.path().to_str().expect("UTF-8");
            for (path, text) in tree(&directory) {
                assert!(!String::from_utf8_lossy(&text).contains(here), "{path}");
            }
        }
    }
}

/// What stands in a bundle leads to the same bundle.
#[test]
fn a_bundle_can_be_made_again_from_itself() {
    let root = tempfile::tempdir().expect("a directory");
    for name in DESIGNS {
        let out = root.path().join(name);
        let bundle = bundle(name);
        bundle.write(&out).expect("written");
        let source = Source::read(&out).expect("read");
        assert_eq!(generate(&source.design, &source.net), bundle);
        // One byte more in one file.
        let path = out.join(format!("rtl/{name}.v"));
        let text = fs::read_to_string(&path).expect("read");
        fs::write(&path, text + "\n").expect("written");
        let error = Source::read(&out).expect_err("a changed file");
        assert!(matches!(error, BundleError::Changed { path: p, .. } if p == path));
    }
}

#[test]
fn an_existing_directory_is_refused_and_a_bundle_is_replaced() {
    let root = tempfile::tempdir().expect("a directory");
    let out = root.path().join("out");
    let (line, gate) = (bundle("line"), bundle("gate"));
    line.write(&out).expect("written");
    assert!(matches!(gate.write(&out), Err(BundleError::Exists { path }) if path == out));
    assert_eq!(tree(&out), files(&line));
    // Nothing of the old one is left.
    gate.replace(&out).expect("replaced");
    assert_eq!(tree(&out), files(&gate));
    // An empty directory, and none at all.
    let empty = root.path().join("empty");
    fs::create_dir(&empty).expect("made");
    line.replace(&empty).expect("replaced");
    line.replace(&root.path().join("none")).expect("written");
    assert_eq!(names(root.path()), ["empty", "none", "out"]);
}

#[test]
fn what_is_no_bundle_is_left_alone() {
    let root = tempfile::tempdir().expect("a directory");
    let line = bundle("line");
    let foreign = root.path().join("thesis");
    fs::create_dir(&foreign).expect("made");
    fs::write(foreign.join("chapter1.txt"), "years of work").expect("written");
    let refused = line.replace(&foreign);
    assert!(matches!(refused, Err(BundleError::NotABundle { path }) if path == foreign));
    let file = root.path().join("file");
    fs::write(&file, "text").expect("written");
    assert!(matches!(line.write(&file), Err(BundleError::Exists { .. })));
    assert!(line.replace(&file).is_err());
    assert_eq!(names(root.path()), ["file", "thesis"]);
    assert_eq!(names(&foreign), ["chapter1.txt"]);
    assert_eq!(fs::read(&file).expect("read"), b"text");
}

/// Another program's directory may have a `manifest.json` too.
#[test]
fn a_foreign_manifest_makes_no_bundle() {
    let root = tempfile::tempdir().expect("a directory");
    let foreign = root.path().join("app");
    fs::create_dir(&foreign).expect("made");
    fs::write(foreign.join("manifest.json"), "{\"name\": \"an app\"}").expect("written");
    fs::write(foreign.join("index.html"), "years of work").expect("written");
    let refused = bundle("line").replace(&foreign);
    assert!(
        matches!(refused, Err(BundleError::NotABundle { .. })),
        "{refused:?}"
    );
    assert_eq!(names(&foreign), ["index.html", "manifest.json"]);
}

#[test]
fn a_parent_that_is_a_file_is_an_error_and_nothing_is_left() {
    let root = tempfile::tempdir().expect("a directory");
    let parent = root.path().join("parent");
    fs::write(&parent, "a file").expect("written");
    for out in [parent.join("out"), parent.join("deeper/out")] {
        let line = bundle("line");
        assert!(matches!(line.write(&out), Err(BundleError::Io { .. })));
        assert!(matches!(line.replace(&out), Err(BundleError::Io { .. })));
    }
    assert_eq!(names(root.path()), ["parent"]);
    assert_eq!(fs::read(&parent).expect("read"), b"a file");
}

/// A process that dies before the rename leaves its half beside the old bundle, which is whole;
/// the next run is not held up by it.
#[test]
fn an_interrupted_write_leaves_the_old_bundle_whole() {
    let root = tempfile::tempdir().expect("a directory");
    let out = root.path().join("out");
    let (line, gate) = (bundle("line"), bundle("gate"));
    line.write(&out).expect("written");
    let half = root.path().join(".hwgen-new-killed");
    fs::create_dir_all(half.join("rtl")).expect("made");
    for file in gate.files().iter().take(3) {
        let path = half.join(&file.path);
        fs::create_dir_all(path.parent().expect("a directory")).expect("made");
        fs::write(path, &file.text[..file.text.len() / 2]).expect("written");
    }
    assert_eq!(tree(&out), files(&line));
    Source::read(&out).expect("the old one");
    assert!(Source::read(&half).is_err(), "a half is no bundle");
    gate.replace(&out).expect("replaced");
    Source::read(&out).expect("the new one");
}

/// A failure while files are written: the old bundle stays, the new half goes.
#[test]
#[cfg(target_os = "linux")]
fn a_failure_in_the_middle_leaves_nothing_behind() {
    let root = tempfile::tempdir().expect("a directory");
    let out = root.path().join("out");
    bundle("line").write(&out).expect("written");
    let before = tree(&out);
    // The name of a bundle's parent can be so long that only its files' names are too long.
    let long = root.path().join("d".repeat(200));
    let mut deep = long.clone();
    while deep.as_os_str().len() + 210 < 4064 {
        deep.push("d".repeat(200));
    }
    let room = 4064 - deep.as_os_str().len();
    if room > 1 {
        deep.push("e".repeat(room - 1));
    }
    fs::create_dir_all(&deep).expect("made");
    let gate = bundle("gate");
    let error = gate.write(&deep.join("o")).expect_err("names too long");
    assert!(matches!(error, BundleError::Io { .. }), "{error}");
    assert!(names(&deep).is_empty(), "{:?}", names(&deep));
    assert_eq!(tree(&out), before);
}
