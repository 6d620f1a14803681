//! Files of the disk, as the language and the composites want them.

use asm_lang::Loader;
use asm_lang::source::LoadError;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A larger text than this is not read: no person wrote it.
const MAX_BYTES: u64 = 32 << 20;

/// The files of the disk.
#[derive(Clone, Copy, Debug, Default)]
pub struct Disk;

impl Loader for Disk {
    fn read(&self, path: &str) -> Result<Arc<str>, LoadError> {
        let failed = |reason: String| LoadError {
            path: path.to_owned(),
            reason,
        };
        let about = std::fs::metadata(path).map_err(|error| failed(error.to_string()))?;
        if !about.is_file() {
            return Err(failed("it is not a file".to_owned()));
        }
        let length = about.len();
        if length > MAX_BYTES {
            return Err(failed(format!(
                "it has {length} bytes; at most {MAX_BYTES} are read"
            )));
        }
        let bytes = std::fs::read(path).map_err(|error| failed(error.to_string()))?;
        // what is no UTF-8 is shown as such by the lexer, at its place
        Ok(String::from_utf8_lossy(&bytes).into())
    }

    fn resolve(&self, from: &str, import: &str) -> Option<String> {
        let near = Path::new(from)
            .parent()
            .unwrap_or(Path::new(""))
            .join(import.replace('\\', "/"));
        let with_suffix = |path: &Path| PathBuf::from(format!("{}.asm", path.display()));
        let candidates = [
            near.clone(),
            with_suffix(&near),
            PathBuf::from(import),
            with_suffix(Path::new(import)),
        ];
        candidates
            .iter()
            .find(|path| path.is_file())
            .map(|path| tidy(path))
    }
}

/// The path without `.` and `a/..`, so that one file has one path.
fn tidy(path: &Path) -> String {
    let mut tidy = PathBuf::new();
    for part in path.components() {
        match part {
            std::path::Component::CurDir => {}
            std::path::Component::ParentDir if tidy.file_name().is_some() => {
                tidy.pop();
            }
            part => tidy.push(part),
        }
    }
    tidy.display().to_string()
}
