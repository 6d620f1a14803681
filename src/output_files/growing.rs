//! Files that grow while a run goes on, so that a process that is killed leaves what was recorded until then.

use std::fs::{File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use asmotion_recording::PortRecording;

use crate::trace::MissionTrace;

/// Longest time between an event and its appearance in the file, while events arrive.
const DELAY: Duration = Duration::from_millis(500);

/// Length of waiting text that is written at once.
const LARGE: usize = 1 << 16;

/// Size up to which a table is copied for each new column.
const SMALL_TABLE: u64 = 16 << 20;

/// Time between copies of a larger table for new columns.
const BETWEEN_COPIES: Duration = Duration::from_secs(60);

/// A file that was opened before the run and is emptied with the first event: a run that is refused leaves an earlier file as
/// it is.
#[derive(Debug)]
struct OutputFile {
    path: String,
    file: File,
    /// The file was not there before.
    is_new: bool,
    is_begun: bool,
    /// Time of the last write.
    written: Instant,
}

impl OutputFile {
    fn open(path: &str) -> io::Result<Self> {
        let is_new = !Path::new(path).exists();
        let mut options = OpenOptions::new();
        let file = options
            .write(true)
            .create(true)
            .truncate(false)
            .open(path)?;
        Ok(Self {
            path: path.to_owned(),
            file,
            is_new,
            is_begun: false,
            written: Instant::now(),
        })
    }

    /// Empties the file when the run begins.
    fn begin(&mut self) -> io::Result<()> {
        if !self.is_begun {
            self.is_begun = true;
            if self.is_regular() {
                self.file.set_len(0)?;
            }
        }
        Ok(())
    }

    /// `false` for a pipe or a device.
    fn is_regular(&self) -> bool {
        self.file.metadata().is_ok_and(|about| about.is_file())
    }

    fn is_due(&self) -> bool {
        self.written.elapsed() >= DELAY
    }
}

impl Drop for OutputFile {
    fn drop(&mut self) {
        if self.is_new && !self.is_begun {
            // the run never began: an empty file would be taken for its result
            let _ = std::fs::remove_file(&self.path);
        }
    }
}

/// A trace on the disk.
#[derive(Debug)]
pub struct TraceFile {
    trace: MissionTrace,
    output: OutputFile,
}

impl TraceFile {
    /// Opens the file.
    ///
    /// # Errors
    /// Fails if it cannot be written.
    pub fn open(path: &str) -> io::Result<Self> {
        Ok(Self {
            trace: MissionTrace::new(),
            output: OutputFile::open(path)?,
        })
    }

    /// Path of the file.
    pub fn path(&self) -> &str {
        &self.output.path
    }

    /// The lines that are not in the file yet.
    pub fn trace(&mut self) -> &mut MissionTrace {
        &mut self.trace
    }

    /// Writes the waiting lines if it is time to.
    ///
    /// # Errors
    /// Fails if they cannot be written.
    pub fn write_due(&mut self) -> io::Result<()> {
        if self.output.is_due() || self.trace.text().len() >= LARGE {
            self.write()
        } else {
            Ok(())
        }
    }

    /// Writes the waiting lines.
    ///
    /// # Errors
    /// Fails if they cannot be written.
    pub fn write(&mut self) -> io::Result<()> {
        let text = self.trace.take_text();
        self.output.begin()?;
        self.output.file.write_all(text.as_bytes())?;
        self.output.written = Instant::now();
        Ok(())
    }
}

/// A table of the values of ports on the disk. All its rows have the columns of its header at any time: a new column is added by
/// copying the table, and rows with new columns wait until then.
#[derive(Debug)]
pub struct TableFile {
    recording: PortRecording,
    output: OutputFile,
    /// Number of columns in the file, without the time; `None` until it has a header.
    columns: Option<usize>,
    /// Time of the last copy.
    copied: Instant,
}

impl TableFile {
    /// Opens the file.
    ///
    /// # Errors
    /// Fails if it cannot be written.
    pub fn open(path: &str, patterns: &[String]) -> io::Result<Self> {
        Ok(Self {
            recording: PortRecording::of(patterns),
            output: OutputFile::open(path)?,
            columns: None,
            copied: Instant::now(),
        })
    }

    /// Path of the file.
    pub fn path(&self) -> &str {
        &self.output.path
    }

    /// The values that are not in the file yet.
    pub fn recording(&mut self) -> &mut PortRecording {
        &mut self.recording
    }

    /// Patterns of ports that published nothing.
    pub fn unmatched_patterns(&self) -> impl Iterator<Item = &str> {
        self.recording.unmatched_patterns()
    }

    /// Writes the waiting rows if it is time to.
    ///
    /// # Errors
    /// Fails if they cannot be written.
    pub fn write_due(&mut self) -> io::Result<()> {
        // a pipe cannot be copied, so it gets the table at the end
        if !self.output.is_due() || !self.output.is_regular() {
            return Ok(());
        }
        self.output.begin()?;
        self.output.written = Instant::now();
        if self.columns != Some(self.recording.columns()) {
            let length = self.output.file.metadata()?.len();
            if length > SMALL_TABLE && self.copied.elapsed() < BETWEEN_COPIES {
                return Ok(());
            }
            self.copy()?;
        }
        let mut rows = Vec::new();
        self.recording.write_complete_rows(&mut rows)?;
        self.output.file.write_all(&rows)
    }

    /// Writes all rows at the end of the run.
    ///
    /// # Errors
    /// Fails if they cannot be written.
    pub fn finish(&mut self) -> io::Result<()> {
        self.output.begin()?;
        if self.columns.is_none() {
            let mut table = Vec::new();
            self.recording.write(&mut table)?;
            return self.output.file.write_all(&table);
        }
        if self.columns != Some(self.recording.columns()) {
            self.copy()?;
        }
        let mut rows = Vec::new();
        self.recording.write_last_rows(&mut rows)?;
        self.output.file.write_all(&rows)
    }

    /// Replaces the file by a copy with all columns so far. The file is complete at any time.
    fn copy(&mut self) -> io::Result<()> {
        // resolves a symbolic link, which would otherwise be replaced by a file
        let path = std::fs::canonicalize(&self.output.path)?;
        let folder = path.parent().map_or(PathBuf::from("."), Path::to_owned);
        let mut new = tempfile::NamedTempFile::new_in(folder)?;
        let old = File::open(&path)?;
        new.as_file()
            .set_permissions(old.metadata()?.permissions())?;
        let old = io::BufReader::new(old);
        self.recording.widen(old, io::BufWriter::new(&mut new))?;
        self.output.file = new.persist(&path).map_err(|failed| failed.error)?;
        self.columns = Some(self.recording.columns());
        self.copied = Instant::now();
        Ok(())
    }
}
