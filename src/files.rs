//! Loading of files from the disk for the language and the composites.

use asmotion_diagnostics::LoadError;
use asmotion_lang::Loader;
use std::collections::BTreeMap;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::SystemTime;

/// Path of standard input, which is named `-` on the command line.
pub const STANDARD_INPUT: &str = "<stdin>";

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
        if path == STANDARD_INPUT {
            // the lexer reports text that is not UTF-8 at its place
            return Ok(String::from_utf8_lossy(standard_input()?).into());
        }
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

/// Loads files from the disk and notes how they were before they were read, so that later changes are noticed.
#[derive(Debug, Default)]
pub struct NotedFiles(Mutex<FileStamps>);

/// Files, each with what changes when it is written or replaced; `None` for one that is missing.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FileStamps(BTreeMap<PathBuf, Option<FileStamp>>);

/// Time of the last change, length, and number of the file.
type FileStamp = (SystemTime, u64, u64);

impl NotedFiles {
    /// Forgets all files.
    pub fn forget(&self) {
        self.stamps().0.clear();
    }

    /// Returns `true` if a file differs from what was noted, one that was missing has appeared, or one is missing.
    pub fn have_changed(&self) -> bool {
        self.look() != *self.stamps()
    }

    /// Returns the noted files as they are now.
    pub fn look(&self) -> FileStamps {
        let paths: Vec<PathBuf> = self.stamps().0.keys().cloned().collect();
        let stamps = paths.into_iter().map(|path| {
            let stamp = FileStamps::of(&path);
            (path, stamp)
        });
        FileStamps(stamps.collect())
    }

    /// Returns `true` if a file that was there is missing now.
    pub fn are_missing(&self, now: &FileStamps) -> bool {
        let noted = self.stamps();
        let mut pairs = noted.0.iter().zip(now.0.values());
        pairs.any(|((_, before), now)| before.is_some() && now.is_none())
    }

    /// Notes how a file is, unless it is known.
    fn note(&self, path: &Path) {
        let stamp = FileStamps::of(path);
        self.stamps().0.entry(path.to_owned()).or_insert(stamp);
    }

    fn stamps(&self) -> MutexGuard<'_, FileStamps> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl FileStamps {
    fn of(path: &Path) -> Option<FileStamp> {
        let about = std::fs::metadata(path).ok().filter(|it| it.is_file())?;
        #[cfg(unix)]
        let number = std::os::unix::fs::MetadataExt::ino(&about);
        #[cfg(not(unix))]
        let number = 0;
        Some((about.modified().ok()?, about.len(), number))
    }
}

impl Loader for NotedFiles {
    fn read(&self, path: &str) -> Result<Arc<str>, LoadError> {
        self.note(Path::new(path));
        DiskLoader.read(path)
    }

    fn resolve(&self, from: &str, import: &str) -> Option<String> {
        let candidates = candidates(from, import);
        // a file that appears later at one of these paths is the one that is meant
        for path in &candidates {
            self.note(path);
            if path.is_file() {
                break;
            }
        }
        DiskLoader.resolve(from, import)
    }
}

/// Returns the bytes on standard input, which is read once.
///
/// # Errors
/// Fails if it cannot be read, or is too long.
pub fn standard_input() -> Result<&'static [u8], LoadError> {
    static BYTES: OnceLock<Result<Vec<u8>, String>> = OnceLock::new();
    let read = || {
        let mut bytes = Vec::new();
        let mut input = std::io::stdin().lock().take(MAX_BYTES + 1);
        match input.read_to_end(&mut bytes) {
            Err(error) => Err(reason(&error)),
            Ok(length) if length as u64 > MAX_BYTES => {
                Err(format!("it has more than {MAX_BYTES} bytes"))
            }
            Ok(_) => Ok(bytes),
        }
    };
    BYTES
        .get_or_init(read)
        .as_deref()
        .map_err(|reason| LoadError {
            path: STANDARD_INPUT.to_owned(),
            reason: reason.clone(),
        })
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
