//! Publishes the presence of a process periodically.

use std::time::{Duration, Instant};

use asmotion_bus::{Bus, BusError, Payload, PublishOptions, Publisher, SenderId};
use asmotion_datum::{Codec, Datum, Schema};
use asmotion_plan::{Part, Plan};
use asmotion_runtime::Run;

use crate::last_samples::now;
use crate::presence::{PRESENCE, Presence, presence_topic};

/// Period of the presence messages.
const PERIOD: Duration = Duration::from_secs(1);

/// Publishes the presence of a running part of a plan.
pub(crate) struct PresencePublisher<'p> {
    plan: &'p Plan,
    part: Part,
    process: String,
    publisher: Box<dyn Publisher>,
    /// Time and content of the last message.
    last: Option<(Instant, Presence)>,
    /// Publish at the next opportunity, before the period has passed.
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

    /// Publishes the presence if it is due.
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

    /// Makes the presence due at once, because something has changed.
    pub(crate) fn hurry(&mut self) {
        self.hurries = true;
    }

    /// Publishes the last message, with `leaves` set.
    pub(crate) fn leave(&mut self) {
        let mut presence = self.last.take().map(|(_, last)| last).unwrap_or_default();
        presence.leaves = true;
        self.publish(&presence);
    }

    /// Publishes a message. If the bus does not accept it, the next one follows within a second.
    fn publish(&mut self, presence: &Presence) {
        let Ok(datum) = Datum::of(presence) else {
            return;
        };
        let _ = self.publisher.publish(now(), Payload::of(datum));
    }
}
