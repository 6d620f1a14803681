//! Wires that differ.

use asmotion_plan::{End, Endpoint, Part, Plan, Wire};
use asmotion_runtime::{Change, OuterEnd};

use super::difference::Difference;
use super::fixed_part::FixedPart;
use crate::start;

impl Difference<'_> {
    pub(super) fn wires(&mut self, before: &Plan, after: &Plan) {
        let (running, wanted) = self.versions;
        let (before, after) = (joints(before, &running.part), joints(after, &wanted.part));
        for it in before.iter().filter(|it| !after.contains(it)) {
            match self.wire(it) {
                WireReach::Here(reference, service) => {
                    self.ends.push(Change::Unwire { reference, service });
                }
                WireReach::Outside(end) => self.ends.push(Change::Part(end)),
                WireReach::Elsewhere => {}
            }
        }
        for it in after.iter().filter(|it| !before.contains(it)) {
            match self.wire(it) {
                WireReach::Here(reference, service) => self.begins.push(Change::Wire {
                    reference,
                    service,
                    wire: it.how,
                }),
                WireReach::Outside(end) => self.begins.push(Change::Join(end)),
                WireReach::Elsewhere => {}
            }
        }
    }

    /// Returns where a wire leads if it begins in this part and the component declares the reference.
    fn wire(&mut self, joint: &WiredService<'_>) -> WireReach {
        let reference = joint.reference;
        if !self.is_here(&reference.component) {
            return WireReach::Elsewhere;
        }
        let (from, to) = (reference.to_string(), joint.service.clone());
        let declared = self.declaration(&reference.component);
        let is_declared = declared.reference(&reference.name).is_some();
        if joint.stays_here {
            return if is_declared {
                WireReach::Here(from, to)
            } else {
                WireReach::Elsewhere
            };
        }
        let network = &self.versions.1.network;
        let outside = joint
            .is_of_plan
            .then(|| network.call(&from, &to, joint.how, joint.broker));
        match outside.flatten() {
            Some(end) if is_declared => WireReach::Outside(end),
            Some(_) => WireReach::Elsewhere,
            None => {
                let (reference, service) = (from, to);
                self.fixed.push(FixedPart::Wire { reference, service });
                WireReach::Elsewhere
            }
        }
    }
}

/// Location of the service at the end of a wire.
enum WireReach {
    /// To a service of this part: reference and service.
    Here(String, String),
    /// To a service of another process.
    Outside(OuterEnd),
    /// The wire begins in another part, or cannot be changed.
    Elsewhere,
}

/// One service of a wire.
#[derive(PartialEq)]
struct WiredService<'p> {
    reference: &'p End,
    /// A service of the plan, or a URL.
    service: String,
    is_of_plan: bool,
    token: Option<&'p Endpoint>,
    /// File with the certificate authorities.
    authorities: Option<&'p str>,
    /// Broker of a call that leaves the part.
    broker: Option<&'p str>,
    how: asmotion_component::Wire,
    /// `true` if both ends run in this part and the call does not go over a bus.
    stays_here: bool,
}

fn joints<'p>(plan: &'p Plan, part: &Part) -> Vec<WiredService<'p>> {
    let wires: &'p [Wire] = &plan.wires;
    let mut joints = Vec::new();
    for wire in wires {
        let broker = plan.broker_of_wire(wire);
        joints.extend(wire.services.iter().map(|service| {
            let stays_here = start::stays_here(wire, service, part);
            WiredService {
                reference: &wire.reference,
                service: service.to_string(),
                is_of_plan: true,
                token: None,
                authorities: None,
                broker: broker.filter(|_| !stays_here),
                how: start::how(wires, wire),
                stays_here,
            }
        }));
        joints.extend(wire.url.iter().map(|url| WiredService {
            reference: &wire.reference,
            service: url.shown().to_owned(),
            is_of_plan: false,
            token: wire.token.as_ref(),
            authorities: wire.ca.as_deref(),
            broker,
            how: start::how(wires, wire),
            stays_here: false,
        }));
    }
    joints
}
