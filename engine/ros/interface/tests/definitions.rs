//! The text of definitions.

use std::fs;
use std::path::PathBuf;

use asmotion_ros_interface::{
    Catalogue, DefinitionProblem, Distribution, FolderError, Interface, InterfaceName,
};

fn name(text: &str) -> InterfaceName {
    text.parse().unwrap()
}

/// The canonical text of a definition, or its error.
fn read(distribution: Distribution, interface: &str, text: &str) -> Result<String, String> {
    let mut catalogue = Catalogue::empty(distribution);
    let name = name(interface);
    catalogue
        .define(name.clone(), text)
        .map_err(|error| error.to_string())?;
    Ok(catalogue.interface(&name).unwrap().to_string())
}

#[test]
fn comments_blanks_and_packages_do_not_matter() {
    let text = "# a comment\n\n  Header   header # of the sender\nPoint[]\tpoints\r\nuint8 RED = 1  # colour\n";
    assert_eq!(
        read(Distribution::Ros1, "p/M", text).unwrap(),
        "uint8 RED=1\nstd_msgs/Header header\np/Point[] points\n"
    );
    assert_eq!(
        read(Distribution::Ros2, "p/M", text).unwrap(),
        "uint8 RED=1\np/Header header\np/Point[] points\n"
    );
}

#[test]
fn a_string_constant_of_ros_1_ends_with_its_line() {
    let text = "string HASH=  a # b \n";
    assert_eq!(
        read(Distribution::Ros1, "p/M", text).unwrap(),
        "string HASH=a # b\n"
    );
    let text =
        "string HASH='a # b' # comment\nstring name \"x # y\"\nint32[3] three [1, 2, 3] # c\n";
    assert_eq!(
        read(Distribution::Ros2, "p/M", text).unwrap(),
        "string HASH='a # b'\nstring name \"x # y\"\nint32[3] three [1, 2, 3]\n"
    );
}

#[test]
fn bounds_are_kept() {
    let text = "string<=10 a\nint32[<=5] b\nwstring<=3[<=2] c\nfloat64[36] d\n";
    assert_eq!(read(Distribution::Ros2, "p/M", text).unwrap(), text);
}

#[test]
fn faults_have_their_line_and_cause() {
    let table = [
        (
            Distribution::Ros1,
            "p/M",
            "float64\n",
            "p/msg/M, line 1: `float64` is neither a field, such as `float64 x`, nor a constant, such as `uint8 RED=1`",
        ),
        (
            Distribution::Ros1,
            "p/M",
            "\nfloat64 x y\n",
            "p/msg/M, line 2: `float64 x y` is neither a field, such as `float64 x`, nor a constant, such as `uint8 RED=1`",
        ),
        (
            Distribution::Ros1,
            "p/M",
            "float64 x\nint8 x\n",
            "p/msg/M, line 2: `x` is declared twice",
        ),
        (
            Distribution::Ros1,
            "p/M",
            "float64 9x\n",
            "p/msg/M, line 1: `9x` is not a name: letters, digits and underscores, and first a letter",
        ),
        (
            Distribution::Ros1,
            "p/M",
            "float64[-1] x\n",
            "p/msg/M, line 1: `float64[-1]` is not a type",
        ),
        (
            Distribution::Ros1,
            "p/M",
            "a/b/c/d x\n",
            "p/msg/M, line 1: `a/b/c/d` is not a type",
        ),
        (
            Distribution::Ros1,
            "p/M",
            "string<=5 x\n",
            "p/msg/M, line 1: `string<=5` is not a type of this generation of ROS",
        ),
        (
            Distribution::Ros2,
            "p/M",
            "time x\n",
            "p/msg/M, line 1: `time` is not a type of this generation of ROS",
        ),
        (
            Distribution::Ros2,
            "p/M",
            "Point X=1\n",
            "p/msg/M, line 1: a constant cannot have the type `p/Point`",
        ),
        (
            Distribution::Ros2,
            "p/srv/S",
            "int8 x\n",
            "p/srv/S: 1 parts, separated by `---`; 2 are needed",
        ),
        (
            Distribution::Ros2,
            "p/action/A",
            "---\n---\n---\n",
            "p/action/A: 4 parts, separated by `---`; 3 are needed",
        ),
    ];
    for (distribution, interface, text, message) in table {
        assert_eq!(read(distribution, interface, text).unwrap_err(), message);
    }
}

