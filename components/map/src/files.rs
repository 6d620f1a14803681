//! Sources of map files: the disk, or memory.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{ErrorKind, Read};
use std::path::Path;

/// Gives the bytes of named files. Names are paths with `/`. Maps are loaded beside the server's cycle, hence `Sync`.
pub trait FileSource: Send + Sync {
    /// The whole file, but never more than `limit` bytes.
    ///
    /// # Errors
    /// [`FileFault::Missing`] if there is no such file, [`FileFault::TooLong`] beyond `limit`, [`FileFault::Other`] if
    /// it cannot be read.
    fn read(&self, name: &str, limit: u64) -> Result<Vec<u8>, FileFault>;

    /// The names of the files in a folder, without the folder's, sorted.
    ///
    /// # Errors
    /// [`FileFault::Missing`] if there is no such folder, [`FileFault::Other`] if it cannot be read.
    fn list(&self, folder: &str) -> Result<Vec<String>, FileFault>;

    /// Returns whether `name` is a folder.
    fn is_folder(&self, name: &str) -> bool;

    /// Something that is another value once the file has changed; none if there is no such file.
    fn version(&self, name: &str) -> Option<u128>;
}

/// Reason why a file cannot be read.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FileFault {
    /// No such file.
    #[error("there is no such file")]
    Missing,
    /// More bytes than the limit.
    #[error("is too long")]
    TooLong,
    /// Anything else, in the system's words.
    #[error("{0}")]
    Other(String),
}

impl From<std::io::Error> for FileFault {
    fn from(error: std::io::Error) -> Self {
        if error.kind() == ErrorKind::NotFound {
            Self::Missing
        } else {
            Self::Other(error.to_string())
        }
    }
}

/// The files of this machine.
#[derive(Clone, Copy, Debug, Default)]
pub struct DiskFiles;

impl FileSource for DiskFiles {
    fn read(&self, name: &str, limit: u64) -> Result<Vec<u8>, FileFault> {
        read_at_most(File::open(name)?, limit)
    }

    fn list(&self, folder: &str) -> Result<Vec<String>, FileFault> {
        let mut names = Vec::new();
        for entry in std::fs::read_dir(folder)? {
            names.extend(entry?.file_name().into_string());
        }
        names.sort();
        Ok(names)
    }

    fn is_folder(&self, name: &str) -> bool {
        Path::new(name).is_dir()
    }

    fn version(&self, name: &str) -> Option<u128> {
        let about = std::fs::metadata(name).ok()?;
        let changed = about.modified().ok()?;
        let since = changed.duration_since(std::time::UNIX_EPOCH).ok()?;
        Some((since.as_nanos() << 40) | u128::from(about.len() & 0xff_ffff_ffff))
    }
}

/// Files that exist in memory only: tests, and maps that came by message.
#[derive(Clone, Debug, Default)]
pub struct FilesInMemory(BTreeMap<String, Vec<u8>>);

impl FilesInMemory {
    /// These files.
    pub fn new<Name: Into<String>, Bytes: Into<Vec<u8>>>(
        files: impl IntoIterator<Item = (Name, Bytes)>,
    ) -> Self {
        let named = |(name, bytes): (Name, Bytes)| (name.into(), bytes.into());
        Self(files.into_iter().map(named).collect())
    }
}

impl FileSource for FilesInMemory {
    fn read(&self, name: &str, limit: u64) -> Result<Vec<u8>, FileFault> {
        let bytes = self.0.get(name).ok_or(FileFault::Missing)?;
        read_at_most(&bytes[..], limit)
    }

    fn list(&self, folder: &str) -> Result<Vec<String>, FileFault> {
        let prefix = format!("{}/", folder.trim_end_matches('/'));
        let names = self.0.keys().filter_map(|name| name.strip_prefix(&prefix));
        Ok(names.map(str::to_owned).collect())
    }

    fn is_folder(&self, name: &str) -> bool {
        let prefix = format!("{}/", name.trim_end_matches('/'));
        self.0.keys().any(|name| name.starts_with(&prefix))
    }

    fn version(&self, name: &str) -> Option<u128> {
        let bytes = self.0.get(name)?;
        // FNV-1a over the content
        let hash = |hash: u64, byte: &u8| (hash ^ u64::from(*byte)).wrapping_mul(0x100_0000_01b3);
        Some(u128::from(bytes.iter().fold(0xcbf2_9ce4_8422_2325, hash)))
    }
}

/// All bytes of a stream, unless they are more than `limit`.
pub fn read_at_most(stream: impl Read, limit: u64) -> Result<Vec<u8>, FileFault> {
    let mut bytes = Vec::new();
    stream
        .take(limit.saturating_add(1))
        .read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit {
        return Err(FileFault::TooLong);
    }
    Ok(bytes)
}
