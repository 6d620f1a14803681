//! Writes the definitions that the crate includes.

use std::fmt::Write as _;
use std::path::Path;

use asmotion_ros_interface::{Catalogue, Distribution};

/// Writes `definitions/noetic.txt` and `jazzy.txt` from the folders in `ROS1_PACKAGES` and `ROS2_PACKAGES`, which are
/// separated by colons.
#[test]
#[ignore = "writes files of the repository"]
fn writes_the_definitions_of_the_crate() {
    for (distribution, variable, file) in [
        (Distribution::Ros1, "ROS1_PACKAGES", "noetic.txt"),
        (Distribution::Ros2, "ROS2_PACKAGES", "jazzy.txt"),
    ] {
        let folders = std::env::var(variable).unwrap();
        let mut catalogue = Catalogue::empty(distribution);
        for folder in folders.split(':') {
            catalogue.add_folder(Path::new(folder)).unwrap();
        }
        let mut text = String::new();
        for (name, interface) in catalogue.interfaces() {
            write!(text, "=== {name}\n{interface}").unwrap();
        }
        let path = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("definitions")
            .join(file);
        std::fs::write(path, text).unwrap();
    }
}
