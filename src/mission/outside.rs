//! Systems outside of a composite that its run needs: other robots, message queues and services over HTTP.

use std::fmt;

/// A system outside of a composite, by its address.
#[derive(Clone, Debug, PartialEq)]
pub enum OutsideSystem {
    /// A component of another robot.
    RobotComponent(String),
    /// A service of another robot.
    RobotService(String),
    /// A message queue, or a service over HTTP.
    WallClock(String),
}

impl OutsideSystem {
    /// Returns the option of `asmotion run` that makes it available.
    pub(super) fn option(&self) -> &'static str {
        match self {
            Self::RobotComponent(_) => "add `--bus amqp://user@host:port/vhost`",
            Self::RobotService(_) => {
                "add `--bus amqp://user@host:port/vhost`, or write a profile without this wire"
            }
            Self::WallClock(_) => "add `--clock wall`",
        }
    }
}

impl fmt::Display for OutsideSystem {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::RobotComponent(address) => write!(
                to,
                "`{address}` is a component of another robot, which is reached over a broker"
            ),
            Self::RobotService(address) => write!(
                to,
                "`{address}` is a service of another robot, which is called over a broker"
            ),
            Self::WallClock(address) => write!(
                to,
                "`{address}` leads to another process, which uses the wall clock"
            ),
        }
    }
}
