//! The exchange: what of a system is on buses. Topics and ports go out and come in, services are offered to others,
//! references reach services of others.
//!
//! It is looked after by one thread, the courier's or the simulation's: a cycle leaves what it sends in a queue, and
//! waits for no transport. In a live system messages of topics need not wait for that thread: whoever brings one puts it
//! into its port.

mod incoming;
mod line;
mod offered;
mod reached;
mod topics;

use std::sync::Arc;
use std::time::Duration;

use asmotion_bus::{Bell, Bus, BusError};

use self::line::Line;
use self::offered::Offers;
use crate::Time;
use crate::door::Doors;
use crate::health;
use crate::live::World;
use crate::outside::Outside;
use crate::system::{Abroad, Joints, Offered, Topic};
use crate::unit::Unit;

pub(crate) use self::reached::Way;

/// The system's side of its buses.
pub(crate) struct Exchange {
    lines: Vec<Line>,
    /// What is served on buses that carry nothing else.
    counters: Vec<Offers>,
    /// The topics of those who are on no bus, until they have heard that none is gone.
    inside: Option<(Vec<Topic>, Doors)>,
    /// Rung for everything that comes, and when a bus is up, blocked or down.
    bell: Arc<Bell>,
}

/// A bus, and who we are on it.
pub(crate) struct Membership {
    pub bus: Arc<dyn Bus>,
    /// Which life of the system's process.
    pub incarnation: u64,
    /// The bell of the exchange.
    pub bell: Arc<Bell>,
}

impl Exchange {
    /// Joins what the system has abroad to its buses; to one without a name everything.
    pub(crate) fn new(
        units: &mut [Unit],
        topics: &[Topic],
        joints: &mut Joints,
        mut abroad: Abroad,
        buses: Vec<(Option<String>, Arc<dyn Bus>)>,
        incarnation: u64,
    ) -> Result<Self, BusError> {
        let named = |(name, _): &(Option<String>, _)| name.clone();
        let names: Vec<Option<String>> = buses.iter().map(named).collect();
        let mut lines = Vec::new();
        for (name, bus) in buses {
            let bell = Arc::clone(&abroad.bell);
            let membership = Arc::new(Membership {
                bus,
                incarnation,
                bell,
            });
            let name = name.as_deref();
            lines.push(Line::new(
                units,
                topics,
                joints,
                &mut abroad,
                name,
                membership,
            )?);
        }
        let homes = &abroad.homes;
        let is_inside = |unit| {
            !names
                .iter()
                .any(|name| line::is_here(homes, unit, name.as_deref()))
        };
        let inside: Vec<Topic> = topics.iter().map(|topic| topic.of(is_inside)).collect();
        let doors = Doors::of_topics(units, &inside, joints);
        Ok(Self {
            lines,
            counters: Vec::new(),
            inside: Some((inside, doors)),
            bell: abroad.bell,
        })
    }

    /// From now on topics come in by the threads that bring them.
    pub(crate) fn go_live(&self, world: &World) {
        for line in &self.lines {
            line.go_live(world);
        }
    }

    /// Serves over a bus that carries nothing else.
    pub(crate) fn serve(
        &mut self,
        units: &[Unit],
        offered: &[Offered],
        bus: Arc<dyn Bus>,
    ) -> Result<(), BusError> {
        let membership = Membership {
            bus,
            // it publishes nothing
            incarnation: 0,
            bell: Arc::clone(&self.bell),
        };
        self.counters
            .push(Offers::new(units, offered.iter(), &membership)?);
        Ok(())
    }

    /// Lets in what has come, and lets out what waits.
    pub(crate) fn deliver(&mut self, now: Time, outside: &mut dyn Outside) {
        if let Some((topics, mut doors)) = self.inside.take() {
            health::tell_alone(&topics, &mut doors, now, outside);
        }
        for line in &mut self.lines {
            line.deliver(now, outside);
        }
        for counter in &mut self.counters {
            counter.deliver(now, outside);
        }
    }

    /// Waits until something has come, or so long.
    pub(crate) fn wait(&self, at_most: Duration) {
        self.bell.wait(at_most);
    }

    /// The bell that ends a wait.
    pub(crate) fn bell(&self) -> Arc<Bell> {
        Arc::clone(&self.bell)
    }
}
