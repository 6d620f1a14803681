//! Connections that differ.

use asmotion_network::{has_same_queue, port_topic};
use asmotion_plan::{Connection, End, Terminal};
use asmotion_runtime::{Change, OuterEnd};

use super::difference::{Difference, outer_name};
use super::fixed_part::FixedPart;
use super::version::Version;
use crate::start;

impl Difference<'_> {
    pub(super) fn connections(&mut self, before: &[Connection], after: &[Connection]) {
        for it in before.iter().filter(|it| !after.contains(it)) {
            match self.reach(it) {
                Reach::Here(from, to) => {
                    let (from, to) = (from.to_string(), to.to_string());
                    self.ends.push(Change::Disconnect { from, to });
                }
                Reach::FromOther(from, to) => {
                    let has_other_queue = |other: &Connection| {
                        let kinds = [start::policy(it).kind, start::policy(other).kind];
                        other.from == it.from
                            && other.to == it.to
                            && !has_same_queue(kinds[0], kinds[1])
                    };
                    if after.iter().any(has_other_queue) {
                        let (from, to) = (from.to_string(), to.to_string());
                        self.fixed.push(FixedPart::Policy { from, to });
                    } else if self.is_kept(&to.component) {
                        let parted = self.subscription(self.versions.0, it, from, to);
                        self.ends.extend(parted.map(Change::Part));
                    }
                }
                Reach::Elsewhere => {}
            }
        }
        for it in after.iter().filter(|it| !before.contains(it)) {
            match self.reach(it) {
                Reach::Here(from, to) => self.begins.push(Change::Connect {
                    from: from.to_string(),
                    to: to.to_string(),
                    policy: start::policy(it),
                }),
                Reach::FromOther(from, to) => {
                    let joined = self.subscription(self.versions.1, it, from, to);
                    self.begins.extend(joined.map(Change::Join));
                }
                Reach::Elsewhere => {}
            }
        }
    }

    /// Returns where a connection begins and ends. Records one that cannot be changed as fixed; connections of other parts are
    /// ignored.
    fn reach<'c>(&mut self, connection: &'c Connection) -> Reach<'c> {
        let Connection { from, to, .. } = connection;
        let here = |terminal: &Terminal| match terminal {
            Terminal::Port(end) => self.is_here(&end.component),
            Terminal::Topic(_) | Terminal::Mqueue(_) => false,
        };
        match (from, to) {
            // topics are compared with the components that use them
            (Terminal::Port(_), Terminal::Topic(_)) | (Terminal::Topic(_), Terminal::Port(_)) => {
                Reach::Elsewhere
            }
            (Terminal::Port(one), Terminal::Port(other)) if here(from) && here(to) => {
                Reach::Here(one, other)
            }
            (Terminal::Port(one), Terminal::Port(other)) if here(to) && self.has_bus(other) => {
                Reach::FromOther(one, other)
            }
            // `senders` compares what leaves
            (Terminal::Port(one), Terminal::Port(_)) if here(from) && self.has_bus(one) => {
                Reach::Elsewhere
            }
            _ => {
                if here(from) || here(to) {
                    let (from, to) = (from.to_string(), to.to_string());
                    self.fixed.push(FixedPart::Connection { from, to });
                }
                Reach::Elsewhere
            }
        }
    }

    /// Returns whether the component of a port uses a bus.
    pub(super) fn has_bus(&self, port: &End) -> bool {
        let (running, wanted) = self.versions;
        let mut plans = [&wanted.plan, &running.plan].into_iter();
        let plan = plans.find(|it| it.component(&port.component).is_some());
        let bus = plan.and_then(|plan| plan.broker_of(&port.component));
        wanted.network.has(bus)
    }

    /// Returns how an input of this part reads a port of another process.
    fn subscription(
        &self,
        version: &Version,
        connection: &Connection,
        from: &End,
        to: &End,
    ) -> Option<OuterEnd> {
        let (topic, policy) = (port_topic(&from.to_string()), start::policy(connection));
        let name = outer_name(&version.plan, &to.component)?;
        let network = &self.versions.1.network;
        network.subscribe(name, &topic, &to.to_string(), policy)
    }
}

/// The processes at the ends of a connection.
enum Reach<'c> {
    /// Both ends are in this part.
    Here(&'c End, &'c End),
    /// It begins in another process.
    FromOther(&'c End, &'c End),
    /// It does not end in this part, or cannot be changed.
    Elsewhere,
}
