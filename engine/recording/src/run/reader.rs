//! Reads the recording of a run, one item after the other: a long run has more steps than memory.

use std::collections::{BTreeMap, VecDeque};
use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::sync::Arc;

use asmotion_component::Time;
use asmotion_coordinator::RecordedCycle;
use asmotion_viewer_encoding::{CDR, ROS2_DEFINITION, RosType};
use mcap::records::{Channel, MessageHeader, Metadata, Record};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};

use super::chain::{StepHashes, is_intact};
use super::message_data::{KnownChannel, MessageData, MessageEncoding};
use super::writer::{CHANNEL, CONTENT, END_FACTS, PORT, RUN_FACTS, TYPE};
use crate::read::RecordingError;

/// Limit for the size of a record, against files that are none.
const MAX_RECORD: usize = 1 << 30;

/// The beginning of the name of a channel with steps, and its end.
const STEPS: (&str, &str) = ("asm/", "/step");

/// An item of a recording, in the order of the file.
#[derive(Debug)]
pub enum RecordingItem {
    /// An attached text.
    Text {
        /// Name of the attachment.
        name: String,
        /// Time in the run from which it applies: 0, or that of the change for texts of a later version.
        at: Time,
        /// Content of the attachment.
        text: String,
    },
    /// A step of a coordinator.
    Step {
        /// Name of the component.
        component: String,
        /// Record of the step, with its hashes.
        step: Box<ChainedCycle>,
    },
    /// A message of another channel.
    Message {
        /// Name of the channel.
        channel: String,
        /// Time of the message in the run.
        at: Time,
        /// The message.
        data: MessageData,
    },
    /// The end of the file.
    End(FileEnd),
    /// The reason that the recording ends before its run. Nothing follows.
    Cut(String),
}

/// The end of a file of a recording.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FileEnd {
    /// Number of the file that continues the recording, from 2; `None` if this is the last one.
    pub continues: Option<u32>,
    /// Number of messages of the run that are in no file; known in the last file.
    pub lost: u64,
    /// The reason that the recording ended before the run.
    pub failure: Option<String>,
    /// The end of each coordinator; known in the last file.
    pub coordinators: BTreeMap<String, CoordinatorEnd>,
}

/// The end of a coordinator in a recording.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CoordinatorEnd {
    /// Number of steps that are lost.
    pub lost: u64,
    /// Hash of the last record of the run.
    pub last_hash: String,
}

/// A recorded step and its hashes.
#[derive(Debug)]
pub struct ChainedCycle {
    /// Causes and effects of the step.
    pub cycle: RecordedCycle,
    /// Its hashes, as recorded.
    pub hashes: StepHashes,
    /// The hash is that of the record.
    pub is_intact: bool,
}

/// Reads a file of a recording.
pub struct RunReader {
    file: File,
    reader: LinearReader,
    /// Facts about the run, as written at its start.
    facts: BTreeMap<String, String>,
    schemas: BTreeMap<u16, KnownSchema>,
    channels: BTreeMap<u16, Arc<KnownChannel>>,
    waiting: VecDeque<RecordingItem>,
    has_end: bool,
    is_done: bool,
    epoch_ns: u64,
}

/// A schema of the file.
struct KnownSchema {
    name: String,
    /// The type of ROS 2 that it defines.
    ros: Option<Arc<RosType>>,
}

/// The component whose steps a channel contains.
fn stepping(channel: &str) -> Option<&str> {
    channel.strip_prefix(STEPS.0)?.strip_suffix(STEPS.1)
}

/// The next thing that the file contains.
enum Next {
    Item(RecordingItem),
    Nothing,
    End,
}

