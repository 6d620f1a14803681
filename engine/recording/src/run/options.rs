//! Options of a recording, and its files.

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io;
use std::path::{Path, PathBuf};

use asmotion_datum::Schema;

use crate::profile::RecordingProfile;

/// The reaction to a full queue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Overflow {
    /// Wait for the disk: in virtual time, which stands still meanwhile.
    Wait,
    /// Drop the message and count it: in real time, which does not.
    Count,
}

/// Options of a recording.
#[derive(Clone, Debug)]
pub struct RecorderOptions {
    /// Ports and topics whose samples are recorded, as patterns; all of them if this is empty.
    pub ports: Vec<String>,
    /// `true` to record calls and replies.
    pub calls: bool,
    /// `true` to record the steps of coordinators.
    pub steps: bool,
    /// Size at which a further file begins, in bytes.
    pub rotate_bytes: Option<u64>,
    /// Readers of the recording.
    pub profile: RecordingProfile,
    /// Reaction to a full queue.
    pub overflow: Overflow,
    /// Time of the beginning of the run, in nanoseconds since 1970; 0 in virtual time.
    pub epoch_ns: u64,
    /// Facts about the run: version, composite, process, clock, seed.
    pub facts: BTreeMap<String, String>,
    /// Texts to attach, by name: the composite and its expansion.
    pub texts: BTreeMap<String, String>,
    /// Message types of ports (`Component.port`) and of topics (`topic:name`), with their schemas.
    pub types: BTreeMap<String, Schema>,
}

impl Default for RecorderOptions {
    fn default() -> Self {
        Self {
            ports: Vec::new(),
            calls: true,
            steps: true,
            rotate_bytes: None,
            profile: RecordingProfile::default(),
            overflow: Overflow::Wait,
            epoch_ns: 0,
            facts: BTreeMap::new(),
            texts: BTreeMap::new(),
            types: BTreeMap::new(),
        }
    }
}

/// The name of a recording. A file that exists is not overwritten: the new one gets a number.
#[derive(Clone, Debug)]
pub struct RecordingFile {
    path: PathBuf,
}

/// Limit for the numbers of files with one name.
const MAX_NUMBER: u32 = 10_000;

impl RecordingFile {
    /// A recording with this name, or with a number behind it: `run.mcap`, `run-2.mcap`.
    pub fn new(path: impl Into<PathBuf>) -> Self {
        Self { path: path.into() }
    }

    /// The name as given.
    pub(super) fn name(&self) -> String {
        self.path.display().to_string()
    }

    /// Creates the file, and its folder.
    pub(super) fn create(&self) -> io::Result<(PathBuf, File)> {
        if let Some(folder) = self.path.parent().filter(|it| !it.as_os_str().is_empty()) {
            std::fs::create_dir_all(folder)?;
        }
        let mut number = 1;
        loop {
            let path = self.numbered(number);
            match OpenOptions::new().write(true).create_new(true).open(&path) {
                Ok(file) => return Ok((path, file)),
                Err(error)
                    if error.kind() == io::ErrorKind::AlreadyExists && number < MAX_NUMBER =>
                {
                    // a device or a pipe is meant as it is
                    if is_special(&path) {
                        return Ok((path.clone(), OpenOptions::new().write(true).open(&path)?));
                    }
                    number += 1;
                }
                Err(error) => return Err(error),
            }
        }
    }

    /// The name of a part of a recording whose first file is this one: `run.part2.mcap`.
    pub(super) fn part(&self, number: u32) -> Self {
        Self::new(part_path(&self.path, number))
    }

    fn numbered(&self, number: u32) -> PathBuf {
        if number == 1 {
            return self.path.clone();
        }
        let stem = self.path.file_stem().unwrap_or_default().to_string_lossy();
        let suffix = self.path.extension().unwrap_or_default().to_string_lossy();
        self.path
            .with_file_name(format!("{stem}-{number}.{suffix}"))
    }
}

/// The usual path of a part of the recording that begins with a file, or to which a part belongs.
pub fn part_path(file: &Path, number: u32) -> PathBuf {
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    let stem = match stem.rsplit_once(".part") {
        Some((first, part)) if part.parse::<u32>().is_ok() => first,
        Some(_) | None => &stem,
    };
    file.with_file_name(format!("{stem}.part{number}.mcap"))
}

fn is_special(path: &Path) -> bool {
    std::fs::metadata(path).is_ok_and(|about| !about.is_file() && !about.is_dir())
}
