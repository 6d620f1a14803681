//! The wires of a plan.

use std::collections::BTreeMap;
use std::fmt;
use std::ops::Deref;

use asmotion_composite::end::End;
use asmotion_composite::model::PlannedWire as Wire;

/// Wires in file order, with an index by their ends: starting a system looks up those of each reference and each service, of which there
/// may be thousands.
#[derive(Clone, Default, PartialEq)]
pub struct WireList {
    wires: Vec<Wire>,
    /// Positions of the wires of a reference.
    of_reference: BTreeMap<End, Vec<usize>>,
    /// Positions of the wires to a service.
    to_service: BTreeMap<End, Vec<usize>>,
}

impl WireList {
    /// Appends a wire.
    pub(crate) fn push(&mut self, wire: Wire) {
        let position = self.wires.len();
        let of_reference = self.of_reference.entry(wire.reference.clone());
        of_reference.or_default().push(position);
        for service in &wire.services {
            let to_service = self.to_service.entry(service.clone()).or_default();
            // a wire can name a service twice
            if to_service.last() != Some(&position) {
                to_service.push(position);
            }
        }
        self.wires.push(wire);
    }

    /// Iterates over the wires of a reference, in file order.
    pub fn of_reference<'l>(&'l self, reference: &End) -> impl Iterator<Item = &'l Wire> + use<'l> {
        self.at(self.of_reference.get(reference))
    }

    /// Iterates over the wires to a service, in file order.
    pub fn to_service<'l>(&'l self, service: &End) -> impl Iterator<Item = &'l Wire> + use<'l> {
        self.at(self.to_service.get(service))
    }

    fn at<'l>(&'l self, positions: Option<&'l Vec<usize>>) -> impl Iterator<Item = &'l Wire> {
        let positions = positions.into_iter().flatten();
        positions.filter_map(|position| self.wires.get(*position))
    }
}

/// The wires as a list.
impl fmt::Debug for WireList {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.wires.fmt(f)
    }
}

impl Deref for WireList {
    type Target = [Wire];

    fn deref(&self) -> &[Wire] {
        &self.wires
    }
}

impl<'l> IntoIterator for &'l WireList {
    type Item = &'l Wire;
    type IntoIter = std::slice::Iter<'l, Wire>;

    fn into_iter(self) -> Self::IntoIter {
        self.wires.iter()
    }
}
