//! The definitions that are part of this crate.
//!
//! A file has all definitions of a distribution: a line `=== NAME` before each, then its lines, without comments. The files
//! are made from the packages of the distributions, by `cargo test -p asmotion-ros-interface -- --ignored writes`
//! ([README](../README.md)).

use std::sync::LazyLock;

use crate::catalogue::Catalogue;
use crate::distribution::Distribution;

/// The line before a definition.
pub(crate) const HEADING: &str = "=== ";

static ROS1: LazyLock<Catalogue> = LazyLock::new(|| {
    read(
        Distribution::Ros1,
        include_str!("../definitions/noetic.txt"),
    )
});
static ROS2: LazyLock<Catalogue> =
    LazyLock::new(|| read(Distribution::Ros2, include_str!("../definitions/jazzy.txt")));

impl Catalogue {
    /// The definitions that are part of this crate: those of the standard packages, and for ROS 2 of Nav2.
    pub fn included(distribution: Distribution) -> Self {
        match distribution {
            Distribution::Ros1 => ROS1.clone(),
            Distribution::Ros2 => ROS2.clone(),
        }
    }
}

/// Reads a file of this crate. A test reads each definition, so none is passed over.
fn read(distribution: Distribution, text: &str) -> Catalogue {
    let mut catalogue = Catalogue::empty(distribution);
    for entry in text.split(HEADING) {
        let Some((name, definition)) = entry.split_once('\n') else {
            continue;
        };
        if let Ok(name) = name.parse() {
            catalogue.define(name, definition).unwrap_or_default();
        }
    }
    catalogue
}
