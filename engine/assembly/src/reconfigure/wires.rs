//! Wires that differ.

use std::collections::BTreeSet;

use asmotion_bus::RobotAddress;
use asmotion_network::OuterCaller;
use asmotion_plan::{End, Endpoint, Part, Plan, robot_address};
use asmotion_runtime::{Change, OuterEnd};

use super::difference::Difference;
use super::fixed_part::FixedPart;
use super::version::Version;
use crate::start;

impl Difference<'_> {
    /// Compares the services of references. Where a specification calls further operations through a reference, the reference is
    /// wired again.
    pub(super) fn wires(&mut self, before: &Plan, after: &Plan) {
        let (running, wanted) = self.versions;
        let extended = self.extended_references();
        let (before, after) = (joints(before, &running.part), joints(after, &wanted.part));
        let (had, has) = (self.declared_running(before), self.declared_wanted(after));
        let is_same = |it: &WiredService<'_>, others: &[WiredService<'_>]| {
            others.contains(it) && !extended.contains(&it.reference.to_string())
        };
        for it in had.iter().filter(|it| !is_same(it, &has)) {
            self.ends.push(Change::Unwire {
                reference: it.reference.to_string(),
                service: it.service.clone(),
            });
        }
        for it in has.iter().filter(|it| !is_same(it, &had)) {
            let reference = it.reference.to_string();
            let change = match self.outside(wanted, it) {
                None => Change::Wire {
                    reference,
                    service: it.service.clone(),
                    wire: it.how,
                },
                Some(Some(end)) => Change::Join(end),
                Some(None) => {
                    let service = it.service.clone();
                    self.fixed.push(FixedPart::Wire { reference, service });
                    continue;
                }
            };
            self.begins.push(change);
        }
    }

    /// The wires whose references the running components declare.
    fn declared_running<'p>(&self, mut joints: Vec<WiredService<'p>>) -> Vec<WiredService<'p>> {
        joints.retain(|it| self.runs_with(it.reference));
        joints
    }

    /// The wires whose references the components of the wanted version have. A reference that a specification does not use any more
    /// stays, and keeps the wires that the composite has.
    fn declared_wanted<'p>(&self, mut joints: Vec<WiredService<'p>>) -> Vec<WiredService<'p>> {
        joints.retain(|it| {
            let End { component, name } = it.reference;
            let declared = self.declaration(component);
            self.is_here(component)
                && (declared.reference(name).is_some() || self.runs_with(it.reference))
        });
        joints
    }

    /// Returns whether a running component of this part declares the reference.
    fn runs_with(&self, reference: &End) -> bool {
        let declared = self.run.declaration(&reference.component);
        self.is_here(&reference.component)
            && declared.is_some_and(|it| it.reference(&reference.name).is_some())
    }

    /// The references through which components call operations that they did not declare before.
    fn extended_references(&self) -> BTreeSet<String> {
        let mut extended = BTreeSet::new();
        for (component, declared) in &self.declared {
            let Some(running) = self.run.declaration(component) else {
                continue;
            };
            for reference in &declared.references {
                let known = running.reference(&reference.name);
                let known = known.map_or(&[][..], |it| &it.operations);
                let mut operations = reference.operations.iter();
                if operations.any(|it| known.iter().all(|known| known.name != it.name)) {
                    extended.insert(format!("{component}.{}", reference.name));
                }
            }
        }
        extended
    }

    /// Returns how a wire leads to a service outside; `None` if it stays in this part, `Some(None)` if the process is not connected
    /// to its broker.
    fn outside(&self, wanted: &Version, joint: &WiredService<'_>) -> Option<Option<OuterEnd>> {
        let reference = joint.reference.to_string();
        let caller = OuterCaller {
            reference: &reference,
            wire: joint.how,
            bus: joint.broker,
            known: wanted.operations(),
        };
        let network = &wanted.network;
        Some(match joint.target {
            Target::Here => return None,
            Target::OtherProcess => network.call(caller, &joint.service),
            Target::Robot(robot, name) => {
                network.call_robot(caller, RobotAddress::new(robot, name))
            }
            Target::System {
                url,
                token,
                authorities,
            } => {
                let client = wanted.client(token.cloned(), authorities.map(str::to_owned));
                network.call_external(caller, (url.reveal(), url.shown()), client)
            }
        })
    }
}

/// One service of a wire.
#[derive(PartialEq)]
struct WiredService<'p> {
    reference: &'p End,
    /// A service of the plan, or a URL without secrets.
    service: String,
    target: Target<'p>,
    /// Broker of a call that leaves the part.
    broker: Option<&'p str>,
    how: asmotion_component::Wire,
}

/// The system that provides the service of a wire.
#[derive(Clone, Copy, PartialEq)]
enum Target<'p> {
    /// This part, without a bus.
    Here,
    /// Another process, or this one over a bus.
    OtherProcess,
    /// Another robot: its name, and the name of the service.
    Robot(&'p str, &'p str),
    /// Another system over HTTP.
    System {
        url: &'p Endpoint,
        token: Option<&'p Endpoint>,
        /// File with the certificate authorities.
        authorities: Option<&'p str>,
    },
}

fn joints<'p>(plan: &'p Plan, part: &Part) -> Vec<WiredService<'p>> {
    let mut joints = Vec::new();
    for wire in &plan.wires {
        let broker = plan.broker_of_wire(wire);
        let how = start::how(&plan.wires, wire);
        joints.extend(wire.services.iter().map(|service| {
            let stays_here = start::stays_here(wire, service, part);
            WiredService {
                reference: &wire.reference,
                service: service.to_string(),
                target: if stays_here {
                    Target::Here
                } else {
                    Target::OtherProcess
                },
                broker: broker.filter(|_| !stays_here),
                how,
            }
        }));
        joints.extend(wire.url.iter().map(|url| WiredService {
            reference: &wire.reference,
            service: url.shown().to_owned(),
            target: match robot_address(wire) {
                Some(robot) => Target::Robot(robot.robot(), robot.name()),
                None => Target::System {
                    url,
                    token: wire.token.as_ref(),
                    authorities: wire.ca.as_deref(),
                },
            },
            broker,
            how,
        }));
    }
    joints
}