impl RunReader {
    /// Opens the recording of a run.
    ///
    /// # Errors
    /// The file cannot be opened, or is no recording of a run.
    pub fn open(path: &Path) -> Result<Self, RecordingError> {
        let file = File::open(path).map_err(|error| RecordingError::Unreadable {
            reason: error.to_string(),
        })?;
        let options = LinearReaderOptions::default()
            .with_skip_end_magic(true)
            .with_prevalidate_chunk_crcs(true)
            .with_record_length_limit(MAX_RECORD);
        let mut reader = Self {
            file,
            reader: LinearReader::new_with_options(options),
            facts: BTreeMap::new(),
            schemas: BTreeMap::new(),
            channels: BTreeMap::new(),
            waiting: VecDeque::new(),
            has_end: false,
            is_done: false,
            epoch_ns: 0,
        };
        while reader.facts.is_empty() {
            match reader.advance() {
                Next::Item(RecordingItem::Cut(reason)) => {
                    return Err(RecordingError::Format { reason });
                }
                Next::Item(item) => reader.waiting.push_back(item),
                Next::Nothing => {}
                Next::End => {
                    let reason = "it has no facts about a run".to_owned();
                    return Err(RecordingError::Format { reason });
                }
            }
        }
        let epoch = reader.facts.get("epoch_ns").and_then(|it| it.parse().ok());
        reader.epoch_ns = epoch.unwrap_or_default();
        Ok(reader)
    }

    /// Facts about the run.
    pub fn facts(&self) -> &BTreeMap<String, String> {
        &self.facts
    }

    /// Number of the file among those of its run, from 1.
    pub fn part(&self) -> u32 {
        let part = self.facts.get("part").and_then(|part| part.parse().ok());
        part.unwrap_or(1)
    }

    /// Reads up to the next record that is worth a look.
    fn advance(&mut self) -> Next {
        let event = match self.reader.next_event() {
            None if self.has_end => return Next::End,
            None => return self.cut("it has no end".to_owned()),
            Some(Err(error)) => {
                let reason = error.to_string();
                return self.cut(reason);
            }
            Some(Ok(event)) => event,
        };
        match event {
            LinearReadEvent::ReadRequest(need) => match self.file.read(self.reader.insert(need)) {
                Ok(read) => {
                    self.reader.notify_read(read);
                    Next::Nothing
                }
                Err(error) => self.cut(error.to_string()),
            },
            LinearReadEvent::Record { opcode, data } => match mcap::parse_record(opcode, data) {
                Ok(record) => {
                    let record = record.into_owned();
                    self.record(record)
                }
                Err(error) => {
                    let reason = error.to_string();
                    self.cut(reason)
                }
            },
        }
    }

    fn cut(&mut self, reason: String) -> Next {
        self.is_done = true;
        Next::Item(RecordingItem::Cut(reason))
    }

    fn record(&mut self, record: Record<'_>) -> Next {
        match record {
            Record::Channel(channel) => {
                let known = self.known_channel(&channel);
                self.channels.insert(channel.id, Arc::new(known));
                Next::Nothing
            }
            Record::Schema { header, data } => {
                let definition = String::from_utf8_lossy(&data);
                let read = (header.encoding == ROS2_DEFINITION)
                    .then(|| RosType::read(&header.name, &definition));
                let known = KnownSchema {
                    name: header.name,
                    ros: read.flatten().map(Arc::new),
                };
                self.schemas.insert(header.id, known);
                Next::Nothing
            }
            Record::Attachment { header, data, .. } => Next::Item(RecordingItem::Text {
                at: self.time(header.log_time),
                name: header.name,
                text: String::from_utf8_lossy(&data).into_owned(),
            }),
            Record::Metadata(metadata) => self.metadata(metadata),
            Record::Message { header, data } => self.message(&header, data.into_owned()),
            Record::Header(_)
            | Record::Footer(_)
            | Record::Chunk { .. }
            | Record::MessageIndex(_)
            | Record::ChunkIndex(_)
            | Record::AttachmentIndex(_)
            | Record::Statistics(_)
            | Record::MetadataIndex(_)
            | Record::SummaryOffset(_)
            | Record::DataEnd(_)
            | Record::Unknown { .. } => Next::Nothing,
        }
    }

