//! Addresses of other robots, on a bus that several robots share.

use std::fmt;

/// Beginning of every address of another robot.
const SCHEME: &str = "robot://";

/// An address, or a pattern of topics, of another robot; displayed as `robot://depot/MapServer.maps`. On a bus whose names
/// begin with the name of the own robot, all other addresses belong to the own robot.
///
/// ```
/// use asmotion_bus::RobotAddress;
///
/// let maps = RobotAddress::parse("robot://depot/MapServer.maps")?;
/// assert_eq!(maps.key(), "depot.MapServer.maps");
/// # Ok::<(), &str>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RobotAddress<'a> {
    robot: &'a str,
    name: &'a str,
}

impl<'a> RobotAddress<'a> {
    /// Creates the address of a name that belongs to a robot.
    pub fn new(robot: &'a str, name: &'a str) -> Self {
        Self { robot, name }
    }

    /// Splits an address; `None` if it belongs to the own robot. The names are not checked.
    pub fn split(address: &'a str) -> Option<Self> {
        let (robot, name) = address.strip_prefix(SCHEME)?.split_once('/')?;
        Some(Self { robot, name })
    }

    /// Reads the address of a service, `robot://ROBOT/Component.service` or `robot://ROBOT/name` for a promoted one.
    ///
    /// # Errors
    /// The reason that the text is no such address.
    pub fn parse(text: &'a str) -> Result<Self, &'static str> {
        let Some(rest) = text.strip_prefix(SCHEME) else {
            return Err("does not begin with `robot://`");
        };
        let (robot, name) = rest.split_once('/').unwrap_or((rest, ""));
        if robot.is_empty() {
            Err("has no robot")
        } else if name.is_empty() {
            Err("has no service")
        } else if !robot.split('.').all(is_word) {
            Err("has an invalid name of a robot")
        } else if !name.split(['.', '/']).all(is_word) {
            Err("has an invalid name of a service")
        } else {
            Ok(Self { robot, name })
        }
    }

    /// Name of the robot.
    pub fn robot(&self) -> &'a str {
        self.robot
    }

    /// The address or pattern within the robot.
    pub fn name(&self) -> &'a str {
        self.name
    }

    /// The name with the robot's name as a prefix, as all robots see it.
    pub fn key(&self) -> String {
        format!("{}.{}", self.robot, self.name)
    }
}

fn is_word(word: &str) -> bool {
    let is_letter = |letter: char| letter.is_alphanumeric() || matches!(letter, '_' | '-');
    !word.is_empty() && word.chars().all(is_letter)
}

impl fmt::Display for RobotAddress<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{SCHEME}{}/{}", self.robot, self.name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn n12_an_address_names_a_robot_and_a_service() {
        for (text, robot, name) in [
            ("robot://depot/MapServer.maps", "depot", "MapServer.maps"),
            ("robot://site-1.depot/maps", "site-1.depot", "maps"),
            (
                "robot://depot/Arm/Driver.moves",
                "depot",
                "Arm/Driver.moves",
            ),
        ] {
            let address = RobotAddress::parse(text).unwrap();
            assert_eq!((address.robot(), address.name()), (robot, name));
            assert_eq!(address.to_string(), text);
            assert_eq!(RobotAddress::split(text), Some(address));
        }
        for text in [
            "http://depot/MapServer.maps",
            "depot.MapServer.maps",
            "robot://depot",
            "robot://depot/",
            "robot:///MapServer.maps",
            "robot://de pot/MapServer.maps",
            "robot://*/MapServer.maps",
            "robot://depot/MapServer..maps",
            "robot://depot/#",
        ] {
            assert!(RobotAddress::parse(text).is_err(), "{text}");
        }
    }
}
