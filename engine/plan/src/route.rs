//! Selection of brokers and gateways.
//!
//! The broker of a component is determined by [`asmotion_composite::model::ComponentBrokers`]. If no component has
//! a broker, all use the only one of the composite.

use std::collections::BTreeSet;

use asmotion_bus::RobotAddress;

use crate::joint::Promoted;
use crate::part::Part;
use crate::plan::{Broker, End, Endpoint, Gateway, Plan, Wire};
use asmotion_composite::model::Transport;

impl Plan {
    /// Returns whether any component, wire or promotion names a broker.
    pub fn names_brokers(&self) -> bool {
        let leaving = self.wires.iter().filter(|it| self.leaves_process(it));
        let of_wires = leaving.map(|it| &it.broker);
        let of_promotions = self.promoted.iter().map(|it| &it.broker);
        self.has_component_broker || of_wires.chain(of_promotions).any(Option::is_some)
    }

    /// Returns whether calls through a wire leave the process of the caller.
    fn leaves_process(&self, wire: &Wire) -> bool {
        let process = |end: &End| self.process_of(&end.component).map(|it| &it.name);
        let mut services = wire.services.iter();
        wire.goes_abroad() || services.any(|it| process(it) != process(&wire.reference))
    }

    /// Returns the broker of a component; `None` if it has none.
    pub fn broker_of(&self, component: &str) -> Option<&str> {
        if self.brokers.is_empty() {
            return None;
        }
        match (self.has_component_broker, &*self.brokers) {
            (true, _) => self.component(component)?.pace.broker.as_deref(),
            (false, [only]) => Some(&only.name),
            (false, _) => None,
        }
    }

    /// Returns the broker of a wire between processes: that of the wire, the caller or the service, in this order.
    pub fn broker_of_wire<'p>(&'p self, wire: &'p Wire) -> Option<&'p str> {
        let of_ends = || {
            let mut ends = std::iter::once(&wire.reference).chain(&wire.services);
            ends.find_map(|end| self.broker_of(&end.component))
        };
        wire.broker.as_deref().or_else(of_ends)
    }

    /// Returns the public names and brokers under which a service is available outside a part.
    pub fn doors(
        &self,
        component: &str,
        service: &str,
        part: &Part,
    ) -> Vec<(String, Option<&str>)> {
        let end = End {
            component: component.to_owned(),
            name: service.to_owned(),
        };
        let own = end.to_string();
        let mut doors = vec![(own.clone(), self.broker_of(component))];
        for wire in self.wires.to_service(&end) {
            if wire.goes_abroad() || !part.has(&wire.reference.component) {
                doors.push((own.clone(), self.broker_of_wire(wire)));
            }
        }
        let promoted = self.promoted_over_brokers(&end);
        doors.extend(promoted.map(|(name, broker)| (name.to_owned(), broker)));
        doors
    }

    /// Iterates over the names under which a service is promoted over AMQP, with the broker.
    pub fn promoted_over_brokers<'p>(
        &'p self,
        service: &End,
    ) -> impl Iterator<Item = (&'p str, Option<&'p str>)> {
        let inside = service.to_string();
        let own = self.broker_of(&service.component);
        let promoted = self.promoted.iter();
        let promoted =
            promoted.filter(move |it| it.is_served_over(Transport::Amqp) && it.inside == inside);
        promoted.map(move |it| (it.name.as_str(), it.broker.as_deref().or(own)))
    }

    /// Returns the services of a part that are promoted over AMQP.
    pub fn services_over_brokers<'p>(
        &'p self,
        part: &'p Part,
    ) -> impl Iterator<Item = &'p Promoted> {
        let promoted = self.promoted.iter();
        promoted.filter(|it| {
            let (component, _) = it.inside.split_once('.').unwrap_or_default();
            it.is_served_over(Transport::Amqp) && part.has(component)
        })
    }

    /// Returns the gateways of a part, each with the services promoted through it.
    pub fn gateways_of(&self, part: &Part) -> Vec<(&Gateway, Vec<&Promoted>)> {
        let is_here = |promoted: &Promoted| {
            let (component, _) = promoted.inside.split_once('.').unwrap_or_default();
            part.has(component)
        };
        let through = |gateway: &Gateway| {
            let promoted = self.promoted.iter().filter(|it| {
                let is_its = it.gateway.as_ref() == Some(&gateway.name);
                is_its && it.is_served_over(Transport::Http) && is_here(it)
            });
            promoted.collect::<Vec<_>>()
        };
        let gateways = self.gateways.iter().map(|it| (it, through(it)));
        gateways
            .filter(|(_, promoted)| !promoted.is_empty())
            .collect()
    }

    /// Returns the wires from a part to services of other systems and robots, each with the URL of the service.
    pub fn wires_outside<'p>(
        &'p self,
        part: &'p Part,
    ) -> impl Iterator<Item = (&'p Wire, &'p Endpoint)> {
        let wires = self.wires.iter();
        let here = wires.filter(|wire| part.has(&wire.reference.component));
        here.filter_map(|wire| Some((wire, wire.url.as_ref()?)))
    }

    /// Returns the wires from a part to services of other systems over HTTP, each with the URL of the service.
    pub fn wires_over_http<'p>(
        &'p self,
        part: &'p Part,
    ) -> impl Iterator<Item = (&'p Wire, &'p Endpoint)> {
        let wires = self.wires_outside(part);
        wires.filter(|(wire, _)| wire.binding == Transport::Http)
    }

    /// Returns the addresses of services of other robots that a part calls.
    pub fn robot_addresses<'p>(&'p self, part: &'p Part) -> impl Iterator<Item = RobotAddress<'p>> {
        let wires = self.wires_outside(part);
        wires.filter_map(|(wire, _)| robot_address(wire))
    }

    /// Returns the brokers used by a part.
    pub fn brokers_of(&self, part: &Part) -> Vec<&Broker> {
        let here = self.components.iter().filter(|it| part.has(&it.name));
        let mut names: BTreeSet<&str> = BTreeSet::new();
        for component in here {
            names.extend(self.broker_of(&component.name));
            for service in &component.services {
                let doors = self.doors(&component.name, &service.name, part);
                names.extend(doors.into_iter().filter_map(|(_, broker)| broker));
            }
        }
        let calls = self
            .wires
            .iter()
            .filter(|it| part.has(&it.reference.component));
        let leaves = |wire: &&Wire| {
            let mut services = wire.services.iter();
            wire.goes_abroad() || services.any(|service| !part.has(&service.component))
        };
        names.extend(
            calls
                .filter(leaves)
                .filter_map(|it| self.broker_of_wire(it)),
        );
        let brokers = self.brokers.iter();
        brokers.filter(|it| names.contains(&*it.name)).collect()
    }
}

/// Returns the address of the service of another robot that a wire leads to; `None` for any other wire.
pub fn robot_address(wire: &Wire) -> Option<RobotAddress<'_>> {
    let url = wire.url.as_ref().filter(|_| wire.goes_abroad())?;
    RobotAddress::split(url.reveal())
}