    /// The time in the run of a time in the file.
    fn time(&self, log_time: u64) -> Time {
        let nanos = log_time.saturating_sub(self.epoch_ns);
        Time::from_nanos(i64::try_from(nanos).unwrap_or(i64::MAX))
    }

    fn message(&mut self, header: &MessageHeader, bytes: Vec<u8>) -> Next {
        let Some(channel) = self.channels.get(&header.channel_id) else {
            return Next::Nothing;
        };
        let data = MessageData {
            bytes,
            channel: Arc::clone(channel),
        };
        let Some(component) = stepping(&channel.name) else {
            return Next::Item(RecordingItem::Message {
                channel: channel.name.clone(),
                at: self.time(header.log_time),
                data,
            });
        };
        match chained_cycle(&data) {
            Some(step) => Next::Item(RecordingItem::Step {
                component: component.to_owned(),
                step: Box::new(step),
            }),
            None => {
                let record = header.sequence;
                let reason = format!("record {record} of `{component}` is no step");
                self.cut(reason)
            }
        }
    }

    fn known_channel(&self, channel: &Channel) -> KnownChannel {
        let name = channel.metadata.get(CHANNEL).unwrap_or(&channel.topic);
        let schema = self.schemas.get(&channel.schema_id);
        let of = schema.and_then(|schema| schema.ros.clone());
        let of = of.filter(|_| channel.message_encoding == CDR);
        let named = channel.metadata.get(TYPE);
        let kind = named.or(schema.map(|schema| &schema.name));
        let kind = kind.map(|name| name.replace("/msg/", "/"));
        let encoding = match of {
            None => MessageEncoding::Json,
            Some(of) if channel.metadata.contains_key(CONTENT) => MessageEncoding::JsonInRos(of),
            Some(of) => MessageEncoding::Ros(of),
        };
        KnownChannel {
            name: name.clone(),
            kind: kind.unwrap_or_default(),
            port: channel.metadata.get(PORT).cloned(),
            encoding,
        }
    }

    fn metadata(&mut self, metadata: Metadata) -> Next {
        if metadata.name == RUN_FACTS {
            self.facts = metadata.metadata;
            return Next::Nothing;
        }
        if metadata.name != END_FACTS {
            return Next::Nothing;
        }
        self.has_end = true;
        let mut file = FileEnd::default();
        for (name, value) in metadata.metadata {
            let Some((component, fact)) = name.rsplit_once('.') else {
                match &*name {
                    "continues" => file.continues = value.parse().ok(),
                    "lost" => file.lost = value.parse().unwrap_or(u64::MAX),
                    "failure" => file.failure = Some(value),
                    _ => {}
                }
                continue;
            };
            let end = file.coordinators.entry(component.to_owned()).or_default();
            match fact {
                "lost" => end.lost = value.parse().unwrap_or(u64::MAX),
                "last_hash" => end.last_hash = value,
                _ => {}
            }
        }
        Next::Item(RecordingItem::End(file))
    }
}

/// The items after the facts about the run.
impl Iterator for RunReader {
    type Item = RecordingItem;

    fn next(&mut self) -> Option<RecordingItem> {
        if let Some(item) = self.waiting.pop_front() {
            return Some(item);
        }
        while !self.is_done {
            match self.advance() {
                Next::Item(item) => return Some(item),
                Next::Nothing => {}
                Next::End => self.is_done = true,
            }
        }
        None
    }
}

fn chained_cycle(data: &MessageData) -> Option<ChainedCycle> {
    let text = data.json().ok()?;
    Some(ChainedCycle {
        cycle: serde_json::from_str(&text).ok()?,
        hashes: serde_json::from_str(&text).ok()?,
        is_intact: is_intact(&text),
    })
}
