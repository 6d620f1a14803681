//! Sources of map files: the disk, or memory.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{ErrorKind, Read};
use std::path::Path;

/// A source of files. Names are paths with `/`. `Sync`, because maps are loaded in background work.
pub trait FileSource: Send + Sync {
    /// Reads a whole file; fails if it has more than `limit` bytes.
    ///
    /// # Errors
    /// [`FileFault::Missing`] if there is no such file, [`FileFault::TooLong`] beyond `limit`, [`FileFault::Other`] if
    /// it cannot be read.
    fn read(&self, name: &str, limit: u64) -> Result<Vec<u8>, FileFault>;

    /// The names of the files in a folder, without the folder's name, sorted.
    ///
    /// # Errors
    /// [`FileFault::Missing`] if there is no such folder, [`FileFault::Other`] if it cannot be read.
    fn list(&self, folder: &str) -> Result<Vec<String>, FileFault>;

    /// Returns whether `name` is a folder.
    fn is_folder(&self, name: &str) -> bool;

    /// A value that differs after the file has changed; `None` if there is no such file.
    fn version(&self, name: &str) -> Option<u128>;
}

/// Reason why a file cannot be read.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FileFault {
    /// The file does not exist.
    #[error("file not found")]
    Missing,
    /// The file is longer than the limit.
    #[error("is too long")]
    TooLong,
    /// Any other error, with the operating system's message.
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

/// The files of the local disk.
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

/// Files in memory, for tests and for maps received in messages.
#[derive(Clone, Debug, Default)]
pub struct FilesInMemory(BTreeMap<String, Vec<u8>>);

impl FilesInMemory {
    /// A source with these files.
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

/// Reads a stream to its end; fails if it has more than `limit` bytes.
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
