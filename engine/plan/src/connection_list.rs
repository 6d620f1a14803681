//! The connections of a plan.

use std::collections::BTreeMap;
use std::fmt;
use std::ops::Deref;

use asmotion_composite::end::{End, Terminal};

use crate::joint::Connection;

/// Connections in file order, with an index by their ends: planning and starting a system look up those of each port and each topic,
/// of which there may be thousands.
#[derive(Clone, Default, PartialEq)]
pub struct ConnectionList {
    connections: Vec<Connection>,
    /// Positions of the connections that begin at an end.
    from: BTreeMap<Terminal, Vec<usize>>,
    /// Positions of the connections that lead to an end.
    to: BTreeMap<Terminal, Vec<usize>>,
}

impl ConnectionList {
    /// Appends a connection.
    pub(crate) fn push(&mut self, connection: Connection) {
        let position = self.connections.len();
        for (index, end) in [
            (&mut self.from, &connection.from),
            (&mut self.to, &connection.to),
        ] {
            match index.get_mut(end) {
                Some(positions) => positions.push(position),
                None => {
                    index.insert(end.clone(), vec![position]);
                }
            }
        }
        self.connections.push(connection);
    }

    /// Iterates over the connections that begin at an end, in file order.
    pub fn from_end<'l>(
        &'l self,
        end: &Terminal,
    ) -> impl Iterator<Item = &'l Connection> + Clone + use<'l> {
        self.at(self.from.get(end))
    }

    /// Iterates over the connections that lead to an end, in file order.
    pub fn to_end<'l>(
        &'l self,
        end: &Terminal,
    ) -> impl Iterator<Item = &'l Connection> + Clone + use<'l> {
        self.at(self.to.get(end))
    }

    /// Iterates over the connections that lead to a component, by the names of its ports.
    pub fn to_component(&self, component: &str) -> impl Iterator<Item = &Connection> {
        let first = Terminal::Port(End {
            component: component.to_owned(),
            name: String::new(),
        });
        let of_component =
            move |end: &Terminal| matches!(end, Terminal::Port(end) if end.component == component);
        let ends = self.to.range(first..);
        let ends = ends.take_while(move |(end, _)| of_component(end));
        ends.flat_map(|(_, positions)| self.at(Some(positions)))
    }

    fn at<'l>(
        &'l self,
        positions: Option<&'l Vec<usize>>,
    ) -> impl Iterator<Item = &'l Connection> + Clone {
        let positions = positions.into_iter().flatten();
        positions.filter_map(|position| self.connections.get(*position))
    }
}

/// The connections as a list.
impl fmt::Debug for ConnectionList {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.connections.fmt(f)
    }
}

impl Deref for ConnectionList {
    type Target = [Connection];

    fn deref(&self) -> &[Connection] {
        &self.connections
    }
}

impl<'c> IntoIterator for &'c ConnectionList {
    type Item = &'c Connection;
    type IntoIter = std::slice::Iter<'c, Connection>;

    fn into_iter(self) -> Self::IntoIter {
        self.connections.iter()
    }
}
