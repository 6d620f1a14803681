//! The herald: tells others on the bus, again and again, what this process is and how it is.

use std::time::{Duration, Instant};

use asmotion_assembly::{Part, Plan};
use asmotion_bus::{Bus, BusError, Payload, PublishOptions, Publisher, SenderId};
use asmotion_datum::{Codec, Datum, Schema};
use asmotion_runtime::Run;

use crate::last_samples::now;
use crate::presence::{PRESENCE, Presence, presence_topic};

/// How often it speaks.
const PERIOD: Duration = Duration::from_secs(1);

/// Tells what a running part of a plan is.
pub(crate) struct PresencePublisher<'p> {
    plan: &'p Plan,
    part: Part,
    process: String,
    publisher: Box<dyn Publisher>,
    /// When it spoke last, and what it said.
    last: Option<(Instant, Presence)>,
    /// It shall not wait until it is time.
    hurries: bool,
}

impl<'p> PresencePublisher<'p> {
    pub(crate) fn new(
        plan: &'p Plan,
        part: Part,
        process: &str,
        bus: &dyn Bus,
        incarnation: u64,
    ) -> Result<Self, BusError> {
        let origin = SenderId::new(process, incarnation);
        let sending = PublishOptions::state().by(Codec::Json);
        Ok(Self {
            plan,
            part,
            process: process.to_owned(),
            publisher: bus.publisher(
                &presence_topic(process),
                &origin,
                &Schema::opaque(PRESENCE),
                sending,
            )?,
            last: None,
            hurries: false,
        })
    }

    /// Speaks, if it is time.
    pub(crate) fn speak(&mut self, run: &mut dyn Run) {
        let now = Instant::now();
        let before = self.last.take();
        let since = before.as_ref().map(|(at, _)| now.duration_since(*at));
        if !self.hurries && since.is_some_and(|since| since < PERIOD) {
            self.last = before;
            return;
        }
        let presence = Presence::of(self.plan, &self.part, &self.process, run);
        let before = before.map(|(_, before)| before);
        let presence = presence.after(before.as_ref(), since.unwrap_or_default().as_secs_f64());
        self.publish(&presence);
        self.last = Some((now, presence));
        self.hurries = false;
    }

    /// It shall speak as soon as it can: something has changed.
    pub(crate) fn hurry(&mut self) {
        self.hurries = true;
    }

    /// Says the last word.
    pub(crate) fn leave(&mut self) {
        let mut presence = self.last.take().map(|(_, last)| last).unwrap_or_default();
        presence.leaves = true;
        self.publish(&presence);
    }

    /// What a broker does not take is said anew in a second.
    fn publish(&mut self, presence: &Presence) {
        let Ok(datum) = Datum::of(presence) else {
            return;
        };
        let _ = self.publisher.publish(now(), Payload::of(datum));
    }
}
