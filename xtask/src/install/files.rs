//! Writes files below a prefix and removes them again.
//!
//! A list of what was written is kept below the prefix. It names files and, with a final `/`, the folders that did not exist before; all relative to the
//! prefix.

use std::collections::BTreeSet;
use std::ffi::OsString;
use std::fs::Permissions;
use std::io::ErrorKind;
use std::os::unix::fs::{PermissionsExt as _, symlink};
use std::path::{Component, Path, PathBuf};

use anyhow::{Context, Result, ensure};

/// The list of what was installed.
const LIST: &str = "share/mollis/manifest.txt";

/// What an installed file holds.
pub enum Content {
    /// The bytes of this file.
    Copy(PathBuf),
    /// The bytes of this file, to be loaded and run.
    Program(PathBuf),
    Text(String),
    /// A symbolic link to this name in the same folder.
    Link(String),
}

/// A file to install.
pub struct Entry {
    /// Relative to the prefix.
    path: String,
    content: Content,
}

impl Entry {
    pub fn new(path: String, content: Content) -> Self {
        Self { path, content }
    }

    /// A file that keeps its name in another folder.
    pub fn copy(folder: &str, file: PathBuf) -> Result<Self> {
        let name = file.file_name().and_then(|name| name.to_str()).context("no name")?;
        Ok(Self::new(format!("{folder}/{name}"), Content::Copy(file)))
    }
}

/// Where files are used, and where they are written.
pub struct Place {
    prefix: PathBuf,
    root: PathBuf,
}

impl Place {
    /// Files for `prefix`, to be written below `destdir` if there is one: what makes a package copies them from there.
    pub fn new(prefix: &Path, destdir: Option<OsString>) -> Result<Self> {
        let prefix = absolute(prefix)?;
        let root = match destdir.filter(|folder| !folder.is_empty()) {
            Some(folder) => absolute(Path::new(&folder))?.join(prefix.strip_prefix("/")?),
            None => prefix.clone(),
        };
        Ok(Self { prefix, root })
    }

    pub fn prefix(&self) -> Result<&str> {
        self.prefix.to_str().context("the prefix is no text")
    }

    pub fn root(&self) -> &Path {
        &self.root
    }

    /// Writes all files. Those of an earlier installation are replaced or, such as a shared library of another version, stay and stay listed.
    pub fn install(&self, entries: &[Entry]) -> Result<()> {
        let mut listed = self.listed()?.unwrap_or_default();
        for path in entries.iter().map(|entry| entry.path.as_str()).chain([LIST]) {
            listed.insert(path.to_owned());
            let folders = Path::new(path).ancestors().skip(1).filter(|folder| !folder.as_os_str().is_empty());
            let missing = folders.filter(|folder| !self.root.join(folder).exists());
            listed.extend(missing.map(|folder| format!("{}/", folder.display())));
        }
        // The list comes first, so that an interrupted installation can be removed.
        let list = listed.into_iter().fold(String::new(), |text, path| text + &path + "\n");
        self.write(&Entry::new(LIST.into(), Content::Text(list)))?;
        entries.iter().try_for_each(|entry| self.write(entry))
    }

    /// Removes what is listed, folders only where they are empty. Returns the number of files.
    pub fn uninstall(&self) -> Result<usize> {
        let listed = self.listed()?.with_context(|| format!("{} is not there", self.root.join(LIST).display()))?;
        let (folders, files): (Vec<_>, Vec<_>) = listed.iter().partition(|path| path.ends_with('/'));
        // The list goes last, so that an interrupted removal can be repeated.
        let mut removed = 0;
        for path in files.into_iter().filter(|path| *path != LIST) {
            removed += usize::from(unlink(&self.root.join(path))?);
        }
        unlink(&self.root.join(LIST))?;
        // In reverse order inner folders come before outer ones.
        for path in folders.into_iter().rev() {
            match std::fs::remove_dir(self.root.join(path)) {
                Err(error) if ![ErrorKind::NotFound, ErrorKind::DirectoryNotEmpty].contains(&error.kind()) => {
                    return Err(error).with_context(|| format!("cannot remove {path}"));
                }
                _ => {}
            }
        }
        Ok(removed)
    }

