//! Files in memory, for tests and for texts embedded in a binary.

use asmotion_diagnostics::{LoadError, Loader};
use std::collections::BTreeMap;
use std::sync::Arc;

/// A loader for texts in memory. Paths are normalised: `.` and `..` are resolved.
#[derive(Clone, Debug, Default)]
pub struct MemoryFiles {
    texts: BTreeMap<String, Arc<str>>,
}

impl MemoryFiles {
    /// Creates an empty collection.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a file, replacing one with the same path.
    pub fn add(&mut self, path: &str, text: impl Into<Arc<str>>) {
        self.texts.insert(normal(path), text.into());
    }
}

impl Loader for MemoryFiles {
    fn read(&self, path: &str) -> Result<Arc<str>, LoadError> {
        self.texts
            .get(&normal(path))
            .cloned()
            .ok_or_else(|| LoadError {
                path: path.to_owned(),
                reason: "file not found".to_owned(),
            })
    }

    fn resolve(&self, from: &str, import: &str) -> Option<String> {
        let folder = from.rsplit_once('/').map_or("", |(folder, _)| folder);
        let sibling = normal(&format!("{folder}/{import}"));
        let candidates = [
            sibling.clone(),
            format!("{sibling}.asm"),
            normal(import),
            normal(&format!("{import}.asm")),
        ];
        candidates
            .into_iter()
            .find(|path| self.texts.contains_key(path))
    }
}

fn normal(path: &str) -> String {
    let mut parts: Vec<&str> = Vec::new();
    for part in path.split(['/', '\\']) {
        match part {
            "" | "." => {}
            ".." => {
                parts.pop();
            }
            part => parts.push(part),
        }
    }
    parts.join("/")
}
