//! The files of a build, read once: what is searched, hashed and compiled is the same.

use std::collections::HashSet;
use std::ffi::OsString;
use std::io::Write;
use std::path::{Path, PathBuf};

use super::text;
use crate::error::ToolError;
use crate::tool::run::io;

/// Where copies go, below the directory in which a compiler runs.
const FOLDER: &str = "src";

/// One file.
pub(super) struct Input {
    /// Its name in the build, free of the directories that it comes from: compilers, makefiles
    /// and dumps stumble over spaces and quotes.
    pub(super) name: OsString,
    pub(super) text: Vec<u8>,
}

/// A text that the caller supplies: a bench, a program around it, a model of a block.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Text {
    /// Its file name.
    pub name: String,
    /// What is in it.
    pub text: String,
}

impl From<&Text> for Input {
    fn from(text: &Text) -> Self {
        Self {
            name: text.name.clone().into(),
            text: text.text.clone().into_bytes(),
        }
    }
}

impl Input {
    pub(super) fn read(path: &Path) -> Result<Self, ToolError> {
        Ok(Self {
            name: path.file_name().unwrap_or_default().to_owned(),
            text: std::fs::read(path).map_err(io(path))?,
        })
    }
}

/// The Verilog of a core.
///
/// # Errors
/// [`ToolError::Refused`] if a simulator could read it in another way than synthesis does, or it
/// calls the simulator or reads other files, or if a module is there twice: in the core, or in it and in
/// one of `others`.
pub(super) fn core(paths: &[PathBuf], others: &[&Text]) -> Result<Vec<Input>, ToolError> {
    let others = others.iter().flat_map(|other| text::modules(&other.text));
    let mut modules: HashSet<String> = others.map(|(_, name)| name).collect();
    paths
        .iter()
        .map(|path| {
            let input = Input::read(path)?;
            let text = String::from_utf8_lossy(&input.text);
            let twice = || {
                let mut names = text::modules(&text).into_iter();
                let (line, name) = names.find(|(_, name)| !modules.insert(name.clone()))?;
                Some((line, format!("a second module `{name}`")))
            };
            match text::refused(&text).or_else(twice) {
                Some((line, found)) => Err(ToolError::Refused {
                    path: path.clone(),
                    line,
                    found,
                }),
                None => Ok(input),
            }
        })
        .collect()
}

/// Copies the files below a directory, and names them from there.
pub(super) fn place(inputs: &[Input], directory: &Path) -> Result<Vec<OsString>, ToolError> {
    let folder = directory.join(FOLDER);
    std::fs::create_dir_all(&folder).map_err(io(&folder))?;
    inputs
        .iter()
        .map(|input| {
            let path = folder.join(&input.name);
            // New, or one of two files of one name would be left out in silence.
            std::fs::File::create_new(&path)
                .and_then(|mut file| file.write_all(&input.text))
                .map_err(io(&path))?;
            Ok(Path::new(FOLDER).join(&input.name).into_os_string())
        })
        .collect()
}