    /// The lines of the list, or nothing if there is none.
    fn listed(&self) -> Result<Option<BTreeSet<String>>> {
        let path = self.root.join(LIST);
        let text = match std::fs::read_to_string(&path) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            read => read.with_context(|| format!("cannot read {}", path.display()))?,
        };
        let stays_inside = |line: &str| Path::new(line).components().all(|part| matches!(part, Component::Normal(_)));
        let outside = text.lines().find(|line| line.is_empty() || !stays_inside(line));
        ensure!(outside.is_none(), "{} lists `{}`", path.display(), outside.unwrap_or_default());
        Ok(Some(text.lines().map(str::to_owned).collect()))
    }

    fn write(&self, entry: &Entry) -> Result<()> {
        let path = self.root.join(&entry.path);
        make_folder(path.parent().context("no folder")?)?;
        // A link from an earlier installation must not be followed, and programs that run must keep the library that they have loaded.
        unlink(&path)?;
        let written = match &entry.content {
            Content::Copy(from) | Content::Program(from) => std::fs::copy(from, &path).map(|_| ()),
            Content::Text(text) => std::fs::write(&path, text),
            Content::Link(to) => symlink(to, &path),
        };
        written.with_context(|| format!("cannot write {}", path.display()))?;
        match entry.content {
            Content::Link(_) => Ok(()),
            Content::Program(_) => permit(&path, 0o755),
            Content::Copy(_) | Content::Text(_) => permit(&path, 0o644),
        }
    }
}

/// A path from the root, without `.` and `..`.
fn absolute(path: &Path) -> Result<PathBuf> {
    let mut out = PathBuf::new();
    for part in std::path::absolute(path)?.components() {
        if part == Component::ParentDir {
            out.pop();
        } else {
            out.push(part);
        }
    }
    Ok(out)
}

/// Sets permissions, whatever the user's mask.
fn permit(path: &Path, mode: u32) -> Result<()> {
    Ok(std::fs::set_permissions(path, Permissions::from_mode(mode))?)
}

fn make_folder(path: &Path) -> Result<()> {
    if path.is_dir() {
        return Ok(());
    }
    if let Some(parent) = path.parent() {
        make_folder(parent)?;
    }
    std::fs::create_dir(path).with_context(|| format!("cannot make {}", path.display()))?;
    permit(path, 0o755)
}

/// Removes a file or a link. Returns whether there was one.
fn unlink(path: &Path) -> Result<bool> {
    match std::fs::remove_file(path) {
        Ok(()) => Ok(true),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(false),
        Err(error) => Err(error).with_context(|| format!("cannot remove {}", path.display())),
    }
}

#[cfg(test)]
mod tests {
    use std::path::{Path, PathBuf};

    use super::{Content, Entry, LIST, Place};

    fn fresh(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("mollis-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).expect("a folder");
        folder
    }

    #[test]
    fn places() {
        let place = |prefix: &str, destdir: Option<&str>| {
            let place = Place::new(Path::new(prefix), destdir.map(Into::into)).expect("a place");
            (place.prefix.display().to_string(), place.root.display().to_string())
        };
        let pair = |prefix: &str, root: &str| (prefix.to_owned(), root.to_owned());
        assert_eq!(place("/usr", None), pair("/usr", "/usr"));
        assert_eq!(place("/usr", Some("")), pair("/usr", "/usr"));
        assert_eq!(place("/usr/./x/../local/", Some("/tmp/stage/")), pair("/usr/local", "/tmp/stage/usr/local"));
        let here = std::env::current_dir().expect("a folder").display().to_string();
        assert_eq!(place("out", Some("stage")), pair(&format!("{here}/out"), &format!("{here}/stage{here}/out")));
    }

    #[test]
    fn only_what_was_installed_is_removed() {
        let root = fresh("removed");
        std::fs::create_dir(root.join("lib")).expect("a folder");
        let place = Place::new(&root, None).expect("a place");
        let text = |path: &str| Entry::new(path.into(), Content::Text(String::new()));
        place.install(&[text("lib/a.0"), text("include/sub/a.h")]).expect("installed");
        // Another version: what only the first one had is removed as well.
        place.install(&[text("lib/a.1"), text("include/sub/a.h")]).expect("installed");
        assert!(root.join("lib/a.0").exists());
        std::fs::write(root.join("include/other.h"), "").expect("written");
        assert_eq!(place.uninstall().expect("removed"), 3);
        let left = |folder: &str| std::fs::read_dir(root.join(folder)).expect("a folder").count();
        // `lib` was there before, and `include` holds a file of somebody else.
        assert_eq!((left(""), left("lib"), left("include")), (2, 0, 1));
        assert!(place.uninstall().is_err());
        std::fs::remove_dir_all(&root).expect("removed");
    }

    #[test]
    fn a_list_that_leaves_the_prefix_is_refused() {
        let root = fresh("refused");
        let place = Place::new(&root.join("prefix"), None).expect("a place");
        std::fs::write(root.join("other"), "").expect("written");
        std::fs::create_dir_all(place.root.join(LIST).parent().expect("a folder")).expect("made");
        for line in ["../other", "/etc/other", "lib/../../other", ""] {
            std::fs::write(place.root.join(LIST), format!("{line}\n")).expect("written");
            assert!(place.uninstall().is_err(), "{line}");
        }
        assert!(root.join("other").exists());
        std::fs::remove_dir_all(&root).expect("removed");
    }
}
