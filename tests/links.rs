//! Every link from one page of the project to another leads somewhere.

use std::fs;
use std::path::{Path, PathBuf};

fn pages(directory: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(directory).expect("a directory") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            pages(&path, found);
        } else if path.extension().is_some_and(|e| e == "md") {
            found.push(path);
        }
    }
}

/// Targets of `[text](target)` that are paths.
fn links(text: &str) -> impl Iterator<Item = &str> {
    let targets = text.split("](").skip(1).filter_map(|rest| {
        let (target, _) = rest.split_once(')')?;
        target.split('#').next()
    });
    targets.filter(|target| !target.is_empty() && !target.contains("://"))
}

#[test]
fn links_lead_to_files() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut found = vec![
        root.join("README.md"),
        root.join("ARCHITECTURE.md"),
        root.join("CHANGELOG.md"),
    ];
    pages(&root.join("docs"), &mut found);
    pages(&root.join("designs"), &mut found);
    let mut followed = 0;
    let mut dead = Vec::new();
    for page in &found {
        let text = fs::read_to_string(page).expect("text");
        let directory = page.parent().expect("a directory");
        for link in links(&text) {
            followed += 1;
            if !directory.join(link).exists() {
                dead.push(format!("{}: {link}", page.display()));
            }
        }
    }
    assert!(followed > 20, "{followed} links followed");
    assert!(dead.is_empty(), "{}", dead.join("\n"));
}

#[test]
fn links_are_found() {
    let text = "see [a](b.md), ![c](../d.svg), [e](https://f) and [g](h.md#i)";
    assert_eq!(
        links(text).collect::<Vec<_>>(),
        ["b.md", "../d.svg", "h.md"]
    );
}
