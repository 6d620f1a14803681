//! Simulated time: the topic `/clock`.

use std::sync::Arc;

use asmotion_bus::{Notifier, QueuePolicy, Subscription};
use asmotion_datum::Datum;

use crate::error::RosError;
use crate::interface::TopicType;
use crate::node::RosNode;
use crate::time::{nanoseconds, time};

/// Follows the time of a simulator.
pub struct RosClock {
    subscription: Subscription,
    now: Option<i64>,
}

impl RosClock {
    /// Subscribes to `/clock`, whose type is `rosgraph_msgs/Clock`. The notifier is notified of every time.
    ///
    /// # Errors
    /// [`RosError::SubscribedOtherwise`] if the node subscribes to `/clock` with another type.
    pub fn follow(
        node: &RosNode,
        of: TopicType,
        notifier: Arc<Notifier>,
    ) -> Result<Self, RosError> {
        Ok(Self {
            subscription: node.subscribe("/clock", Some(of), QueuePolicy::Latest, notifier)?,
            now: None,
        })
    }

    /// The simulated time, in nanoseconds; `None` before the first one has arrived. It can go back: a simulator was reset.
    pub fn now(&mut self) -> Option<i64> {
        if let Some(envelope) = self.subscription.try_next() {
            let datum = envelope.payload.to_datum().unwrap_or_default();
            let told = datum.get("clock").and_then(|it| nanoseconds(&it));
            self.now = told.or(self.now);
        }
        self.now
    }
}

/// A message of `/clock` (`rosgraph_msgs/Clock`), for a node that simulates.
pub fn clock_message(nanoseconds: i64) -> Datum {
    Datum::record([("clock", time(nanoseconds))])
}