#[test]
fn names_are_checked() {
    for wrong in [
        "",
        "Twist",
        "a/b/c",
        "a/msg/",
        "/msg/T",
        "a/srv/T/x",
        "a b/T",
    ] {
        assert!(wrong.parse::<InterfaceName>().is_err(), "{wrong}");
    }
    assert_eq!(name("nav_msgs/srv/GetMap").short(), "nav_msgs/GetMap");
}

#[test]
fn missing_and_recursive_messages_are_found() {
    let mut catalogue = Catalogue::empty(Distribution::Ros1);
    catalogue.define(name("p/A"), "B b\n").unwrap();
    let problem = |catalogue: &Catalogue, of: &str| catalogue.md5(&name(of)).unwrap_err().problem;
    assert_eq!(
        problem(&catalogue, "p/A"),
        DefinitionProblem::UndefinedField(name("p/B"))
    );
    assert_eq!(problem(&catalogue, "p/C"), DefinitionProblem::Undefined);
    catalogue.define(name("p/B"), "A[] a\n").unwrap();
    assert_eq!(
        problem(&catalogue, "p/A"),
        DefinitionProblem::Recursive(name("p/A"))
    );
    let error = catalogue.schema(&name("p/B")).unwrap_err();
    assert_eq!(error.to_string(), "p/msg/A: `p/msg/B` contains itself");
}

#[test]
fn included_definitions_are_in_canonical_form() {
    for (distribution, text) in [
        (
            Distribution::Ros1,
            include_str!("../definitions/noetic.txt"),
        ),
        (Distribution::Ros2, include_str!("../definitions/jazzy.txt")),
    ] {
        let catalogue = Catalogue::included(distribution);
        let printed: Vec<String> = catalogue
            .interfaces()
            .map(|(name, interface)| format!("=== {name}\n{interface}"))
            .collect();
        assert_eq!(printed.concat(), text);
    }
}

/// A folder that is removed with the value.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str, files: &[(&str, &str)]) -> Self {
        let folder = std::env::temp_dir().join(format!("asmotion-{}-{name}", std::process::id()));
        for (path, text) in files {
            let path = folder.join(path);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        }
        fs::create_dir_all(&folder).unwrap();
        Self(folder)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

#[test]
fn a_folder_adds_its_packages() {
    let files = [
        ("share/arm_msgs/msg/Joint.msg", "float64 angle # rad\n"),
        ("share/arm_msgs/srv/Home.srv", "---\nbool done\n"),
        (
            "share/arm_msgs/action/Move.action",
            "Joint[] to\n---\n---\nfloat32 done\n",
        ),
        ("share/arm_msgs/msg/notes.txt", "not a definition"),
        ("share/geometry_msgs/msg/Point.msg", "float32 x\n"),
    ];
    let folder = Folder::new("packages", &files);
    let mut catalogue = Catalogue::included(Distribution::Ros2);
    assert_eq!(catalogue.add_folder(&folder.0).unwrap(), 4);
    let action = catalogue.interface(&name("arm_msgs/action/Move")).unwrap();
    assert!(matches!(action, Interface::Action { .. }));
    // a definition of the folder replaces the included one
    let point = catalogue.interface(&name("geometry_msgs/Point")).unwrap();
    assert_eq!(point.to_string(), "float32 x\n");
}

#[test]
fn a_folder_with_nothing_or_a_fault_is_refused() {
    let mut catalogue = Catalogue::empty(Distribution::Ros1);
    let empty = Folder::new("empty", &[]);
    let error = catalogue.add_folder(&empty.0).unwrap_err();
    assert!(matches!(error, FolderError::Empty(_)), "{error}");
    let missing = catalogue.add_folder(&empty.0.join("missing")).unwrap_err();
    assert!(matches!(missing, FolderError::Read { .. }), "{missing}");
    let wrong = Folder::new("wrong", &[("p/msg/M.msg", "float64\n")]);
    let error = catalogue.add_folder(&wrong.0).unwrap_err().to_string();
    assert!(error.contains("p/msg/M.msg: p/msg/M, line 1: "), "{error}");
    let large = Folder::new("large", &[("p/msg/M.msg", &" ".repeat(2 << 20))]);
    let error = catalogue.add_folder(&large.0).unwrap_err();
    assert!(matches!(error, FolderError::TooLarge { .. }), "{error}");
}
