//! Names that AMQP can represent: at most 255 bytes. The client fails on longer ones.

use asmotion_bus::{BusError, Pattern, RobotAddress};

/// Length limit of an AMQP short string, in bytes.
pub(crate) const LONGEST: usize = 255;

/// Maps names to routing keys: prefixed with the robot's name, if there is one.
#[derive(Debug, Clone)]
pub(crate) struct RoutingNames {
    robot: Option<String>,
    /// Prefix of all queue names; permissions to configure queues refer to it.
    process: String,
    /// Suffix of all queue names, unique to this bus.
    lifetime_id: String,
}

impl RoutingNames {
    pub(crate) fn new(robot: Option<String>, process: String, lifetime_id: String) -> Self {
        Self {
            robot,
            process,
            lifetime_id,
        }
    }

    /// The routing key of a topic or address.
    pub(crate) fn key(&self, name: &str) -> Result<String, BusError> {
        let key = match &self.robot {
            Some(robot) => format!("{robot}.{name}"),
            None => name.to_owned(),
        };
        check_length(name, &key)?;
        Ok(key)
    }

    /// The routing key of an address that is called, which may be [that of another robot](RobotAddress).
    pub(crate) fn called_key(&self, name: &str) -> Result<String, BusError> {
        let Some(address) = RobotAddress::split(name) else {
            return self.key(name);
        };
        let key = address.key();
        check_length(name, &key)?;
        Ok(key)
    }

    /// The binding key of a pattern, which may be that of another robot's topics.
    pub(crate) fn binding(&self, pattern: &Pattern) -> Result<String, BusError> {
        self.called_key(pattern.as_str())
    }

    /// The topic of a routing key. A key of another robot is returned unchanged.
    pub(crate) fn topic<'a>(&self, key: &'a str) -> &'a str {
        let robot = self.robot.as_deref();
        let own = robot.and_then(|robot| key.strip_prefix(robot)?.strip_prefix('.'));
        own.unwrap_or(key)
    }

    /// Returns the queue name of a subscription, as operators see it: process, robot, reader, pattern, and a suffix
    /// that makes it unique. The readable part is truncated to leave room for the suffix.
    pub(crate) fn queue(&self, reader: &str, pattern: &Pattern, number: u64) -> String {
        let mut name = self.readable(reader, pattern);
        let own = format!(".{}.{number}", self.lifetime_id);
        while name.len() + own.len() > LONGEST && name.pop().is_some() {}
        name + &own
    }

    /// Returns the queue name of a subscription that is the same in every run of the process; `None` if it is too long. `number`
    /// distinguishes subscriptions of the same reader to the same pattern.
    pub(crate) fn returning_queue(
        &self,
        reader: &str,
        pattern: &Pattern,
        number: u64,
    ) -> Option<String> {
        let name = format!("{}.{number}", self.readable(reader, pattern));
        (name.len() <= LONGEST).then_some(name)
    }

    fn readable(&self, reader: &str, pattern: &Pattern) -> String {
        let mut name = self.process.clone();
        for word in self
            .robot
            .as_deref()
            .into_iter()
            .chain([reader, pattern.as_str()])
        {
            name.push('.');
            name.push_str(word);
        }
        name
    }
}

/// Rejects a text that is too long for a short string.
pub(crate) fn check_length(name: &str, text: &str) -> Result<(), BusError> {
    if text.len() <= LONGEST {
        return Ok(());
    }
    Err(BusError::InvalidName {
        name: name.to_owned(),
        reason: format!("{} bytes, but AMQP allows {LONGEST}", text.len()),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_below_the_robot_and_come_back_as_topics() {
        let names = RoutingNames::new(Some("rover1".into()), "onboard".into(), "l".into());
        assert_eq!(names.key("odom").unwrap(), "rover1.odom");
        assert_eq!(names.topic("rover1.odom"), "odom");
        assert_eq!(names.topic("rover10.odom"), "rover10.odom");
        let tool = RoutingNames::new(None, "tool".into(), "l".into());
        assert_eq!(tool.key("rover1.odom").unwrap(), "rover1.odom");
        assert_eq!(tool.topic("rover1.odom"), "rover1.odom");
    }

    #[test]
    fn n12_addresses_of_another_robot_keep_its_name() {
        let names = RoutingNames::new(Some("rover1".into()), "onboard".into(), "l".into());
        let maps = "robot://depot/MapServer.maps.getMap";
        assert_eq!(
            names.called_key(maps).unwrap(),
            "depot.MapServer.maps.getMap"
        );
        let presences = Pattern::new("robot://depot/presence.*");
        assert_eq!(names.binding(&presences).unwrap(), "depot.presence.*");
        assert_eq!(
            names.topic("depot.presence.station"),
            "depot.presence.station"
        );
        assert_eq!(
            names.called_key("maps.getMap").unwrap(),
            "rover1.maps.getMap"
        );
        assert!(
            names
                .called_key(&format!("robot://depot/{}", "x".repeat(250)))
                .is_err()
        );
    }

    #[test]
    fn a_queue_shows_who_reads_what() {
        let pattern = Pattern::new("map");
        let names = RoutingNames::new(Some("rover1".into()), "onboard".into(), "l".into());
        assert_eq!(
            names.queue("Planner", &pattern, 7),
            "onboard.rover1.Planner.map.l.7"
        );
        let tool = RoutingNames::new(None, "tool".into(), "l".into());
        assert_eq!(tool.queue("echo", &pattern, 7), "tool.echo.map.l.7");
        let returning = names.returning_queue("Planner", &pattern, 0);
        assert_eq!(returning.as_deref(), Some("onboard.rover1.Planner.map.0"));
        let long = Pattern::new("x".repeat(240));
        assert_eq!(names.returning_queue("Planner", &long, 0), None);
    }

    #[test]
    fn a_name_too_long_is_refused_and_a_queue_of_it_cut() {
        let names = RoutingNames::new(Some("rover1".into()), "onboard".into(), "l".into());
        assert!(names.key(&"x".repeat(248)).is_ok());
        assert!(names.key(&"x".repeat(249)).is_err());
        let pattern = Pattern::new("ü".repeat(200));
        let queue = names.queue("Planner", &pattern, 7);
        assert!(queue.len() <= LONGEST, "{queue}");
        assert!(queue.ends_with("ü.l.7"), "{queue}");
    }
}
