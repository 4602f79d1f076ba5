//! Files that are whole at any time.

use std::fs::File;
#[cfg(unix)]
use std::fs::Permissions;
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use tempfile::{Builder, NamedTempFile};

/// Writes a file beside its place and renames it, so that under the name there is the old file or
/// the new one, whole, whatever happens. Links are followed; permissions of an old file are kept.
/// Devices, and others that are no files, are written to as they are.
///
/// # Errors
/// If the directory of the file cannot be written to, or the disk is full: the old file is
/// untouched.
pub fn replace_file(path: impl AsRef<Path>, contents: &[u8]) -> io::Result<()> {
    replace_file_with(path, |file| file.write_all(contents))
}

/// [`replace_file`] with contents that are written bit by bit.
///
/// # Errors
/// Those of [`replace_file`], and those of `write`: the old file is untouched.
pub fn replace_file_with(
    path: impl AsRef<Path>,
    write: impl FnOnce(&mut File) -> io::Result<()>,
) -> io::Result<()> {
    let path = path.as_ref();
    if is_special(path) {
        return write(&mut File::options().write(true).open(path)?);
    }
    let (path, mut file) = beside(path)?;
    write(file.as_file_mut())?;
    if let Ok(old) = std::fs::metadata(&path) {
        file.as_file().set_permissions(old.permissions())?;
    }
    // Else a crash of the machine could leave the name with an empty file.
    file.as_file().sync_all()?;
    file.persist(&path).map_err(|error| error.error)?;
    Ok(())
}

/// Finds out whether [`replace_file`] could write here, before there is something to write.
///
/// # Errors
/// If it could not.
pub fn check_replaceable(path: impl AsRef<Path>) -> io::Result<()> {
    let path = path.as_ref();
    if path.is_dir() {
        return Err(io::Error::new(ErrorKind::IsADirectory, "it is a directory"));
    }
    if is_special(path) { Ok(()) } else { beside(path).map(drop) }
}

fn is_special(path: &Path) -> bool {
    std::fs::metadata(path).is_ok_and(|metadata| !metadata.is_file() && !metadata.is_dir())
}

/// The path behind links, and a new file in its directory.
fn beside(path: &Path) -> io::Result<(PathBuf, NamedTempFile)> {
    let path = std::fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let directory = path.parent().filter(|directory| !directory.as_os_str().is_empty());
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let prefix = format!(".{name}.");
    let mut builder = Builder::new();
    builder.prefix(&prefix).suffix(".partial");
    #[cfg(unix)]
    builder.permissions(<Permissions as std::os::unix::fs::PermissionsExt>::from_mode(0o666));
    let file = builder.tempfile_in(directory.unwrap_or(Path::new(".")))?;
    Ok((path, file))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(directory: &Path) -> Vec<String> {
        let entries = std::fs::read_dir(directory).unwrap();
        let name = |entry: std::io::Result<std::fs::DirEntry>| entry.unwrap().file_name();
        entries.map(|entry| name(entry).to_string_lossy().into_owned()).collect()
    }

    #[test]
    fn files_are_replaced_and_nothing_is_left_beside_them() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("a.txt");
        check_replaceable(&path).unwrap();
        assert!(names(directory.path()).is_empty());
        for contents in [&b"first"[..], b"", b"third"] {
            replace_file(&path, contents).unwrap();
            assert_eq!(std::fs::read(&path).unwrap(), contents);
            assert_eq!(names(directory.path()), ["a.txt"]);
        }
        assert!(check_replaceable(directory.path()).is_err(), "a directory");
        assert!(replace_file(directory.path(), b"").is_err(), "a directory");
        assert!(check_replaceable(directory.path().join("none/a.txt")).is_err(), "no directory");
    }

    #[cfg(unix)]
    #[test]
    fn links_devices_and_permissions_stay_what_they_are() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let directory = tempfile::tempdir().unwrap();
        let [path, link] = ["a.txt", "link"].map(|name| directory.path().join(name));
        replace_file(&path, b"old").unwrap();
        std::fs::set_permissions(&path, Permissions::from_mode(0o640)).unwrap();
        symlink(&path, &link).unwrap();
        replace_file(&link, b"new").unwrap();
        assert!(std::fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(std::fs::read(&path).unwrap(), b"new");
        assert_eq!(std::fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o640);
        check_replaceable("/dev/null").unwrap();
        replace_file("/dev/null", b"new").unwrap();
        assert!(!std::fs::metadata("/dev/null").unwrap().is_file());
    }
}
