//! Simulated time.

use std::sync::Arc;
use std::sync::atomic::{AtomicI64, Ordering};
use std::time::Duration;

use asmotion_datum::{Codec, Schema};
use asmotion_ros_interface::InterfaceName;

use crate::error::EndpointError;
use crate::gid::Gid;
use crate::names;
use crate::node::Node;
use crate::participant::Inner;
use crate::qos::Qos;
use crate::reactor::{Incoming, Registration, Sink};

/// The newest time on `/clock` (`rosgraph_msgs/msg/Clock`), as nodes with `use_sim_time` follow it.
pub struct SimulatedClock {
    inner: Arc<Inner>,
    gid: Gid,
    now: Arc<AtomicI64>,
    _registration: Registration,
}

/// No time came yet.
const NONE: i64 = i64::MIN;

impl Node {
    /// Follows `/clock`.
    ///
    /// # Errors
    /// The catalogue has no `rosgraph_msgs/msg/Clock`, or DDS refuses.
    pub fn simulated_clock(&self) -> Result<SimulatedClock, EndpointError> {
        let clock = InterfaceName::new(
            "rosgraph_msgs",
            asmotion_ros_interface::InterfaceKind::Message,
            "Clock",
        );
        let clock = clock.map_err(|error| EndpointError::Dds {
            topic: "/clock".to_owned(),
            reason: error.to_string(),
        })?;
        let inner = self.inner();
        let now = Arc::new(AtomicI64::new(NONE));
        let sink = Ticks {
            schema: inner.catalogue().schema(&clock)?,
            now: Arc::clone(&now),
        };
        let (topic, kind) = (names::topic("/clock"), names::message_type(&clock));
        // best effort matches publishers of both kinds
        let qos = Qos::sensor_data().depth(1);
        let (gid, registration) =
            inner.reader(&topic, &kind, qos, inner.hash(&clock), |_| Box::new(sink))?;
        Ok(SimulatedClock {
            inner: Arc::clone(inner),
            gid,
            now,
            _registration: registration,
        })
    }
}

impl SimulatedClock {
    /// The newest time; `None` before the first.
    pub fn now(&self) -> Option<Duration> {
        let nanoseconds = self.now.load(Ordering::Relaxed);
        u64::try_from(nanoseconds).ok().map(Duration::from_nanos)
    }
}

impl Drop for SimulatedClock {
    fn drop(&mut self) {
        self.inner.forget(self.gid);
    }
}

struct Ticks {
    schema: Schema,
    now: Arc<AtomicI64>,
}

impl Sink for Ticks {
    fn message(&mut self, incoming: Incoming) {
        let Ok(message) = Codec::Cdr.decode(&incoming.payload.0, &self.schema) else {
            return;
        };
        let number = |path| message.get(path).and_then(|it| it.as_int());
        if let (Some(seconds), Some(rest)) = (number("clock.sec"), number("clock.nanosec"))
            && seconds >= 0
        {
            let nanoseconds = seconds.saturating_mul(1_000_000_000).saturating_add(rest);
            self.now.store(nanoseconds, Ordering::Relaxed);
        }
    }

    fn unreadable(&mut self) {}
}
