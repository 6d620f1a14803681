//! Where ports of a composite are on buses, for bridges that tell others what they relay.

use std::collections::{BTreeMap, BTreeSet};

use asmotion_composite::end::{End, Terminal};
use asmotion_composite::split_robot_component;
use asmotion_plan::{Component, Plan};
use asmotion_ros_gateway::bus_topic;

use crate::broker::BrokerSettings;

/// The brokers of a mission: what identifies each, and the name of the robot there.
#[derive(Default)]
pub(crate) struct BusPlaces {
    /// By name; without a name if one carries everything.
    places: BTreeMap<Option<String>, (String, String)>,
}

impl BusPlaces {
    /// The brokers with these settings, by name; without a name if one carries everything. `composite` is the default name of the
    /// robot.
    pub(crate) fn of(brokers: &BTreeMap<Option<&str>, &BrokerSettings>, composite: &str) -> Self {
        let place = |settings: &BrokerSettings| {
            let robot = settings.robot().unwrap_or(composite);
            (settings.place(), robot.to_owned())
        };
        let places = brokers.iter();
        let places = places.map(|(name, it)| (name.map(str::to_owned), place(it)));
        Self {
            places: places.collect(),
        }
    }

    /// Returns the names under which relays list a port on a bus: that of its topic, that of the port itself, which other robots reach,
    /// and those of the ports of other robots with which it is connected. Empty without a bus.
    pub(crate) fn of_port(&self, plan: &Plan, component: &Component, port: &str) -> Vec<String> {
        let named = || {
            let broker = plan.broker_of(&component.name)?;
            self.places.get(&Some(broker.to_owned()))
        };
        let Some((place, robot)) = self.places.get(&None).or_else(named) else {
            return Vec::new();
        };
        let own = format!("{}.{port}", component.name);
        let is_own = |end: &End| end.component == component.name && end.name == port;
        let mut partners: BTreeSet<&End> = BTreeSet::new();
        let mut names = BTreeSet::from([format!("{robot}.{own}")]);
        for topic in &plan.topics {
            let ends = [&topic.publishers, &topic.subscribers];
            if ends.iter().any(|it| it.iter().any(is_own)) {
                names.insert(format!("{robot}.{}", topic.name));
                partners.extend(ends.into_iter().flatten());
            }
        }
        for connection in &plan.connections {
            if let (Terminal::Port(from), Terminal::Port(to)) = (&connection.from, &connection.to)
                && (is_own(from) || is_own(to))
            {
                partners.extend([from, to]);
            }
        }
        let of_robots = partners.into_iter().filter_map(|end| {
            let stand_in = plan.component(&end.component)?;
            let address = stand_in.implementation.robot_component()?;
            let (robot, there) = split_robot_component(address).ok()?;
            Some(format!("{robot}.{there}.{}", end.name))
        });
        names.extend(of_robots);
        names.iter().map(|it| bus_topic(place, it)).collect()
    }
}
