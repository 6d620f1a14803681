//! Names of ROS 2, and the names of topics and types that DDS sees.
//!
//! Source: design.ros2.org, "Topic and Service name mapping to DDS". A topic `/scan` of `sensor_msgs/msg/LaserScan` is the topic
//! `rt/scan` of the type `sensor_msgs::msg::dds_::LaserScan_`.

use asmotion_ros_interface::InterfaceName;

/// A text is not a name of ROS 2.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{text}` is not a name: {reason}")]
pub struct NameError {
    /// The text.
    pub text: String,
    /// What is wrong with it.
    pub reason: &'static str,
}

/// Longest name of a topic in DDS.
const LONGEST: usize = 255;
/// What the names of topics begin with in DDS.
pub(crate) const TOPIC: &str = "rt";
/// The topic of DDS on which participants publish their nodes; it has no prefix.
pub(crate) const GRAPH: &str = "ros_discovery_info";

/// The name of a message type in DDS.
pub(crate) fn message_type(of: &InterfaceName) -> String {
    part_type(of, "")
}

/// The name of a part of a service or action in DDS, such as `Request`.
pub(crate) fn part_type(of: &InterfaceName, part: &str) -> String {
    let separator = if part.is_empty() { "" } else { "_" };
    let (package, folder, name) = (of.package(), of.kind().folder(), of.name());
    format!("{package}::{folder}::dds_::{name}{separator}{part}_")
}

/// The topic of DDS for a topic of ROS, which is absolute.
pub(crate) fn topic(name: &str) -> String {
    format!("{TOPIC}{name}")
}

/// The topics of DDS for requests and replies of a service, whose name is absolute.
pub(crate) fn service(name: &str) -> (String, String) {
    (format!("rq{name}Request"), format!("rr{name}Reply"))
}

/// The name and type of ROS for a topic and type of DDS; `None` if they are not of ROS.
pub(crate) fn of_dds(topic: &str, of: &str) -> Option<(String, String)> {
    let (name, of) = match topic.split_at_checked(2)? {
        ("rt", name) => (name, of.to_owned()),
        ("rq", name) => (
            name.strip_suffix("Request")?,
            without_part(of, "_Request_")?,
        ),
        ("rr", name) => (name.strip_suffix("Reply")?, without_part(of, "_Response_")?),
        _ => return None,
    };
    let ros = name.starts_with('/') && of.ends_with('_');
    let plain = of.strip_suffix('_').unwrap_or(&of);
    ros.then(|| {
        (
            name.to_owned(),
            plain.replace("::dds_::", "::").replace("::", "/"),
        )
    })
}

fn without_part(of: &str, part: &str) -> Option<String> {
    of.strip_suffix(part).map(|plain| format!("{plain}_"))
}

/// Makes a name absolute: a relative one is in the namespace of the node, and `~/x` in that of its name.
pub(crate) fn absolute(name: &str, namespace: &str, node: &str) -> Result<String, NameError> {
    let base = namespace.trim_end_matches('/');
    let full = match name.strip_prefix('~') {
        Some(private) => format!("{base}/{node}{private}"),
        None if name.starts_with('/') => name.to_owned(),
        None => format!("{base}/{name}"),
    };
    let error = |reason| NameError {
        text: name.to_owned(),
        reason,
    };
    if full.len() > LONGEST - "rq".len() - "Request".len() {
        return Err(error("it is longer than DDS permits"));
    }
    for token in full.split('/').skip(1) {
        token_of(token).map_err(error)?;
    }
    Ok(full)
}

/// Checks the name of a node.
pub(crate) fn node(name: &str) -> Result<(), NameError> {
    token_of(name).map_err(|reason| NameError {
        text: name.to_owned(),
        reason,
    })
}

/// Makes a namespace absolute, without a slash at its end unless it is the root.
pub(crate) fn namespace(name: &str) -> Result<String, NameError> {
    if name.is_empty() || name == "/" {
        return Ok("/".to_owned());
    }
    absolute(name, "/", "")
}

fn token_of(token: &str) -> Result<(), &'static str> {
    let is_sign = |sign: char| sign.is_ascii_alphanumeric() || sign == '_';
    if token.is_empty() {
        return Err("a part between slashes is empty");
    }
    if token.starts_with(|first: char| first.is_ascii_digit()) {
        return Err("a part starts with a digit");
    }
    if !token.chars().all(is_sign) {
        return Err("it has signs that are neither letters, digits, underscores nor slashes");
    }
    if token.contains("__") {
        return Err("two underscores follow each other");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_rmw() {
        let twist = "geometry_msgs/msg/Twist".parse().unwrap();
        assert_eq!(message_type(&twist), "geometry_msgs::msg::dds_::Twist_");
        let add = "example_interfaces/srv/AddTwoInts".parse().unwrap();
        let request = "example_interfaces::srv::dds_::AddTwoInts_Request_";
        assert_eq!(part_type(&add, "Request"), request);
        let (requests, replies) = service("/add");
        assert_eq!((&*requests, &*replies), ("rq/addRequest", "rr/addReply"));
        let back = of_dds("rq/addRequest", request).unwrap();
        assert_eq!(back.0, "/add");
        assert_eq!(back.1, "example_interfaces/srv/AddTwoInts");
        let back = of_dds("rt/a/b", "geometry_msgs::msg::dds_::Twist_").unwrap();
        assert_eq!(back, ("/a/b".into(), "geometry_msgs/msg/Twist".into()));
        assert_eq!(of_dds("ros_discovery_info", "x"), None);
        assert_eq!(of_dds("é", "x"), None);
    }

    #[test]
    fn names_become_absolute() {
        let full = |name| absolute(name, "/robot", "nav");
        assert_eq!(full("scan").unwrap(), "/robot/scan");
        assert_eq!(full("/scan").unwrap(), "/scan");
        assert_eq!(full("~/path").unwrap(), "/robot/nav/path");
        assert_eq!(absolute("scan", "/", "nav").unwrap(), "/scan");
        assert_eq!(namespace("robot").unwrap(), "/robot");
        assert_eq!(namespace("").unwrap(), "/");
        for wrong in ["", "/", "a//b", "a b", "/1a", "a__b", "é", "/a/"] {
            assert!(full(wrong).is_err(), "{wrong}");
        }
        assert!(full(&"a".repeat(300)).is_err());
    }
}
