//! Publishes the presence of a process periodically.

use std::borrow::Cow;
use std::time::{Duration, Instant};

use asmotion_bus::{Bus, BusError, Payload, PublishOptions, Publisher, SenderId};
use asmotion_component::Time;
use asmotion_datum::{Codec, Datum, Schema};
use asmotion_plan::{Part, Plan};
use asmotion_runtime::Run;

use crate::last_samples::now;
use crate::presence::{PRESENCE, Presence, presence_topic};

/// Period of the presence messages.
const PERIOD: Duration = Duration::from_secs(1);

/// Publishes the presence of a running part of a plan.
pub(crate) struct PresencePublisher<'p> {
    plan: Cow<'p, Plan>,
    part: Part,
    /// Number of versions that the system has changed to.
    version: u64,
    process: String,
    publisher: Box<dyn Publisher>,
    last_published: Option<PublishedPresence>,
    /// Publish at the next opportunity, before the period has passed.
    is_due_now: bool,
}

/// The last message of a process.
struct PublishedPresence {
    /// Real time, by which messages are due.
    at: Instant,
    /// Time of the run, by which rates are measured.
    run_time: Time,
    presence: Presence,
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
        let sending = PublishOptions::state().with_codec(Codec::Json);
        Ok(Self {
            plan: Cow::Borrowed(plan),
            part,
            version: 0,
            process: process.to_owned(),
            publisher: bus.publisher(
                &presence_topic(process),
                &origin,
                &Schema::opaque(PRESENCE),
                sending,
            )?,
            last_published: None,
            is_due_now: false,
        })
    }

    /// Publishes the presence if it is due.
    pub(crate) fn publish_if_due(&mut self, run: &mut dyn Run) {
        let (at, run_time) = (Instant::now(), run.now());
        let previous = self.last_published.take();
        let is_early = |last: &PublishedPresence| at.duration_since(last.at) < PERIOD;
        if !self.is_due_now && previous.as_ref().is_some_and(is_early) {
            self.last_published = previous;
            return;
        }
        let mut presence = self.presence(run);
        if let Some(last) = &previous {
            let seconds = run_time.since(last.run_time).as_secs_f64();
            presence = presence.after(&last.presence, seconds);
        }
        self.publish(&presence);
        self.last_published = Some(PublishedPresence {
            at,
            run_time,
            presence,
        });
        self.is_due_now = false;
    }

    fn presence(&self, run: &mut dyn Run) -> Presence {
        let mut presence = Presence::of(&self.plan, &self.part, &self.process, run);
        presence.version = self.version;
        presence
    }

    /// Lets the last message describe the components as they are now, with the rates of the message before.
    pub(crate) fn describe_end(&mut self, run: &mut dyn Run) {
        let mut presence = self.presence(run);
        if let Some(last) = &self.last_published {
            presence = presence.after(&last.presence, 0.0);
        }
        self.last_published = Some(PublishedPresence {
            at: Instant::now(),
            run_time: run.now(),
            presence,
        });
    }

    /// Describes another version of the system from now on.
    pub(crate) fn follow(&mut self, plan: &Plan, part: &Part) {
        self.plan = Cow::Owned(plan.clone());
        self.part = part.clone();
        self.version += 1;
        self.publish_soon();
    }

    /// Makes the presence due at once, because something has changed.
    pub(crate) fn publish_soon(&mut self) {
        self.is_due_now = true;
    }

    /// Publishes the last message, with `leaves` set.
    pub(crate) fn publish_departure(&mut self) {
        let mut presence = self
            .last_published
            .take()
            .map(|last| last.presence)
            .unwrap_or_default();
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
