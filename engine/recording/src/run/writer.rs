//! The thread that writes a recording.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Write;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use asmotion_datum::Datum;
use asmotion_viewer_encoding::{ChannelSchema, JSON, RosType};
use mcap::records::{MessageHeader, Metadata};
use mcap::write::NoSeek;
use mcap::{Attachment, McapError, WriteOptions, Writer};

use super::chain::text_hash;
use super::file::ChunkFile;
use super::options::{RecorderOptions, RecordingFile};
use super::queue::{AttachedText, ChannelAbout, JobQueue, WriterJob};
use crate::profile::RecordingProfile;

/// Interval at which the writer looks for messages.
const LOOK: Duration = Duration::from_millis(50);

/// Longest time for which a message stays out of the file.
const FLUSH: Duration = Duration::from_millis(500);

/// Size of a chunk, in bytes of messages.
const CHUNK: u64 = 1 << 20;

/// Name of the metadata record with the facts about the run.
pub(super) const RUN_FACTS: &str = "asmotion.run";

/// Name of the metadata record at the end of a recording. A file without it was cut.
pub(super) const END_FACTS: &str = "asmotion.end";

/// Fact about a channel with a name of ROS: its own name.
pub(super) const CHANNEL: &str = "channel";

/// Fact about a channel of texts of ROS: what they are.
pub(super) const CONTENT: &str = "content";

/// Fact about a channel of samples: the port whose sample began it.
pub(super) const PORT: &str = "from";

/// Fact about a channel of texts of ROS: name of the type that they describe.
pub(super) const TYPE: &str = "type";

/// Media type of attached texts.
const TEXT: &str = "text/plain; charset=utf-8";

/// The reason that a recording cannot begin or go on.
#[derive(Debug, thiserror::Error)]
pub enum RecordingFailure {
    /// The file cannot be created.
    #[error("cannot create `{path}`: {reason}")]
    Create {
        /// Path of the file.
        path: String,
        /// Error of the operating system.
        reason: std::io::Error,
    },
    /// The file cannot be written.
    #[error("cannot write `{path}`: {}", written_reason(reason))]
    Write {
        /// Path of the file.
        path: String,
        /// Error of the format or of the operating system.
        reason: McapError,
    },
    /// The thread that writes cannot be started, or has ended.
    #[error("the thread that writes the recording has failed")]
    Thread,
}

/// The name of a channel as a topic of ROS: `/odom` for `topic/odom`, `/port/Laser/scan` for `port/Laser.scan`.
fn ros_topic(channel: &str) -> String {
    let name = channel.strip_prefix("topic/").unwrap_or(channel);
    let characters = name.chars().map(|it| match it {
        '.' => '/',
        it if it.is_ascii_alphanumeric() || "/_".contains(it) => it,
        _ => '_',
    });
    ['/'].into_iter().chain(characters).collect()
}

/// The reason that a file cannot be written. The error of the format has that of the operating system only as its source.
fn written_reason(reason: &McapError) -> String {
    match std::error::Error::source(reason) {
        Some(cause) => cause.to_string(),
        None => reason.to_string(),
    }
}

/// The end of a recording.
#[derive(Debug, Default)]
pub struct RecordingEnd {
    /// The files, in order; several if the recording was divided.
    pub paths: Vec<PathBuf>,
    /// Number of bytes in all files.
    pub bytes: u64,
    /// Number of messages in all files.
    pub messages: u64,
    /// Number of messages that are not in the files.
    pub lost: u64,
    /// The error that ended the recording before the run.
    pub failure: Option<RecordingFailure>,
}

impl RecordingEnd {
    /// Returns whether every message of the run is in the files.
    pub fn is_complete(&self) -> bool {
        self.lost == 0 && self.failure.is_none()
    }
}

/// The open file of a recording.
struct OpenFile {
    path: PathBuf,
    writer: Writer<NoSeek<ChunkFile>>,
    profile: RecordingProfile,
    /// Channels in this file.
    channels: BTreeMap<u32, FileChannel>,
    /// Hashes of the attached texts.
    attached: BTreeSet<String>,
    /// Bytes of messages and texts, for the size at which the next file begins.
    size: u64,
    /// The same at the last flush.
    flushed_size: u64,
    /// Number of messages since the last flush.
    unflushed: u64,
}

/// A channel in a file.
#[derive(Clone)]
struct FileChannel {
    id: u16,
    /// Type of the messages that contain its JSON; `None` if messages are written as they are.
    text: Option<Arc<RosType>>,
}

