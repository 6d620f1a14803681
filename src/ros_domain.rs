//! The domain and the networks of ROS 2, as the environment variables of ROS set them.

use std::net::{IpAddr, Ipv4Addr};

/// A variable of ROS has a value that this build cannot follow.
#[derive(Debug, thiserror::Error, PartialEq, Eq)]
#[error("the environment variable {name} is `{value}`: {expected} is expected")]
pub struct RosVariableError {
    name: &'static str,
    value: String,
    expected: &'static str,
}

impl From<RosVariableError> for String {
    fn from(error: RosVariableError) -> Self {
        error.to_string()
    }
}

fn variable(name: &str) -> Option<String> {
    std::env::var(name).ok().filter(|value| !value.is_empty())
}

/// The domain id of the environment: `ROS_DOMAIN_ID`, or 0.
///
/// # Errors
/// The variable is not a domain id.
pub fn own_domain() -> Result<u16, RosVariableError> {
    domain_in(variable("ROS_DOMAIN_ID"))
}

fn domain_in(value: Option<String>) -> Result<u16, RosVariableError> {
    let Some(value) = value else {
        return Ok(0);
    };
    let parsed = value.trim().parse().ok().filter(|domain| *domain <= 232);
    parsed.ok_or(RosVariableError {
        name: "ROS_DOMAIN_ID",
        value,
        expected: "a number from 0 to 232",
    })
}

/// The networks that the environment permits: the loopback interface if `ROS_AUTOMATIC_DISCOVERY_RANGE` is `LOCALHOST`, or if
/// `ROS_LOCALHOST_ONLY` is 1; otherwise all, which is the empty list.
///
/// # Errors
/// The range is `OFF`, which `rustdds` does not have, or no range.
pub fn networks() -> Result<Vec<IpAddr>, RosVariableError> {
    let range = variable("ROS_AUTOMATIC_DISCOVERY_RANGE");
    networks_in(range, variable("ROS_LOCALHOST_ONLY"))
}

fn networks_in(
    range: Option<String>,
    localhost_only: Option<String>,
) -> Result<Vec<IpAddr>, RosVariableError> {
    let loopback = vec![Ipv4Addr::LOCALHOST.into()];
    // the older variable takes precedence, as in ROS
    if localhost_only.as_deref() == Some("1") {
        return Ok(loopback);
    }
    match range.as_deref() {
        Some("LOCALHOST") => Ok(loopback),
        None | Some("SUBNET" | "SYSTEM_DEFAULT") => Ok(Vec::new()),
        Some(other) => Err(RosVariableError {
            name: "ROS_AUTOMATIC_DISCOVERY_RANGE",
            value: other.to_owned(),
            expected: "LOCALHOST, SUBNET or SYSTEM_DEFAULT",
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(text: &str) -> Option<String> {
        Some(text.to_owned())
    }

    #[test]
    fn the_domain_is_a_number_up_to_232() {
        assert_eq!(domain_in(None), Ok(0));
        assert_eq!(domain_in(text("42")), Ok(42));
        for wrong in ["233", "-1", "robot"] {
            let error = domain_in(text(wrong)).unwrap_err().to_string();
            assert_eq!(
                error,
                format!(
                    "the environment variable ROS_DOMAIN_ID is `{wrong}`: a number from 0 to 232 is expected"
                )
            );
        }
    }

    #[test]
    fn discovery_is_limited_to_this_machine_on_demand() {
        let loopback = Ok(vec![IpAddr::V4(Ipv4Addr::LOCALHOST)]);
        assert_eq!(networks_in(None, None), Ok(vec![]));
        assert_eq!(networks_in(text("SUBNET"), text("0")), Ok(vec![]));
        assert_eq!(networks_in(text("LOCALHOST"), None), loopback);
        assert_eq!(networks_in(text("SUBNET"), text("1")), loopback);
        assert!(networks_in(text("OFF"), None).is_err());
    }
}
