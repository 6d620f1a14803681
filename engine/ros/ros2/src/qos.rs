//! Quality of service, as ROS 2 names it.

use std::fmt;
use std::time::Duration;

use rustdds::{QosPolicies, QosPolicyBuilder, policy};

use crate::history::KeptMessages;

/// Repetition of lost messages.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Reliability {
    /// Lost messages are sent again.
    #[default]
    Reliable,
    /// Lost messages stay lost. A reliable subscription does not match such a publisher.
    BestEffort,
}

/// Delivery to subscriptions that match after a message was sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Durability {
    /// They do not get it.
    #[default]
    Volatile,
    /// They get the last messages, at least as many as the depth, in order. A subscription that asks for it does not match a volatile publisher.
    TransientLocal,
}

/// The quality of service of a publisher or subscription. The default is that of ROS 2: reliable, volatile, depth 10.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Qos {
    /// Repetition of lost messages.
    pub reliability: Reliability,
    /// Delivery to late subscriptions.
    pub durability: Durability,
    /// Length of the queue, at least 1: messages that wait to be sent or taken. When it is full, the oldest is dropped and
    /// counted.
    pub depth: usize,
    /// Longest time between two messages: a publisher offers it, and a subscription requests it and matches only publishers
    /// with one that is not longer. `None` for no limit.
    pub deadline: Option<Duration>,
    /// Age at which the messages of a publisher are no longer delivered by its peers. `None` for no limit; subscriptions have
    /// none.
    pub lifespan: Option<Duration>,
}

/// Smallest number of messages that DDS keeps between its thread and ours.
const KEPT: usize = 64;
/// Added to a requested deadline: peers round an equal one up where this side cuts it off, and would not match.
const ROUNDING: Duration = Duration::from_micros(1);
/// Messages beyond twice the depth that may wait for acknowledgements.
const SPARE: usize = 8192;
/// The same for a transient local publisher.
const LATCHED_SPARE: usize = 64;
/// Room that is left in the window of a transient local publisher when messages are given up.
const MARGIN: usize = 8;
/// Bytes of messages of a volatile publisher, beyond the depth, that are kept for readers without acknowledgement.
const KEPT_BYTES: usize = 8 << 20;
/// Largest depth.
const DEEPEST: usize = 1 << 16;

impl Default for Qos {
    fn default() -> Self {
        Self {
            reliability: Reliability::Reliable,
            durability: Durability::Volatile,
            depth: 10,
            deadline: None,
            lifespan: None,
        }
    }
}

impl fmt::Display for Qos {
    /// In words, without the depth: `reliable, volatile, deadline 100 ms`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self.reliability {
            Reliability::Reliable => "reliable",
            Reliability::BestEffort => "best effort",
        })?;
        f.write_str(match self.durability {
            Durability::Volatile => ", volatile",
            Durability::TransientLocal => ", transient local",
        })?;
        if let Some(deadline) = self.deadline {
            write!(f, ", deadline {} ms", deadline.as_millis())?;
        }
        if let Some(lifespan) = self.lifespan {
            write!(f, ", lifespan {} ms", lifespan.as_millis())?;
        }
        Ok(())
    }
}

impl Qos {
    /// The quality of service for data of sensors: best effort, volatile, depth 5.
    pub fn sensor_data() -> Self {
        Self {
            reliability: Reliability::BestEffort,
            depth: 5,
            ..Self::default()
        }
    }

    /// Reliable and transient local with depth 1: for values such as a map, which late subscriptions need.
    pub fn latched() -> Self {
        Self {
            durability: Durability::TransientLocal,
            depth: 1,
            ..Self::default()
        }
    }

    /// The same with another depth.
    #[must_use]
    pub fn depth(self, depth: usize) -> Self {
        Self { depth, ..self }
    }

    pub(crate) fn queue(self) -> usize {
        self.depth.clamp(1, DEEPEST)
    }

