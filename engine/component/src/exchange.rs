//! The exchange: what of a system is on a bus. Topics and ports go out and come in, services are offered to others,
//! references reach services of others.
//!
//! It is looked after by one thread, the courier's or the simulation's: a cycle leaves what it sends in a queue, and
//! waits for no transport.

mod offered;
mod reached;
mod topics;

use std::sync::Arc;
use std::time::Duration;

use bus::{Bell, Bus, BusError};

use self::offered::Offers;
use self::reached::Reached;
use self::topics::Topics;
use crate::Time;
use crate::outside::Outside;
use crate::system::{Abroad, Topic};
use crate::unit::Unit;

pub(crate) use self::reached::Way;

/// The system's side of a bus.
pub(crate) struct Exchange {
    topics: Topics,
    offers: Offers,
    reached: Vec<Reached>,
    /// Keeps the bus as long as the system is on it.
    membership: Arc<Membership>,
}

/// The bus, and who we are on it.
pub(crate) struct Membership {
    pub bus: Arc<dyn Bus>,
    /// Which life of the system's process.
    pub incarnation: u64,
    /// Rung for everything that comes, and when the bus is up, blocked or down.
    pub bell: Arc<Bell>,
}

impl Exchange {
    /// Joins what the system has abroad to the bus.
    pub(crate) fn new(
        units: &mut [Unit],
        topics: &[Topic],
        abroad: Abroad,
        bus: Arc<dyn Bus>,
        incarnation: u64,
    ) -> Result<Self, BusError> {
        let membership = Arc::new(Membership {
            bus,
            incarnation,
            bell: Arc::clone(&abroad.bell),
        });
        membership.bus.watch(&membership.bell);
        let topics = Topics::new(units, topics, &abroad, &membership)?;
        let offers = Offers::new(units, &abroad.offered, &membership)?;
        let reach = |way| Reached::new(way, Arc::clone(&membership));
        Ok(Self {
            topics,
            offers,
            reached: abroad.reached.into_iter().map(reach).collect(),
            membership,
        })
    }

    /// Lets in what has come, and lets out what waits.
    pub(crate) fn deliver(&mut self, now: Time, outside: &mut dyn Outside) {
        self.topics.deliver(now, outside);
        for reached in &mut self.reached {
            reached.deliver(now, outside);
        }
        self.offers.deliver(now, outside);
    }

    /// Waits until something has come, or so long.
    pub(crate) fn wait(&self, at_most: Duration) {
        self.membership.bell.wait(at_most);
    }

    /// The bell that ends a wait.
    pub(crate) fn bell(&self) -> Arc<Bell> {
        Arc::clone(&self.membership.bell)
    }
}
