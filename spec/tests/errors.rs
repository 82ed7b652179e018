//! Every refused weights file in `tests/errors/weights` gives exactly the message beside it.
//!
//! Adding a case is adding a file: write the `.json`, run with `BLESS=1`, read the `.txt`.

use std::fs;
use std::path::{Path, PathBuf};

use hwgen_spec::weights;

fn cases(extension: &str) -> Vec<PathBuf> {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/errors/weights");
    let mut paths: Vec<_> = fs::read_dir(directory)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == extension))
        .collect();
    paths.sort();
    paths
}

#[test]
fn refused_files_give_the_message_beside_them() {
    let bless = std::env::var_os("BLESS").is_some_and(|v| v == "1");
    let mut wrong = Vec::new();
    let paths = cases("json");
    assert!(paths.len() > 30, "only {} cases", paths.len());
    for path in &paths {
        let name = path.file_name().unwrap().to_str().unwrap();
        let found = match weights::read(&fs::read(path).unwrap()) {
            Ok(_) => "accepted\n".to_owned(),
            Err(error) => error.render(name) + "\n",
        };
        let text = path.with_extension("txt");
        if bless && found != "accepted\n" {
            fs::write(&text, &found).unwrap();
        }
        match fs::read_to_string(&text) {
            Ok(expected) if expected == found => {}
            Ok(expected) => wrong.push(format!("{name}\nexpected: {expected}found:    {found}")),
            Err(_) => wrong.push(format!("{name} has no .txt; found: {found}")),
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_message_has_its_file() {
    for text in cases("txt") {
        assert!(text.with_extension("json").exists(), "{}", text.display());
    }
}
