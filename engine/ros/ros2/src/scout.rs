//! Notices that participants are there again whose lease had ended.
//!
//! `rustdds` takes the announcements of such a participant for those that it has seen, because their numbers are the same, and does
//! not tell anybody. A participant that starts now has seen none. So while participants are missing, one looks for them from time to
//! time, and ends at once.

use std::collections::BTreeSet;
use std::net::IpAddr;
use std::sync::{Arc, Weak};
use std::time::{Duration, Instant};

use rustdds::{DomainParticipantBuilder, DomainParticipantStatusEvent, StatusEvented as _};

use crate::gid::Gid;
use crate::graph::SharedGraph;

/// Time in which participants answer the announcement of a new one.
const LOOK: Duration = Duration::from_secs(2);
/// Shortest and longest time between two looks; within, it is a quarter of the time for which the last one has been missing.
const PAUSES: [Duration; 2] = [Duration::from_secs(2), Duration::from_secs(60)];

/// Looks for missing participants in a domain.
#[derive(Clone)]
pub(crate) struct Scout {
    pub(crate) domain: u16,
    pub(crate) networks: Vec<IpAddr>,
}

impl Scout {
    /// Starts a thread that looks for the missing participants of a graph until there are none, or the graph is dropped.
    pub(crate) fn start(self, graph: &Arc<SharedGraph>) {
        let missing = Arc::downgrade(graph);
        let thread = std::thread::Builder::new().name("ros2 scout".to_owned());
        // without a thread, those that come back are not noticed
        let _ = thread.spawn(move || while self.look_again(&missing) {});
    }

    /// Waits, and looks once. Returns `false` at the end.
    fn look_again(&self, graph: &Weak<SharedGraph>) -> bool {
        let Some(since) = graph.upgrade().and_then(|it| it.newest_expiry()) else {
            return false;
        };
        let [shortest, longest] = PAUSES;
        std::thread::sleep((since.elapsed() / 4).clamp(shortest, longest));
        let Some(missing) = graph.upgrade().map(|it| it.expired()) else {
            return false;
        };
        for found in self.look(&missing) {
            if let Some(graph) = graph.upgrade() {
                graph.returned(found);
            }
        }
        true
    }

    /// Those of the missing participants that are there.
    fn look(&self, missing: &BTreeSet<[u8; 12]>) -> BTreeSet<[u8; 12]> {
        let mut found = BTreeSet::new();
        let mut builder = DomainParticipantBuilder::new(self.domain);
        if !self.networks.is_empty() {
            builder = builder.with_only_networks(self.networks.iter().copied());
        }
        let Ok(participant) = builder.build() else {
            return found;
        };
        let (status, until) = (participant.status_listener(), Instant::now() + LOOK);
        while found.len() < missing.len() && Instant::now() < until {
            match status.try_recv_status() {
                Some(DomainParticipantStatusEvent::ParticipantDiscovered { dpd }) => {
                    let participant = Gid::from(dpd.guid).participant();
                    found.extend(missing.get(&participant));
                }
                Some(_) => {}
                None => std::thread::sleep(Duration::from_millis(20)),
            }
        }
        found
    }
}
