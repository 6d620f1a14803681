//! Messages in other frames: the transforms of ROS, and the messages that wait for them.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use asmotion_component::{Cycle, Losses};
use asmotion_datum::{Datum, Schema};
use asmotion_transform::{MessageTransform, TransformBuffer, TransformFailure};

use crate::mapped::{MappedFrame, MappedTopic, RosDirection};
use crate::misfits::Misfits;
use crate::traffic::Traffic;
use crate::transport::{MessageReceiver, RosConnection, RosMessage};

/// Topic of transforms, unless a bridge names another one.
const TOPIC: &str = "/tf";

/// Type of both topics.
const KIND: &str = "tf2_msgs/TFMessage";

/// Messages that wait for a cycle: those of a second in a large robot, or of all nodes with static transforms.
const QUEUE: usize = 1000;

/// The transforms that a bridge has received.
pub(crate) struct Transforms {
    pub(crate) buffer: TransformBuffer,
    topics: [TransformTopic; 2],
}

/// A topic of transforms.
struct TransformTopic {
    ros: String,
    /// Whether its transforms hold at all times.
    is_static: bool,
    traffic: Traffic,
    /// Transforms that were refused.
    refused: u64,
}

impl Default for Transforms {
    fn default() -> Self {
        Self::on(TOPIC)
    }
}

/// Subscriptions to the topics of transforms; none if the bridge needs no transforms.
pub(crate) type TransformReceivers = Vec<Box<dyn MessageReceiver>>;

impl Transforms {
    /// Those on a topic; static ones are on the topic of this name with `_static`.
    pub(crate) fn on(topic: &str) -> Self {
        let topic_of = |ros, is_static| TransformTopic {
            ros,
            is_static,
            traffic: Traffic::default(),
            refused: 0,
        };
        Self {
            buffer: TransformBuffer::default(),
            topics: [
                topic_of(topic.to_owned(), false),
                topic_of(format!("{topic}_static"), true),
            ],
        }
    }

    /// Subscribes to the topics.
    ///
    /// # Errors
    /// As [`RosConnection::subscribe`].
    pub(crate) fn subscribe(
        &self,
        connection: &mut dyn RosConnection,
    ) -> Result<TransformReceivers, String> {
        let topics = self.topics.iter().map(|topic| MappedTopic {
            port: String::new(),
            topic: None,
            schema: Schema::opaque(KIND),
            ros: topic.ros.clone(),
            kind: KIND.to_owned(),
            queue: QUEUE,
            is_latched: topic.is_static,
            is_best_effort: false,
            deadline: None,
            lifespan: None,
            converters: Vec::new(),
            transform: None,
            direction: RosDirection::FromRos,
        });
        topics.map(|topic| connection.subscribe(&topic)).collect()
    }

    /// Takes the transforms that have arrived. Those that are refused are counted, and reported once for each cause.
    pub(crate) fn update(
        &mut self,
        receivers: &mut TransformReceivers,
        misfits: &mut Misfits,
        cycle: &mut Cycle<'_>,
    ) {
        for (topic, receiver) in self.topics.iter_mut().zip(receivers) {
            for message in receiver.take() {
                let reasons = self
                    .buffer
                    .insert_message(&message.content, topic.is_static);
                topic.traffic.pass(1, Instant::now());
                for reason in reasons {
                    topic.refused += 1;
                    misfits.count_transform(&topic.ros, &reason.to_string(), cycle);
                }
            }
        }
    }

    /// The numbers of the topics, and of the frames, as the bridge describes itself.
    pub(crate) fn describe(
        &self,
        receivers: &TransformReceivers,
        now: Instant,
    ) -> Vec<(String, Datum)> {
        if receivers.is_empty() {
            return Vec::new();
        }
        let topics = self.topics.iter().zip(receivers);
        let topics = topics.map(|(topic, receiver)| {
            let found = receiver.losses();
            let losses = Losses {
                misfits: found.misfits + topic.refused,
                ..found
            };
            let name = format!("transforms ← {}", topic.ros);
            (name, topic.traffic.describe(losses, now))
        });
        let frames = i64::try_from(self.buffer.frames()).unwrap_or(i64::MAX);
        topics
            .chain([("frames".to_owned(), Datum::Int(frames))])
            .collect()
    }
}

/// The messages of a mapping that wait for transforms, in their order.
pub(crate) struct FrameQueue {
    transform: MessageTransform,
    timeout: Duration,
    waiting: VecDeque<WaitingMessage>,
    limit: usize,
    dropped: u64,
}

struct WaitingMessage {
    message: RosMessage,
    since: Instant,
}

/// The end of the wait of a message: the message in the new frame, or the reason that there is none.
pub(crate) type FrameOutcome = Result<RosMessage, FrameMisfit>;

/// The reason that a message was not transformed.
pub(crate) struct FrameMisfit {
    failure: TransformFailure,
    waited: Duration,
}

impl FrameMisfit {
    /// The cause, which is the same for all such messages, and what is special about this one.
    pub(crate) fn texts(&self) -> (String, String) {
        let distance = self.failure.distance();
        let distance = distance.map(|by| format!("by {:.3} s", by.as_secs_f64()));
        let waited = self.failure.may_pass();
        let waited = waited.then(|| format!("after a wait of {} ms", self.waited.as_millis()));
        let details: Vec<_> = distance.into_iter().chain(waited).collect();
        (self.failure.to_string(), details.join(", "))
    }
}

