//! A line: what of a system is on one bus.

use std::collections::BTreeMap;
use std::sync::Arc;

use asmotion_bus::BusError;

use super::Membership;
use super::offered::Offers;
use super::reached::Reached;
use super::topics::Topics;
use crate::Time;
use crate::live::World;
use crate::outside::Outside;
use crate::system::{Abroad, Joints, Topic, is_on};
use crate::unit::Unit;

/// What of a system is on one bus.
pub(super) struct Line {
    topics: Topics,
    offers: Offers,
    reached: Vec<Reached>,
}

/// Whether a component is on a bus.
pub(super) fn is_here(homes: &BTreeMap<usize, String>, unit: usize, bus: Option<&str>) -> bool {
    is_on(homes.get(&unit).map(String::as_str), bus)
}

impl Line {
    /// Joins what is on the bus of this name; everything, where it has none. What is reached over it is its own from
    /// now on.
    pub(super) fn new(
        units: &mut [Unit],
        topics: &[Topic],
        joints: &mut Joints,
        abroad: &mut Abroad,
        name: Option<&str>,
        membership: Arc<Membership>,
    ) -> Result<Self, BusError> {
        membership.bus.watch(&membership.bell);
        let homes = &abroad.homes;
        let of_line = |topic: &Topic| topic.of(|unit| is_here(homes, unit, name));
        let of_line: Vec<Topic> = topics.iter().map(of_line).collect();
        let exposed = abroad.exposed.iter();
        let exposed = exposed.filter(|(end, _)| is_here(homes, end.unit, name));
        let topics = Topics::new(units, &of_line, joints, exposed, abroad.topics, &membership)?;
        let offered = abroad.offered.iter();
        let offered = offered.filter(|offered| is_on(offered.bus.as_deref(), name));
        let offers = Offers::new(units, offered, &membership)?;
        let reached = (abroad.reached).extract_if(.., |it| is_on(it.bus.as_deref(), name));
        let reached = reached.map(|it| Reached::new(it.way, Arc::clone(&membership)));
        Ok(Self {
            topics,
            offers,
            reached: reached.collect(),
        })
    }

    /// From now on topics come in by the threads that bring them.
    pub(super) fn go_live(&self, world: &World) {
        self.topics.go_live(world);
    }

    /// Lets in what has come, and lets out what waits.
    pub(super) fn deliver(&mut self, now: Time, outside: &mut dyn Outside) {
        self.topics.deliver(now, outside);
        for reached in &mut self.reached {
            reached.deliver(now, outside);
        }
        self.offers.deliver(now, outside);
    }
}
