//! Files that are written whole or not at all, and folders that take them.

use std::fs::{self, File};
use std::io::{BufWriter, ErrorKind};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

/// Writes a file whole or not at all: under the name `NAME.new` first, which is removed if that fails and takes the place of
/// an older file if it doesn't, whatever happens in between. An error names the file.
pub fn write(path: &Path, content: impl FnOnce(&mut BufWriter<File>) -> Result<()>) -> Result<()> {
    let mut fresh = path.as_os_str().to_owned();
    fresh.push(".new");
    let fresh = PathBuf::from(fresh);
    let attempt = || -> Result<()> {
        let mut writer = BufWriter::new(File::create(&fresh)?);
        content(&mut writer)?;
        // Flush the data before the rename.
        writer.into_inner().map_err(std::io::IntoInnerError::into_error)?.sync_all()?;
        Ok(fs::rename(&fresh, path)?)
    };
    attempt().map_err(|error| {
        let _ = fs::remove_file(&fresh);
        error.context(format!("{}", path.display()))
    })
}

/// Makes a folder and sees that files can be made in it. Touches no file that is there.
pub fn prepare(folder: &Path) -> Result<()> {
    fs::create_dir_all(folder).with_context(|| format!("{}", folder.display()))?;
    let mut number = 0_u64;
    loop {
        // No case's folder begins with a dot.
        let trial = folder.join(format!(".mollis-{}-{number}", std::process::id()));
        match File::create_new(&trial) {
            Ok(_) => return fs::remove_file(&trial).with_context(|| format!("{}", trial.display())),
            Err(error) if error.kind() == ErrorKind::AlreadyExists => number += 1,
            Err(error) => return Err(error).with_context(|| format!("{}", folder.display())),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    /// What fails leaves neither a part of the new file nor any change of the old one.
    #[test]
    fn files_are_written_whole_or_not_at_all() {
        let folder = std::env::temp_dir().join(format!("mollis-whole-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let path = folder.join("file");
        write(&path, |file| Ok(file.write_all(b"old")?)).unwrap();
        let error = write(&path, |file| {
            file.write_all(b"new")?;
            anyhow::bail!("no more")
        });
        assert_eq!(format!("{:#}", error.unwrap_err()), format!("{}: no more", path.display()));
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);
        fs::remove_dir_all(&folder).unwrap();
        assert!(format!("{:#}", write(&path, |_| Ok(())).unwrap_err()).starts_with(&path.display().to_string()));
    }

    #[test]
    fn a_trial_touches_no_other_file() {
        let folder = std::env::temp_dir().join(format!("mollis-files-{}", std::process::id()));
        let taken = folder.join(format!(".mollis-{}-0", std::process::id()));
        prepare(&folder).unwrap();
        fs::write(&taken, "taken").unwrap();
        fs::create_dir(folder.join(format!(".mollis-{}-1", std::process::id()))).unwrap();
        prepare(&folder).unwrap();
        assert_eq!(
            (fs::read_to_string(&taken).unwrap().as_str(), fs::read_dir(&folder).unwrap().count()),
            ("taken", 2)
        );
        assert!(prepare(&taken).is_err());
        fs::remove_dir_all(&folder).unwrap();
    }
}
