//! MD5 sums and type hashes, against those that other implementations have computed.

use asmotion_ros_interface::{Catalogue, Distribution, InterfaceName};

/// Entries of a file of `tests/data`: the name of an interface, and its sum or hash.
fn entries(text: &'static str) -> impl Iterator<Item = (InterfaceName, &'static str)> {
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    lines.map(|line| {
        let (name, sum) = line.split_once(' ').unwrap();
        (name.parse().unwrap(), sum)
    })
}

#[test]
fn r7_md5_sums_are_those_of_genmsg() {
    let noetic = Catalogue::included(Distribution::Ros1);
    let mut count = 0;
    for (name, sum) in entries(include_str!("data/md5.txt")) {
        assert_eq!(noetic.md5(&name).unwrap().to_string(), sum, "{name}");
        count += 1;
    }
    assert!(count > 150, "{count}");
}

#[test]
fn type_hashes_of_messages_are_those_of_rosbags() {
    let jazzy = Catalogue::included(Distribution::Ros2);
    let mut unknown = Vec::new();
    let mut count = 0;
    for (name, hash) in entries(include_str!("data/type_hashes.txt")) {
        if jazzy.interface(&name).is_err() {
            unknown.push(name.to_string());
            continue;
        }
        assert_eq!(jazzy.type_hash(&name).unwrap().to_string(), hash, "{name}");
        count += 1;
    }
    assert!(count > 120, "{count}, not included: {unknown:?}");
}

#[test]
fn type_hashes_of_services_and_actions_are_those_of_rosidl() {
    let mut jazzy = Catalogue::included(Distribution::Ros2);
    let hash = |catalogue: &Catalogue, name: &str| {
        let name: InterfaceName = name.parse().unwrap();
        catalogue.type_hash(&name).unwrap().to_string()
    };
    assert_eq!(
        hash(&jazzy, "example_interfaces/srv/AddTwoInts"),
        "RIHS01_e118de6bf5eeb66a2491b5bda11202e7b68f198d6f67922cf30364858239c81a"
    );
    // a package of a course, whose generated code is public
    let fibonacci = "rob599_msgs/action/Fibonacci";
    let text = "int64 number\n---\nint64[] sequence\n---\nint64 progress\n";
    jazzy.define(fibonacci.parse().unwrap(), text).unwrap();
    assert_eq!(
        hash(&jazzy, fibonacci),
        "RIHS01_00bf40d6e8121f2f6fa89a9f8b78e28efc8c958cfc656f9cd7f51f223224e2a3"
    );
}

#[test]
fn every_included_interface_has_a_sum_or_a_hash_and_schemas() {
    for distribution in [Distribution::Ros1, Distribution::Ros2] {
        let catalogue = Catalogue::included(distribution);
        for (name, interface) in catalogue.interfaces() {
            let parts = interface.structures().len();
            assert_eq!(catalogue.schemas(name).unwrap().len(), parts, "{name}");
            match distribution {
                Distribution::Ros1 => drop(catalogue.md5(name).unwrap()),
                Distribution::Ros2 => drop(catalogue.type_hash(name).unwrap()),
            }
        }
    }
}
