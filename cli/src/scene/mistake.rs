//! What is wrong with a scene file.

use std::path::PathBuf;

/// One mistake in a scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mistake {
    /// Line in the file, from 1.
    pub line: usize,
    /// Key, value and what is allowed.
    pub text: String,
}

/// All mistakes of a scene file, one a line.
#[derive(Debug)]
pub struct Mistakes {
    /// The file.
    pub path: PathBuf,
    /// In order of lines.
    pub list: Vec<Mistake>,
}

impl std::fmt::Display for Mistakes {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for (index, mistake) in self.list.iter().enumerate() {
            let end = if index + 1 < self.list.len() { "\n" } else { "" };
            write!(f, "{}:{}: {}{end}", self.path.display(), mistake.line, mistake.text)?;
        }
        Ok(())
    }
}

impl std::error::Error for Mistakes {}