/// Writes jobs to a file, and to a further one when it has reached its size.
pub(super) struct RecordingWriter {
    queue: Arc<JobQueue>,
    options: RecorderOptions,
    file: RecordingFile,
    open: Option<OpenFile>,
    /// Number of the open file, from 1.
    part: u32,
    channels: BTreeMap<u32, ChannelAbout>,
    texts: Vec<AttachedText>,
    end: RecordingEnd,
}

impl RecordingWriter {
    /// Creates the file.
    pub fn new(
        queue: Arc<JobQueue>,
        options: RecorderOptions,
        file: RecordingFile,
    ) -> Result<Self, RecordingFailure> {
        let texts = options.texts.clone().into_iter();
        let texts = texts.map(|(name, text)| AttachedText {
            name,
            text,
            at_ns: 0,
        });
        let texts = texts.collect();
        let mut writer = Self {
            queue,
            options,
            file,
            open: None,
            part: 1,
            channels: BTreeMap::new(),
            texts,
            end: RecordingEnd::default(),
        };
        let first = writer.file.clone();
        writer.begin_file(&first)?;
        // further files are named after the one that was created, whatever number it got
        if let Some(path) = writer.path() {
            writer.file = RecordingFile::new(path);
        }
        Ok(writer)
    }

    /// Path of the open file.
    pub fn path(&self) -> Option<PathBuf> {
        self.open.as_ref().map(|open| open.path.clone())
    }

    /// Writes until the queue is closed. `end_facts` gives the facts about the end of the run.
    pub fn run(mut self, end_facts: &dyn Fn() -> BTreeMap<String, String>) -> RecordingEnd {
        let mut flushed = Instant::now();
        loop {
            let taken = self.queue.take(LOOK);
            let mut done = taken.jobs.into_iter().try_for_each(|job| self.write(job));
            if flushed.elapsed() >= FLUSH || taken.is_last {
                done = done.and_then(|()| self.flush());
                flushed = Instant::now();
            }
            if let Err(failure) = done {
                self.queue.abandon();
                let unflushed = self.open.as_ref().map_or(0, |open| open.unflushed);
                self.end.messages -= unflushed;
                // what was flushed before stays
                let facts = BTreeMap::from([("failure".to_owned(), failure.to_string())]);
                let _ = self.finish_file(&facts);
                self.end.failure = Some(failure);
                return self.end;
            }
            if taken.is_last {
                break;
            }
        }
        let mut facts = end_facts();
        let messages = facts.get("messages").and_then(|count| count.parse().ok());
        let lost = messages.unwrap_or(0_u64).saturating_sub(self.end.messages);
        facts.insert("lost".to_owned(), lost.to_string());
        if let Err(failure) = self.finish_file(&facts) {
            self.end.failure = Some(failure);
        }
        self.end
    }

    fn write(&mut self, job: WriterJob) -> Result<(), RecordingFailure> {
        match job {
            WriterJob::Message {
                channel,
                at_ns,
                sequence,
                data,
            } => self.message(channel, at_ns, sequence, &data),
            WriterJob::Channel { channel, about } => {
                self.channels.insert(channel, about);
                Ok(())
            }
            WriterJob::Attachment { text } => {
                let epoch_ns = self.options.epoch_ns;
                let attached = self.on_file(|open| open.attach(&text, epoch_ns));
                self.texts.push(text);
                attached
            }
        }
    }

    fn message(
        &mut self,
        channel: u32,
        at_ns: u64,
        sequence: u32,
        data: &[u8],
    ) -> Result<(), RecordingFailure> {
        let about = self.channels.get(&channel).cloned();
        let log_time = self.options.epoch_ns.saturating_add(at_ns);
        self.on_file(|open| {
            let FileChannel { id, text } = open.channel(channel, about)?;
            let header = MessageHeader {
                channel_id: id,
                sequence,
                log_time,
                publish_time: log_time,
            };
            open.size += data.len() as u64;
            open.unflushed += 1;
            let Some(text) = text else {
                return open.writer.write_to_known_channel(&header, data);
            };
            let message = String::from_utf8_lossy(data).into_owned();
            let message = Datum::record([("data", Datum::Text(message))]);
            // a text has a form in CDR
            let message = text.encode(message).unwrap_or_default();
            open.writer.write_to_known_channel(&header, &message)
        })?;
        self.end.messages += 1;
        let Some(open) = &self.open else {
            return Ok(());
        };
        if self
            .options
            .rotate_bytes
            .is_some_and(|limit| open.size >= limit)
        {
            return self.next_file();
        }
        if open.size - open.flushed_size >= CHUNK {
            return self.flush();
        }
        Ok(())
    }

