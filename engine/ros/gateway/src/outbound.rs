//! A mapping of a topic to ROS.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use asmotion_component::{Cycle, In, Interface, Losses};
use asmotion_datum::{Datum, Schema, Shape};
use asmotion_transform::TransformBuffer;

use crate::echo::Echoes;
use crate::frames::FrameQueue;
use crate::mapped::MappedTopic;
use crate::misfits::Misfits;
use crate::open_connection::sum;
use crate::traffic::Traffic;
use crate::transport::{MessageSender, RosMessage};

/// A mapping of a topic to ROS.
pub(crate) struct Outbound {
    pub(crate) mapped: MappedTopic,
    port: In<Datum>,
    ros_schema: Schema,
    /// Of the next message.
    sequence: u32,
    pub(crate) traffic: Traffic,
    /// Messages that wait for transforms; `None` if their frame stays.
    frames: Option<FrameQueue>,
    /// Messages that did not fit.
    misfits: u64,
    /// Losses of connections that were replaced.
    before: Losses,
    /// A sample that can be encoded is a message, and is not kept.
    is_alike: bool,
    /// The last messages of a latched topic, for a new connection.
    pub(crate) last: VecDeque<Datum>,
}

impl Outbound {
    /// Declares the port.
    ///
    /// # Errors
    /// The reason that the messages cannot be transformed.
    pub(crate) fn declare(
        mapped: MappedTopic,
        ros_schema: Schema,
        interface: &mut Interface,
    ) -> Result<Self, String> {
        let frames = mapped.transform.as_ref();
        let frames = frames.map(|it| FrameQueue::new(&mapped, it)).transpose()?;
        let is_alike = mapped.converters.is_empty()
            && mapped.transform.is_none()
            && !mapped.is_latched
            && !has_sequence(&ros_schema);
        let doc = format!("to the ROS topic `{}`", mapped.ros);
        let port = interface.input_of(&mapped.port, mapped.schema.clone(), &doc);
        Ok(Self {
            port,
            mapped,
            ros_schema,
            sequence: 0,
            traffic: Traffic::default(),
            frames,
            misfits: 0,
            before: Losses::default(),
            is_alike,
            last: VecDeque::new(),
        })
    }

    /// Sends the samples of the input, without those that came from ROS.
    pub(crate) fn send(
        &mut self,
        sender: &mut dyn MessageSender,
        mut echoes: Option<&mut Echoes>,
        buffer: &TransformBuffer,
        misfits: &mut Misfits,
        cycle: &mut Cycle<'_>,
    ) {
        for index in 0..cycle.all(self.port).len() {
            let Some(sample) = cycle.all(self.port).get(index) else {
                break;
            };
            if echoes.as_mut().is_some_and(|it| it.is_echo(sample)) {
                continue;
            }
            let now = Instant::now();
            // a sample that cannot be sent as it is may lack a field, or be a misfit, as its completion shows
            if self.is_alike && sender.send(sample).is_ok() {
                self.traffic.pass(1, now);
                continue;
            }
            match (self.complete(sample.clone()), &mut self.frames) {
                (Err(reason), _) => self.count_misfit((&reason, ""), misfits, cycle),
                (Ok(content), None) => self.send_one(content, sender, misfits, cycle),
                (Ok(content), Some(frames)) => {
                    let age = Duration::ZERO;
                    frames.push(RosMessage { content, age }, now);
                }
            }
        }
        let Some(frames) = &mut self.frames else {
            return;
        };
        for outcome in frames.take(buffer, Instant::now()) {
            match outcome {
                Ok(message) => self.send_one(message.content, sender, misfits, cycle),
                Err(misfit) => {
                    let (reason, details) = misfit.texts();
                    self.count_misfit((&reason, &details), misfits, cycle);
                }
            }
        }
    }

    fn count_misfit(&mut self, texts: (&str, &str), misfits: &mut Misfits, cycle: &mut Cycle<'_>) {
        self.misfits += 1;
        let at = (&self.mapped.port, &self.mapped.ros);
        misfits.count_with_details(at, texts, cycle);
    }

    fn send_one(
        &mut self,
        mut message: Datum,
        sender: &mut dyn MessageSender,
        misfits: &mut Misfits,
        cycle: &mut Cycle<'_>,
    ) {
        self.number(&mut message);
        if let Err(reason) = sender.send(&message) {
            return self.count_misfit((&reason, ""), misfits, cycle);
        }
        self.traffic.pass(1, Instant::now());
        self.keep(message);
    }

    /// Keeps a message of a latched topic.
    fn keep(&mut self, message: Datum) {
        if !self.mapped.is_latched {
            return;
        }
        if self.last.len() >= self.mapped.queue.max(1) {
            self.last.pop_front();
        }
        self.last.push_back(message);
    }

    /// The message of ROS for a sample, with the fields that only ROS has.
    fn complete(&self, sample: Datum) -> Result<Datum, String> {
        let mut converters = self.mapped.converters.iter();
        let converted = converters.try_fold(sample, |sample, it| it.to_there(sample))?;
        let complete = self.ros_schema.complete(converted);
        complete.map_err(|error| error.to_string())
    }

    /// Writes the sequence number into the header, as the clients of ROS 1 do.
    fn number(&mut self, message: &mut Datum) {
        if let Some(sequence) = field_mut(message, "header").and_then(|it| field_mut(it, "seq")) {
            *sequence = Datum::Int(self.sequence.into());
            self.sequence = self.sequence.wrapping_add(1);
        }
    }

    /// Adds the losses of a connection that ends.
    pub(crate) fn keep_losses(&mut self, losses: Losses) {
        self.before = sum(self.before, losses);
    }

    /// Losses that the present connection does not know, without misfits.
    pub(crate) fn losses(&self) -> Losses {
        let waiting = self.frames.as_ref().map(FrameQueue::losses);
        sum(self.before, waiting.unwrap_or_default())
    }

    /// Messages that did not fit.
    pub(crate) fn misfits(&self) -> u64 {
        self.misfits
    }

    /// Time until a message has waited for long enough.
    pub(crate) fn patience(&self, now: Instant) -> Option<Duration> {
        self.frames.as_ref()?.patience(now)
    }
}

/// Returns whether messages have a header with the sequence number that the clients of ROS 1 write.
fn has_sequence(schema: &Schema) -> bool {
    let field = |schema: &Schema, name: &str| {
        let Shape::Record(fields) = &schema.shape else {
            return None;
        };
        fields.iter().find(|it| it.name == name).cloned()
    };
    let header = field(schema, "header");
    header.is_some_and(|header| field(&header.schema, "seq").is_some())
}

fn field_mut<'d>(record: &'d mut Datum, name: &str) -> Option<&'d mut Datum> {
    let Datum::Record(fields) = record else {
        return None;
    };
    let mut fields = fields.iter_mut();
    fields
        .find(|(field, _)| **field == *name)
        .map(|(_, value)| value)
}
