//! The source texts attached to a recording.

use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use asmotion_coordinator::MachineBegin;
use asmotion_lang::diagnostics::LoadError;
use asmotion_lang::{Loader, Specification};

use super::failure::ReplayFailure;

/// The beginning of the names of attached specifications: `specification/HASH/PATH`.
const SPECIFICATION: &str = "specification/";

/// A specification in the place of the recorded one. It is opened again for each machine, because what is watched there is
/// added to it.
#[derive(Debug)]
pub struct EditedSpecification {
    /// Name of the specification.
    pub name: String,
    path: String,
    sources: RecordedSources,
}

impl EditedSpecification {
    /// Takes the texts of a specification.
    pub fn of(specification: &Specification) -> Self {
        let sources = &specification.sources;
        let paths: Vec<_> = sources.paths().filter(|it| !it.starts_with('<')).collect();
        let text = |path: &&str| {
            let text = sources.shared_text(sources.find(path)?);
            Some((normal(Path::new(path)), text))
        };
        Self {
            name: specification.model.name.to_string(),
            path: paths.first().map_or_else(String::new, ToString::to_string),
            sources: RecordedSources {
                texts: paths.iter().filter_map(text).collect(),
            },
        }
    }

    /// Opens the specification.
    ///
    /// # Errors
    /// It has errors.
    pub(super) fn open(&self) -> Result<Specification, ReplayFailure> {
        opened(&self.path, &self.sources)
    }
}

fn opened(path: &str, sources: &RecordedSources) -> Result<Specification, ReplayFailure> {
    let opened = asmotion_lang::open(path, sources);
    opened.map_err(|failure| ReplayFailure::Specification {
        reason: failure.to_string(),
    })
}

/// Texts of specifications, by hash.
#[derive(Clone, Debug, Default)]
pub struct SourceTexts {
    texts: BTreeMap<String, Arc<str>>,
}

impl SourceTexts {
    /// Adds the text of an attachment, if it belongs to a specification.
    pub fn add(&mut self, attachment: &str, text: String) {
        let name = attachment.strip_prefix(SPECIFICATION);
        if let Some((hash, _)) = name.and_then(|name| name.split_once('/')) {
            self.texts.insert(hash.to_owned(), text.into());
        }
    }

    /// Opens the specification of a machine.
    ///
    /// # Errors
    /// A text is not attached, or the specification has errors.
    pub(super) fn open(&self, begin: &MachineBegin) -> Result<Specification, ReplayFailure> {
        let sources = self.of(begin)?;
        let path = begin.sources.first().map_or("", |source| &*source.path);
        opened(path, &sources)
    }

    /// Returns the files of a machine.
    ///
    /// # Errors
    /// A text is not attached.
    fn of(&self, begin: &MachineBegin) -> Result<RecordedSources, ReplayFailure> {
        let mut texts = BTreeMap::new();
        for source in &begin.sources {
            let text = self.texts.get(&source.hash);
            let text = text.ok_or_else(|| ReplayFailure::NoSource {
                path: source.path.clone(),
            })?;
            texts.insert(normal(Path::new(&source.path)), Arc::clone(text));
        }
        Ok(RecordedSources { texts })
    }
}

/// The files of a specification under the paths that they had in the run.
#[derive(Debug)]
struct RecordedSources {
    texts: BTreeMap<PathBuf, Arc<str>>,
}

impl Loader for RecordedSources {
    fn read(&self, path: &str) -> Result<Arc<str>, LoadError> {
        let text = self.texts.get(&normal(Path::new(path)));
        text.cloned().ok_or_else(|| LoadError {
            path: path.to_owned(),
            reason: "not among the files of the recording".to_owned(),
        })
    }

    /// Looks in the order in which files are looked for on a disk: what was found there is here.
    fn resolve(&self, from: &str, import: &str) -> Option<String> {
        let folder = Path::new(from).parent().unwrap_or(Path::new(""));
        let beside = folder.join(import.replace('\\', "/"));
        let with_suffix = |path: &Path| PathBuf::from(format!("{}.asm", path.display()));
        let import = Path::new(import);
        let candidates = [
            beside.clone(),
            with_suffix(&beside),
            import.to_owned(),
            with_suffix(import),
        ];
        let mut candidates = candidates.iter().map(|path| normal(path));
        let found = candidates.find(|path| self.texts.contains_key(path))?;
        Some(found.display().to_string())
    }
}

/// Removes `.` and `a/..` from a path, so that each file has one path.
fn normal(path: &Path) -> PathBuf {
    let mut normal = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir if normal.file_name().is_some() => {
                normal.pop();
            }
            Component::Prefix(_)
            | Component::RootDir
            | Component::ParentDir
            | Component::Normal(_) => normal.push(part),
        }
    }
    normal
}

#[cfg(test)]
mod tests {
    use super::*;
    use asmotion_coordinator::SourceRecord;

    #[test]
    fn imports_are_found_where_they_were_in_the_run() {
        let mut texts = SourceTexts::default();
        let mut begin = MachineBegin::default();
        let paths = ["../robot/main.asm", "../lib/own.asm", "lib/own.asm"];
        for (hash, path) in ["h1", "h2", "h3"].into_iter().zip(paths) {
            texts.add(&format!("specification/{hash}/{path}"), path.to_owned());
            begin.sources.push(SourceRecord {
                path: path.to_owned(),
                hash: hash.to_owned(),
                ..SourceRecord::default()
            });
        }
        texts.add("composite/lib/other.asm", String::new());
        let files = texts.of(&begin).expect("all are attached");
        let found = files.resolve("../robot/main.asm", "../lib/own");
        assert_eq!(found.as_deref(), Some("../lib/own.asm"));
        let read = |path: &str| files.read(path).map(|text| text.to_string()).ok();
        assert_eq!(read("../lib/own.asm").as_deref(), Some("../lib/own.asm"));
        assert_eq!(read("./lib/own.asm").as_deref(), Some("lib/own.asm"));
        assert_eq!(files.resolve("../robot/main.asm", "StandardLibrary"), None);
        begin.sources[0].hash = "h4".to_owned();
        let missing = texts.of(&begin).expect_err("the text is not attached");
        assert!(missing.to_string().contains("`../robot/main.asm`"));
    }
}
