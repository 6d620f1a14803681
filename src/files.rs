//! Loading of files from the disk for the language and the composites.

use asmotion_diagnostics::LoadError;
use asmotion_lang::Loader;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
#[cfg(feature = "amqp")]
use std::sync::{Mutex, PoisonError};

/// Upper bound on the size of a text file.
const MAX_BYTES: u64 = 32 << 20;

/// Loads files from the disk.
#[derive(Clone, Copy, Debug, Default)]
pub struct DiskLoader;

impl Loader for DiskLoader {
    fn read(&self, path: &str) -> Result<Arc<str>, LoadError> {
        let failed = |reason: String| LoadError {
            path: path.to_owned(),
            reason,
        };
        let about = std::fs::metadata(path).map_err(|error| failed(reason(&error)))?;
        if !about.is_file() {
            return Err(failed("it is not a file".to_owned()));
        }
        let length = about.len();
        if length > MAX_BYTES {
            return Err(failed(format!(
                "it has {length} bytes; at most {MAX_BYTES} are read"
            )));
        }
        let bytes = std::fs::read(path).map_err(|error| failed(reason(&error)))?;
        // the lexer reports text that is not UTF-8 at its place
        Ok(String::from_utf8_lossy(&bytes).into())
    }

    fn resolve(&self, from: &str, import: &str) -> Option<String> {
        let candidates = candidates(from, import);
        let found = candidates.iter().find(|path| path.is_file());
        found.map(|path| normalize(path))
    }
}

/// Candidate paths of an imported file, best first.
fn candidates(from: &str, import: &str) -> [PathBuf; 4] {
    let folder = Path::new(from).parent().unwrap_or(Path::new(""));
    let beside = folder.join(import.replace('\\', "/"));
    let with_suffix = |path: &Path| PathBuf::from(format!("{}.asm", path.display()));
    [
        beside.clone(),
        with_suffix(&beside),
        PathBuf::from(import),
        with_suffix(Path::new(import)),
    ]
}

/// Loads files through another loader and records them.
#[cfg(feature = "amqp")]
pub struct Remembering<'a> {
    files: &'a dyn Loader,
    read: Mutex<BTreeMap<String, Arc<str>>>,
}

#[cfg(feature = "amqp")]
impl<'a> Remembering<'a> {
    /// Wraps a loader.
    pub fn new(files: &'a dyn Loader) -> Self {
        let read = Mutex::default();
        Self { files, read }
    }

    /// Paths and texts of the loaded files.
    pub fn read(&self) -> BTreeMap<String, Arc<str>> {
        let read = self.read.lock().unwrap_or_else(PoisonError::into_inner);
        read.clone()
    }
}

#[cfg(feature = "amqp")]
impl Loader for Remembering<'_> {
    fn read(&self, path: &str) -> Result<Arc<str>, LoadError> {
        let text = self.files.read(path)?;
        let mut read = self.read.lock().unwrap_or_else(PoisonError::into_inner);
        read.insert(path.to_owned(), text.clone());
        Ok(text)
    }

    fn resolve(&self, from: &str, import: &str) -> Option<String> {
        self.files.resolve(from, import)
    }
}

/// Files received over the bus, addressed as if they were in a folder of the disk.
pub struct SentFiles {
    folder: PathBuf,
    texts: BTreeMap<String, Arc<str>>,
}

impl SentFiles {
    /// Places files in the folder of `path`; their paths are relative to it.
    pub fn in_folder_of(path: &str, files: &[(String, String)]) -> Self {
        let folder = Path::new(path).parent().unwrap_or(Path::new(""));
        let mut sent = Self {
            folder: folder.to_owned(),
            texts: BTreeMap::new(),
        };
        for (path, text) in files {
            sent.texts.insert(sent.path(path), text.as_str().into());
        }
        sent
    }

    /// The full path of one of the files.
    pub fn path(&self, path: &str) -> String {
        normalize(&self.folder.join(path))
    }
}

impl Loader for SentFiles {
    fn read(&self, path: &str) -> Result<Arc<str>, LoadError> {
        self.texts.get(path).cloned().ok_or_else(|| LoadError {
            path: path.to_owned(),
            reason: "not among the files sent".to_owned(),
        })
    }

    fn resolve(&self, from: &str, import: &str) -> Option<String> {
        let candidates = candidates(from, import);
        let mut paths = candidates.iter().map(|path| normalize(path));
        paths.find(|path| self.texts.contains_key(path))
    }
}

/// Reason of an I/O error, for the user.
pub fn reason(error: &std::io::Error) -> String {
    #[expect(
        clippy::wildcard_enum_match_arm,
        reason = "the enum of the standard library is open"
    )]
    match error.kind() {
        std::io::ErrorKind::NotFound => "file not found".to_owned(),
        std::io::ErrorKind::PermissionDenied => "permission denied".to_owned(),
        _ => error.to_string(),
    }
}

/// Removes `.` and `a/..` from a path, so that each file has one path.
fn normalize(path: &Path) -> String {
    let mut normalized = PathBuf::new();
    for part in path.components() {
        match part {
            std::path::Component::CurDir => {}
            std::path::Component::ParentDir if normalized.file_name().is_some() => {
                normalized.pop();
            }
            std::path::Component::Prefix(_)
            | std::path::Component::RootDir
            | std::path::Component::ParentDir
            | std::path::Component::Normal(_) => normalized.push(part),
        }
    }
    normalized.display().to_string()
}

/// Replaces the text of a file atomically: readers see the old text or the new one.
pub fn rewrite(path: &str, before: &str, after: &str) -> std::io::Result<()> {
    // resolves a symbolic link, which would otherwise be replaced by a file
    let path = std::fs::canonicalize(path)?;
    if std::fs::read(&path)? != before.as_bytes() {
        return Err(std::io::Error::other(
            "not UTF-8, or changed while it was read",
        ));
    }
    let folder = path.parent().unwrap_or(Path::new("."));
    let mut new = tempfile::NamedTempFile::new_in(folder)?;
    new.write_all(after.as_bytes())?;
    new.as_file()
        .set_permissions(std::fs::metadata(&path)?.permissions())?;
    new.as_file().sync_all()?;
    new.persist(&path).map_err(|failed| failed.error)?;
    Ok(())
}