    fn flush(&mut self) -> Result<(), RecordingFailure> {
        let is_dirty = |open: &OpenFile| open.size != open.flushed_size || open.unflushed > 0;
        if self.open.as_ref().is_some_and(is_dirty) {
            return self.on_file(OpenFile::flush);
        }
        Ok(())
    }

    fn on_file(
        &mut self,
        work: impl FnOnce(&mut OpenFile) -> Result<(), McapError>,
    ) -> Result<(), RecordingFailure> {
        let Some(open) = &mut self.open else {
            return Err(RecordingFailure::Thread);
        };
        work(open).map_err(|reason| RecordingFailure::Write {
            path: open.path.display().to_string(),
            reason,
        })
    }

    /// Ends the open file and begins the next one.
    fn next_file(&mut self) -> Result<(), RecordingFailure> {
        self.part += 1;
        let next = self.file.part(self.part);
        let facts = BTreeMap::from([("continues".to_owned(), (self.part).to_string())]);
        self.finish_file(&facts)?;
        self.begin_file(&next)
    }

    fn begin_file(&mut self, file: &RecordingFile) -> Result<(), RecordingFailure> {
        let created = file.create();
        let (path, file) = created.map_err(|reason| RecordingFailure::Create {
            path: file.name(),
            reason,
        })?;
        let mut facts = self.options.facts.clone();
        facts.insert("part".to_owned(), self.part.to_string());
        facts.insert("epoch_ns".to_owned(), self.options.epoch_ns.to_string());
        let opened = OpenFile::new(path.clone(), file, facts, &self.texts, &self.options);
        let opened = opened.map_err(|reason| RecordingFailure::Write {
            path: path.display().to_string(),
            reason,
        })?;
        self.end.paths.push(path);
        self.open = Some(opened);
        Ok(())
    }

    fn finish_file(&mut self, facts: &BTreeMap<String, String>) -> Result<(), RecordingFailure> {
        let Some(open) = self.open.take() else {
            return Ok(());
        };
        let path = open.path.display().to_string();
        let (bytes, finished) = open.finish(facts);
        self.end.bytes += bytes;
        finished.map_err(|reason| RecordingFailure::Write { path, reason })
    }
}

impl OpenFile {
    fn new(
        path: PathBuf,
        file: std::fs::File,
        facts: BTreeMap<String, String>,
        texts: &[AttachedText],
        recorder: &RecorderOptions,
    ) -> Result<Self, McapError> {
        let profile = match recorder.profile {
            RecordingProfile::Viewers => "",
            RecordingProfile::Ros2 => "ros2",
        };
        let options = WriteOptions::new()
            .profile(profile)
            .compression(None)
            // the writer ends chunks itself, with a flush
            .chunk_size(None)
            .disable_seeking(true)
            .library(concat!("asmotion ", env!("CARGO_PKG_VERSION")));
        let mut open = Self {
            path,
            profile: recorder.profile,
            writer: options.create(NoSeek::new(ChunkFile::new(file)))?,
            channels: BTreeMap::new(),
            attached: BTreeSet::new(),
            size: 0,
            flushed_size: 0,
            unflushed: 0,
        };
        open.writer.write_metadata(&Metadata {
            name: RUN_FACTS.to_owned(),
            metadata: facts,
        })?;
        for text in texts {
            open.attach(text, recorder.epoch_ns)?;
        }
        open.flush()?;
        Ok(open)
    }

    /// Attaches a text, unless the file has it.
    fn attach(&mut self, attached: &AttachedText, epoch_ns: u64) -> Result<(), McapError> {
        let AttachedText { name, text, at_ns } = attached;
        if !self.attached.insert(format!("{name} {}", text_hash(text))) {
            return Ok(());
        }
        self.size += text.len() as u64;
        let time = epoch_ns.saturating_add(*at_ns);
        self.writer.attach(&Attachment {
            log_time: time,
            create_time: time,
            name: name.clone(),
            media_type: TEXT.to_owned(),
            data: text.as_bytes().into(),
        })
    }