    /// Policies of a writer, which never blocks: what DDS does not take at once waits in our queue.
    pub(crate) fn writer(self) -> QosPolicies {
        let most = i32::try_from(self.window()).unwrap_or(i32::MAX);
        // without a limit, DDS keeps 8192 messages of a transient local writer that has no readers, whatever its depth
        let limits = policy::ResourceLimits {
            max_samples: most,
            max_instances: 1,
            max_samples_per_instance: most,
        };
        let builder = QosPolicyBuilder::new().resource_limits(limits);
        let kept = match self.durability {
            // what is acknowledged is of no use, and a reader for which `release` acknowledges asks for it in vain
            Durability::Volatile => builder.history(policy::History::KeepLast { depth: 0 }),
            Durability::TransientLocal => builder,
        };
        self.topic().modify_by(&kept.build())
    }

    /// Policies of a topic.
    pub(crate) fn topic(self) -> QosPolicies {
        self.policies(self.queue())
    }

    /// Most messages that wait for acknowledgements before DDS takes no more.
    fn window(self) -> usize {
        let spare = match self.durability {
            Durability::Volatile => SPARE,
            // only the last messages count
            Durability::TransientLocal => LATCHED_SPARE,
        };
        2 * self.queue() + spare
    }

    /// The bookkeeping of what a writer keeps, which gives up messages before the window is full.
    pub(crate) fn history(self) -> KeptMessages {
        let (depth, window) = (self.queue(), self.window());
        match self.durability {
            Durability::Volatile => KeptMessages::new(depth, window / 2, KEPT_BYTES),
            Durability::TransientLocal => KeptMessages::new(depth, window - MARGIN, usize::MAX),
        }
    }

    /// Policies of a reader. Its history only bridges the time until the thread of the node reads.
    pub(crate) fn reader(self) -> QosPolicies {
        let policies = Self {
            lifespan: None,
            deadline: self.deadline.map(|it| it.saturating_add(ROUNDING)),
            ..self
        };
        policies.policies(self.queue().max(KEPT))
    }

    fn policies(self, depth: usize) -> QosPolicies {
        let depth = i32::try_from(depth.min(DEEPEST)).unwrap_or(i32::MAX);
        let builder = match self.reliability {
            Reliability::Reliable => QosPolicyBuilder::new().reliable(rustdds::Duration::ZERO),
            Reliability::BestEffort => QosPolicyBuilder::new().best_effort(),
        };
        let durability = match self.durability {
            Durability::Volatile => policy::Durability::Volatile,
            Durability::TransientLocal => policy::Durability::TransientLocal,
        };
        let mut builder = builder.durability(durability);
        if let Some(deadline) = self.deadline {
            builder = builder.deadline(policy::Deadline(deadline.into()));
        }
        if let Some(lifespan) = self.lifespan {
            let duration = lifespan.into();
            builder = builder.lifespan(policy::Lifespan { duration });
        }
        builder.history(policy::History::KeepLast { depth }).build()
    }

    /// The quality of service that a peer announces. The depth is not announced, and 0 here.
    pub(crate) fn announced(policies: &QosPolicies) -> Self {
        let is_transient = matches!(
            policies.durability(),
            Some(policy::Durability::TransientLocal)
        );
        Self {
            reliability: if policies.is_reliable() {
                Reliability::Reliable
            } else {
                Reliability::BestEffort
            },
            durability: if is_transient {
                Durability::TransientLocal
            } else {
                Durability::Volatile
            },
            depth: 0,
            deadline: policies.deadline().and_then(|it| limit(it.0)),
            lifespan: policies.lifespan().and_then(|it| limit(it.duration)),
        }
    }
}

/// A duration that is not infinite, in microseconds: DDS counts in fractions of 2^-32 s.
fn limit(duration: rustdds::Duration) -> Option<Duration> {
    let nanoseconds = u64::try_from(duration.to_nanoseconds()).unwrap_or(0);
    let rounded = Duration::from_micros(nanoseconds.saturating_add(500) / 1000);
    (duration != rustdds::Duration::INFINITE).then_some(rounded)
}
