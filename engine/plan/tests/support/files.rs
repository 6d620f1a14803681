//! Files of a folder, addressed by relative paths.

use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use asmotion_diagnostics::{LoadError, Loader};

/// A loader for the files of a folder.
pub struct Files {
    folder: PathBuf,
}

impl Files {
    pub fn new(folder: &str) -> Self {
        Self {
            folder: PathBuf::from(folder),
        }
    }
}

impl Loader for Files {
    fn read(&self, path: &str) -> Result<Arc<str>, LoadError> {
        let text = std::fs::read_to_string(self.folder.join(path));
        text.map(Arc::from).map_err(|error| LoadError {
            path: path.to_owned(),
            reason: error.kind().to_string(),
        })
    }

    fn resolve(&self, from: &str, import: &str) -> Option<String> {
        let path = Path::new(from).parent()?.join(import);
        let mut plain = PathBuf::new();
        for part in path.components() {
            match part {
                Component::ParentDir => {
                    plain.pop();
                }
                Component::CurDir => {}
                Component::Prefix(_) | Component::RootDir | Component::Normal(_) => {
                    plain.push(part)
                }
            }
        }
        // the extension of a specification may be omitted
        let candidates = [plain.clone(), plain.with_extension("asm")];
        candidates
            .iter()
            .find(|path| self.folder.join(path).is_file())
            .map(|path| path.to_string_lossy().into_owned())
    }
}
