//! The files that a scene may read, and a budget for their size.

use super::{Error, Limits, Location};
use std::fs::File;
use std::io::Read;
use std::path::{Component, Path, PathBuf};

/// Each file is looked for in all of them.
const MOST_DIRECTORIES: usize = 64;

/// Finds and reads the files that a scene refers to, within the limits.
#[derive(Debug)]
pub(crate) struct Files {
    /// The directories in which relative paths are looked for; the first is that of the scene.
    directories: Vec<PathBuf>,
    /// The directory of the scene without links; what is not below it is refused.
    root: PathBuf,
    outside_files: bool,
    bytes_left: u64,
}

impl Files {
    /// The files of the scene that a file describes.
    pub fn new(scene: &Path, limits: &Limits) -> Result<Self, Error> {
        let directory = scene
            .parent()
            .filter(|parent| !parent.as_os_str().is_empty())
            .unwrap_or(Path::new("."))
            .to_owned();
        let at = || Location { file: scene.to_owned(), ..Location::default() };
        let root = directory.canonicalize().map_err(|error| Error::caused(at(), error))?;
        Ok(Self {
            directories: vec![directory],
            root,
            outside_files: limits.outside_files,
            bytes_left: limits.bytes,
        })
    }

    /// The files of a scene that was given as bytes, which may refer to no others.
    #[cfg(feature = "gltf")]
    pub fn none(limits: &Limits) -> Self {
        Self {
            directories: Vec::new(),
            root: PathBuf::new(),
            outside_files: false,
            bytes_left: limits.bytes,
        }
    }

    /// Adds a directory where relative paths are looked for, after the others.
    pub fn add_directory(&mut self, path: &str, location: Location) -> Result<(), Error> {
        if self.directories.len() >= MOST_DIRECTORIES {
            return Err(Error::limit(
                location,
                format!("files are looked for in more than {MOST_DIRECTORIES} directories"),
            ));
        }
        let directory = self.allowed(path, &location)?;
        self.directories.push(directory);
        Ok(())
    }

    /// Reads a file that the scene refers to by `name`; also returns its path.
    pub fn read(&mut self, name: &str, location: Location) -> Result<(PathBuf, Vec<u8>), Error> {
        let path = self.allowed(name, &location)?;
        let bytes = self.read_path(&path, location)?;
        Ok((path, bytes))
    }

    /// Reads a file that the user has named.
    pub fn read_path(&mut self, path: &Path, location: Location) -> Result<Vec<u8>, Error> {
        let fail = |location: Location, error: std::io::Error| Error {
            reason: format!("{}: {error}", path.display()),
            ..Error::caused(location, error)
        };
        // Before it is opened: a pipe waits for its writer, and a device may do anything.
        let length = match std::fs::metadata(path) {
            Ok(metadata) if metadata.is_file() => metadata.len(),
            Ok(_) => return Err(Error::new(location, format!("{} is not a file", path.display()))),
            Err(error) => return Err(fail(location, error)),
        };
        if length > self.bytes_left {
            self.spend(length, location.clone())?;
        }
        let file = match File::open(path) {
            Ok(file) => file,
            Err(error) => return Err(fail(location, error)),
        };
        let mut bytes = Vec::new();
        match file.take(self.bytes_left.saturating_add(1)).read_to_end(&mut bytes) {
            Err(error) => Err(fail(location, error)),
            Ok(_) => {
                self.spend(bytes.len() as u64, location)?;
                Ok(bytes)
            }
        }
    }

    /// The number of bytes that may still be read.
    pub fn bytes_left(&self) -> u64 {
        self.bytes_left
    }

    /// Counts bytes that have been read or decompressed.
    pub fn spend(&mut self, bytes: u64, location: Location) -> Result<(), Error> {
        let left = self.bytes_left.checked_sub(bytes);
        self.bytes_left = left.ok_or_else(|| {
            Error::limit(location, "the files of the scene have more bytes than the limit admits")
        })?;
        Ok(())
    }

    /// The file or directory of a name, if the scene may refer to it.
    fn allowed(&self, name: &str, location: &Location) -> Result<PathBuf, Error> {
        let refuse = |reason: String| Err(Error::new(location.clone(), reason));
        if name.is_empty() || name.contains('\0') {
            return refuse("the name of the file is empty or has a NUL in it".to_owned());
        }
        if self.directories.is_empty() {
            return refuse(format!(
                "{name} is another file, and only bytes of the scene are given"
            ));
        }
        let plain = Path::new(name)
            .components()
            .all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
        if !plain && !self.outside_files {
            return refuse(format!(
                "{name} may lie outside of the scene's directory; set `outside_files` to allow it"
            ));
        }
        let Some(path) = self
            .directories
            .iter()
            .map(|directory| directory.join(name))
            .find(|path| path.exists())
        else {
            return refuse(format!("there is no file {name}"));
        };
        // A symbolic link may lead out, too.
        let inside = path.canonicalize().is_ok_and(|path| path.starts_with(&self.root));
        if !inside && !self.outside_files {
            return refuse(format!(
                "{name} is a link out of the scene's directory; set `outside_files` to allow it"
            ));
        }
        Ok(path)
    }
}
