//! The files of a recording, in order.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::read::RecordingError;
use crate::run::{FileEnd, RecordingItem, RunReader};

/// The fact that distinguishes the files of one run.
const PART: &str = "part";

/// A recording that may be divided into several files.
#[derive(Clone, Debug)]
pub struct RunFiles {
    /// The first file; for a file whose predecessors are not given, that file.
    pub path: PathBuf,
    /// Number of the file among those of its run, from 1.
    pub part: u32,
    /// Facts about the run.
    pub facts: BTreeMap<String, String>,
    /// Files that may continue it.
    others: Vec<PathBuf>,
}

/// The items of a recording, across all its files.
pub struct RunItems {
    reader: RunReader,
    files: RunFiles,
    /// Number of the open file.
    part: u32,
    is_done: bool,
}

impl RunFiles {
    /// Groups files to recordings, in the order of their first files. Files that cannot be read are returned with the reason.
    pub fn group(paths: &[PathBuf]) -> Vec<Result<Self, (PathBuf, String)>> {
        let opened = paths.iter().map(|path| match RunReader::open(path) {
            Ok(reader) => Ok(Self {
                path: path.clone(),
                part: reader.part(),
                facts: shared_facts(reader.facts()),
                others: paths.to_vec(),
            }),
            Err(error) => Err((path.clone(), error.to_string())),
        });
        let opened: Vec<_> = opened.collect();
        let firsts: Vec<_> = opened.iter().flatten().filter(|it| it.part == 1).collect();
        let firsts: Vec<_> = firsts.iter().map(|it| it.facts.clone()).collect();
        let continues = |files: &Self| files.part > 1 && firsts.contains(&files.facts);
        let groups = opened.into_iter().filter(|files| match files {
            Ok(files) => !continues(files),
            Err(_) => true,
        });
        groups.collect()
    }

    /// Opens the recording.
    ///
    /// # Errors
    /// The first file cannot be read any more.
    pub fn items(&self) -> Result<RunItems, RecordingError> {
        Ok(RunItems {
            reader: RunReader::open(&self.path)?,
            files: self.clone(),
            part: self.part,
            is_done: false,
        })
    }

    /// Opens the file with this number: one of those given, or another one in the folder of the first.
    fn open_part(&self, part: u32) -> Option<RunReader> {
        let is_it = |path: &Path| {
            let reader = RunReader::open(path).ok()?;
            let is_it = reader.part() == part && shared_facts(reader.facts()) == self.facts;
            is_it.then_some(reader)
        };
        let given = self.others.iter().find_map(|path| is_it(path));
        given.or_else(|| {
            let folder = self.path.parent().unwrap_or(Path::new(""));
            let folder = if folder.as_os_str().is_empty() {
                Path::new(".")
            } else {
                folder
            };
            let entries = std::fs::read_dir(folder).ok()?;
            let mut paths: Vec<_> = entries.flatten().map(|entry| entry.path()).collect();
            paths.sort();
            let recordings = paths
                .iter()
                .filter(|path| path.extension() == self.path.extension());
            recordings.map(PathBuf::as_path).find_map(is_it)
        })
    }
}

/// The facts that all files of a run share.
fn shared_facts(facts: &BTreeMap<String, String>) -> BTreeMap<String, String> {
    let shared = facts.iter().filter(|(name, _)| *name != PART);
    shared
        .map(|(name, value)| (name.clone(), value.clone()))
        .collect()
}

impl Iterator for RunItems {
    type Item = RecordingItem;

    fn next(&mut self) -> Option<RecordingItem> {
        while !self.is_done {
            match self.reader.next() {
                Some(RecordingItem::End(FileEnd {
                    continues: Some(part),
                    ..
                })) if part > self.part => match self.files.open_part(part) {
                    Some(reader) => {
                        self.reader = reader;
                        self.part = part;
                    }
                    None => {
                        self.is_done = true;
                        let reason = format!("part {part} of it is missing");
                        return Some(RecordingItem::Cut(reason));
                    }
                },
                item => return item,
            }
        }
        None
    }
}