    /// A channel in this file; it is described before its first message.
    fn channel(
        &mut self,
        channel: u32,
        about: Option<ChannelAbout>,
    ) -> Result<FileChannel, McapError> {
        if let Some(known) = self.channels.get(&channel) {
            return Ok(known.clone());
        }
        // the recorder describes every channel before its messages
        let unknown = || McapError::UnknownChannel(0, 0);
        let ChannelAbout {
            topic,
            schema,
            facts,
        } = about.ok_or_else(unknown)?;
        let mut facts: BTreeMap<String, String> = facts
            .into_iter()
            .map(|(name, value)| (name.to_owned(), value))
            .collect();
        let (topic, schema, text) = match (self.profile, schema) {
            (RecordingProfile::Viewers, schema) => (topic, schema, None),
            (RecordingProfile::Ros2, schema) => {
                let name = ros_topic(&topic);
                facts.insert(CHANNEL.to_owned(), topic);
                let (of, text) = match schema {
                    ChannelSchema::Ros(of) => (of, None),
                    ChannelSchema::Json(name, _) => {
                        facts.insert(TYPE.to_owned(), name);
                        facts.insert(CONTENT.to_owned(), JSON.to_owned());
                        let text = Arc::new(RosType::text().ok_or_else(unknown)?);
                        (Arc::clone(&text), Some(text))
                    }
                };
                (name, ChannelSchema::Ros(of), text)
            }
        };
        let (name, definition) = (schema.name(), schema.definition().as_bytes());
        let messages = schema.message_encoding();
        let schema = self
            .writer
            .add_schema(name, schema.definition_encoding(), definition)?;
        let id = self.writer.add_channel(schema, &topic, messages, &facts)?;
        let known = FileChannel { id, text };
        self.channels.insert(channel, known.clone());
        Ok(known)
    }

    /// Finishes the chunk. The file is readable up to here, whatever happens to the process.
    fn flush(&mut self) -> Result<(), McapError> {
        self.writer.flush()?;
        self.flushed_size = self.size;
        self.unflushed = 0;
        Ok(())
    }

    /// Ends the file. Returns its size in bytes.
    fn finish(mut self, facts: &BTreeMap<String, String>) -> (u64, Result<(), McapError>) {
        let written = self.writer.write_metadata(&Metadata {
            name: END_FACTS.to_owned(),
            metadata: facts.clone(),
        });
        let finished = written.and_then(|()| self.writer.finish().map(|_| ()));
        let mut file = self.writer.into_inner().into_inner();
        let flushed = file.flush().map_err(McapError::from);
        (file.flushed(), finished.and(flushed))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Writes two messages into files of this name that are divided after each of them. Returns the names of the files.
    fn divided(path: &std::path::Path) -> Vec<String> {
        let queue = Arc::new(JobQueue::new(crate::Overflow::Wait));
        let about = ChannelAbout {
            topic: "topic/go".to_owned(),
            schema: ChannelSchema::Json("Go".to_owned(), "{}".to_owned()),
            facts: Vec::new(),
        };
        queue.push_always(WriterJob::Channel { channel: 1, about });
        for sequence in 1..=2 {
            queue.push(WriterJob::Message {
                channel: 1,
                at_ns: 0,
                sequence,
                data: b"{}".to_vec(),
            });
        }
        queue.close();
        let options = RecorderOptions {
            rotate_bytes: Some(1),
            ..RecorderOptions::default()
        };
        let writer = RecordingWriter::new(queue, options, RecordingFile::new(path));
        let end = writer.expect("a file").run(&BTreeMap::new);
        assert!(end.failure.is_none());
        let names = end.paths.iter().filter_map(|path| path.file_name());
        names
            .map(|name| name.to_string_lossy().into_owned())
            .collect()
    }

    #[test]
    fn parts_are_named_after_the_file_that_was_created() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("run.mcap");
        let first = divided(&path);
        assert_eq!(first, ["run.mcap", "run.part2.mcap", "run.part3.mcap"]);
        let second = divided(&path);
        assert_eq!(
            second,
            ["run-2.mcap", "run-2.part2.mcap", "run-2.part3.mcap"]
        );
        // a part does not overwrite a file that is there by chance
        std::fs::write(folder.path().join("run-3.part2.mcap"), "").expect("written");
        let third = divided(&path);
        assert_eq!(
            third,
            ["run-3.mcap", "run-3.part2-2.mcap", "run-3.part3.mcap"]
        );
    }
}