impl FrameQueue {
    /// An empty queue.
    ///
    /// # Errors
    /// The reason that messages of this type cannot be transformed.
    pub(crate) fn new(of: &MappedTopic, frame: &MappedFrame) -> Result<Self, String> {
        let transform = MessageTransform::new(&of.kind, &frame.frame);
        Ok(Self {
            transform: transform.map_err(|error| error.to_string())?,
            timeout: frame.timeout,
            waiting: VecDeque::new(),
            limit: of.queue.max(1),
            dropped: 0,
        })
    }

    /// Adds a message. If the queue is full, the oldest one is dropped, and counted.
    pub(crate) fn push(&mut self, message: RosMessage, now: Instant) {
        if self.waiting.len() >= self.limit {
            self.waiting.pop_front();
            self.dropped += 1;
        }
        let since = now;
        self.waiting.push_back(WaitingMessage { message, since });
    }

    /// Takes the messages at the front whose wait has ended. A message does not overtake an earlier one.
    pub(crate) fn take(&mut self, buffer: &TransformBuffer, now: Instant) -> Vec<FrameOutcome> {
        let mut done = Vec::new();
        while let Some(first) = self.waiting.front() {
            let waited = now.saturating_duration_since(first.since);
            let outcome = self.transform.apply(&first.message.content, buffer);
            let may_pass = outcome.as_ref().is_err_and(TransformFailure::may_pass);
            if may_pass && waited < self.timeout {
                break;
            }
            let age = first.message.age + waited;
            let message = outcome.map(|content| RosMessage { content, age });
            done.push(message.map_err(|failure| FrameMisfit { failure, waited }));
            self.waiting.pop_front();
        }
        done
    }

    /// Time until the first message has waited for long enough; `None` if none waits.
    pub(crate) fn patience(&self, now: Instant) -> Option<Duration> {
        let first = self.waiting.front()?;
        let waited = now.saturating_duration_since(first.since);
        Some(self.timeout.saturating_sub(waited))
    }

    /// Messages dropped because the queue was full.
    pub(crate) fn losses(&self) -> Losses {
        Losses {
            dropped: self.dropped,
            misfits: 0,
        }
    }
}

#[cfg(test)]
mod tests {
    use asmotion_transform::{RigidMotion, StampedMotion};

    use super::*;

    fn point(frame: &str, x: f64) -> RosMessage {
        let time = [("sec", Datum::Int(7)), ("nanosec", Datum::Int(0))];
        let header = [
            ("stamp", Datum::record(time)),
            ("frame_id", Datum::text(frame)),
        ];
        let number = |number| Datum::Float(number);
        let point = [("x", number(x)), ("y", number(0.0)), ("z", number(0.0))];
        RosMessage {
            content: Datum::record([
                ("header", Datum::record(header)),
                ("point", Datum::record(point)),
            ]),
            age: Duration::from_millis(5),
        }
    }

    fn queue(timeout: u64) -> FrameQueue {
        let frame = MappedFrame {
            frame: "map".to_owned(),
            timeout: Duration::from_millis(timeout),
        };
        let of = MappedTopic {
            port: "at".to_owned(),
            topic: None,
            schema: Schema::opaque(""),
            ros: "/at".to_owned(),
            kind: "geometry_msgs/PointStamped".to_owned(),
            queue: 2,
            is_latched: false,
            is_best_effort: false,
            deadline: None,
            lifespan: None,
            converters: Vec::new(),
            transform: Some(frame.clone()),
            direction: RosDirection::FromRos,
        };
        FrameQueue::new(&of, &frame).unwrap()
    }

    /// Places of the messages that were transformed, with their ages, and the texts of those that were not.
    fn texts(outcomes: Vec<FrameOutcome>) -> Vec<String> {
        let text = |outcome: FrameOutcome| match outcome {
            Ok(message) => {
                let x = message.content.get("point.x").unwrap().as_float();
                format!("{} after {} ms", x.unwrap(), message.age.as_millis())
            }
            Err(misfit) => {
                let (reason, details) = misfit.texts();
                format!("{reason}: {details}")
            }
        };
        outcomes.into_iter().map(text).collect()
    }

    #[test]
    fn messages_wait_in_their_order_and_not_for_ever() {
        let (mut queue, mut buffer, start) =
            (queue(100), TransformBuffer::default(), Instant::now());
        let at = |ms| start + Duration::from_millis(ms);
        // the first is dropped: there is room for two
        for x in [1.0, 2.0] {
            queue.push(point("base", x), at(0));
        }
        queue.push(point("map", 3.0), at(20));
        assert_eq!(queue.losses().dropped, 1);
        assert_eq!(texts(queue.take(&buffer, at(30))), [""; 0]);
        assert_eq!(queue.patience(at(30)), Some(Duration::from_millis(70)));
        let motion = RigidMotion::translation(10.0, 0.0, 0.0);
        let new = StampedMotion::new("map", "base", 0, motion);
        buffer.insert(new, true).unwrap();
        assert_eq!(
            texts(queue.take(&buffer, at(40))),
            ["12 after 45 ms", "3 after 25 ms"]
        );
        assert_eq!(queue.patience(at(40)), None);
        queue.push(point("camera", 4.0), at(50));
        queue.push(point("base", 5.0), at(60));
        assert_eq!(texts(queue.take(&buffer, at(149))), [""; 0]);
        assert_eq!(
            texts(queue.take(&buffer, at(150))),
            [
                "no transform has the frame `camera`: after a wait of 100 ms",
                "15 after 95 ms"
            ]
        );
    }
}
