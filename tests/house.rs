//! The architecture: which crate may depend on which. Dependencies point downwards only.

use cargo_metadata::{DependencyKind, Metadata, MetadataCommand};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;
use xtask::checkout::Checkout;
use xtask::type_names::{self, NameReuse};
use xtask::{module_laws, modules, printing};

/// The crates by layer, lowest first; a crate depends only on lower layers.
const FLOORS: &[&[&str]] = &[
    // macros, and what tests need
    &[
        "asmotion-derive",
        "asmotion-diagnostics-derive",
        "asmotion-skip",
    ],
    // the ground floor
    &["asmotion-diagnostics"],
    // the language
    &["asmotion-value", "asmotion-temporal"],
    &["asmotion-syntax", "asmotion-stdlib"],
    &["asmotion-hir", "asmotion-grammar"],
    &["asmotion-ir"],
    &["asmotion-machine", "asmotion-ground"],
    &["asmotion-simulate", "asmotion-native"],
    &["asmotion-lang"],
    &["asmotion-properties", "asmotion-symbolic"],
    &["asmotion-verify"],
    // the engine
    &["asmotion-datum", "asmotion-connection", "asmotion-broker"],
    &[
        "asmotion-bus",
        "asmotion-ros-interface",
        "asmotion-transform",
    ],
    &[
        "asmotion-amqp",
        "asmotion-http",
        "asmotion-port",
        "asmotion-ros-domain",
        "asmotion-ros1",
        "asmotion-ros2",
    ],
    &[
        "asmotion-component",
        "asmotion-gateway",
        "asmotion-ros-master",
        "asmotion-viewer-encoding",
    ],
    &[
        "asmotion-bridge",
        "asmotion-coordinator",
        "asmotion-program",
        "asmotion-runtime",
    ],
    &[
        "asmotion-network",
        "asmotion-mqueue",
        "asmotion-recording",
        "asmotion-ros-gateway",
    ],
    &["asmotion-bench"],
    &["asmotion-composite"],
    &["asmotion-plan", "asmotion-scdl"],
    &[
        "asmotion-assembly",
        "asmotion-drawing",
        "asmotion-remote",
        "asmotion-verification",
    ],
    &["asmotion-monitor"],
    // the robot
    &["asmotion-messages"],
    &["asmotion-geometry"],
    &[COMPONENTS],
    &["asmotion-world"],
    &["asmotion-components"],
    // missions, for people
    &["asmotion-story"],
    // the front door
    &["asmotion"],
    // tests of all wings, and maintenance tasks
    &["asmotion-robustness", "asmotion-wire-robustness", "xtask"],
];

/// Stands for every crate of `components/` that is not listed, so that a new component needs no row.
const COMPONENTS: &str = "components/*";

fn floor(package: &str) -> Option<usize> {
    let named = |name: &str| FLOORS.iter().position(|rooms| rooms.contains(&name));
    let unnamed = || named(COMPONENTS).filter(|_| wing(package) == "components");
    named(package).or_else(unnamed)
}

/// The packages of the workspace.
fn workspace() -> &'static Metadata {
    static WORKSPACE: LazyLock<Metadata> = LazyLock::new(|| {
        let mut command = MetadataCommand::new();
        command.no_deps().exec().expect("cargo metadata")
    });
    &WORKSPACE
}

/// The top-level folder of a crate: `asm-lang`, `engine`, `components`, `story`.
fn wing(package: &str) -> String {
    let metadata = workspace();
    let found = metadata.packages.iter().find(|it| it.name == package);
    let manifest = &found.expect("a crate of the workspace").manifest_path;
    let inside = manifest
        .strip_prefix(&metadata.workspace_root)
        .expect("inside the workspace");
    let first = inside.components().next().expect("a path");
    first.to_string()
}

/// The dependencies between our crates, without development dependencies.
fn arrows() -> Vec<(String, String)> {
    let metadata = workspace();
    let mut arrows = Vec::new();
    for package in &metadata.packages {
        for dependency in &package.dependencies {
            if dependency.path.is_some() && dependency.kind == DependencyKind::Normal {
                arrows.push((package.name.to_string(), dependency.name.clone()));
            }
        }
    }
    arrows
}

#[test]
fn every_crate_has_its_floor() {
    let metadata = workspace();
    for package in &metadata.packages {
        assert!(
            floor(&package.name).is_some(),
            "{} stands on no floor: add it to FLOORS",
            package.name
        );
    }
}

#[test]
fn no_arrow_climbs() {
    for (from, to) in arrows() {
        assert!(
            floor(&from) > floor(&to),
            "{from} uses {to}, which is not below it"
        );
    }
}

#[test]
fn components_know_the_cycle_and_the_data_alone() {
    let arrows = arrows();
    for (from, to) in arrows.iter().filter(|(from, _)| wing(from) == "components") {
        let below = ["asmotion-component", "asmotion-datum", "asmotion-derive"];
        let allowed = wing(to) == "components" || below.contains(&to.as_str());
        assert!(allowed, "{from} uses {to}");
    }
}

#[test]
fn the_engine_knows_no_robot_and_the_language_knows_no_engine() {
    for (from, to) in arrows() {
        let engine_knows_robot = wing(&from) == "engine" && wing(&to) == "components";
        let ground = ["asm-lang", "diagnostics"];
        let language_looks_up = wing(&from) == "asm-lang" && !ground.contains(&wing(&to).as_str());
        assert!(
            !engine_knows_robot && !language_looks_up,
            "{from} uses {to}"
        );
    }
}

/// All crates that a crate is built from, according to `cargo tree`.
fn built_from(package: &str) -> BTreeSet<String> {
    let tree = Command::new(env!("CARGO"))
        .args(["tree", "-e", "normal", "--prefix", "none", "--offline"])
        .args(["--locked", "-p", package])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("cargo tree");
    let text = String::from_utf8(tree.stdout).expect("text");
    let names = text.lines().filter_map(|line| line.split(' ').next());
    names.map(str::to_owned).collect()
}

#[test]
fn a_component_is_built_without_runtime_and_bus() {
    let used = built_from("asmotion-component");
    let ours: BTreeSet<&str> = used
        .iter()
        .map(String::as_str)
        .filter(|name| name.starts_with("asmotion-"))
        .collect();
    let below = [
        "asmotion-component",
        "asmotion-connection",
        "asmotion-datum",
        "asmotion-derive",
        "asmotion-port",
    ];
    assert_eq!(ours, BTreeSet::from(below));
}

#[test]
fn j5_the_core_is_built_without_any_transport() {
    // prefixes of words in the names of crates
    const TRANSPORTS: [&str; 8] = [
        "amqp", "lapin", "rabbit", "ros", "rcl", "corba", "tokio", "hyper",
    ];
    let is_transport = |name: &str| {
        let mut words = name.split(['-', '_']);
        words.any(|word| {
            TRANSPORTS
                .iter()
                .any(|transport| word.starts_with(transport))
        })
    };
    for core in [
        "asmotion-bus",
        "asmotion-component",
        "asmotion-runtime",
        "asmotion-network",
        "asmotion-coordinator",
        "asmotion-bridge",
        "asmotion-composite",
        "asmotion-plan",
        "asmotion-assembly",
        "asmotion-components",
    ] {
        let used = built_from(core);
        assert!(used.contains("asmotion-datum"), "{core}: {used:?}");
        let found: Vec<_> = used.iter().filter(|name| is_transport(name)).collect();
        assert!(found.is_empty(), "{core} is built from {found:?}");
    }
    let amqp = built_from("asmotion-amqp");
    assert!(amqp.iter().any(|name| is_transport(name)), "{amqp:?}");
}

/// A new back end is a new crate beside `asmotion-amqp`: only the crates that assemble systems name it, no lower one.
#[test]
fn j6_back_ends_are_named_only_where_systems_are_joined_and_pass_one_suite() {
    let arrows = arrows();
    let knowing = arrows.iter().filter(|(_, to)| to == "asmotion-amqp");
    let knowing: BTreeSet<&str> = knowing.map(|(from, _)| &**from).collect();
    assert_eq!(knowing, BTreeSet::from(["asmotion", "asmotion-remote"]));
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let checkout = Checkout::working_tree(root).expect("the sources");
    // every bus, and the file with the test that it passes the contract suite
    let suites = BTreeMap::from([
        ("AmqpBus", "engine/bus/amqp/tests/rabbitmq/contract.rs"),
        ("LocalBus", "engine/bus/tests/local.rs"),
    ]);
    let sources = checkout
        .files
        .iter()
        .filter(|it| !it.path.contains("/tests/"));
    let buses: BTreeSet<&str> = sources
        .flat_map(|it| it.text.lines())
        .filter_map(|line| line.strip_prefix("impl Bus for "))
        .map(|name| name.trim_end_matches([' ', '{']))
        .collect();
    assert_eq!(buses, suites.keys().copied().collect());
    for (bus, suite) in suites {
        let file = checkout.files.iter().find(|it| it.path == suite);
        let tests = file.expect(suite).text.split("#[test]");
        let mut tests = tests.filter(|test| test.trim_start().starts_with("fn t29_"));
        assert!(
            tests.any(|test| test.contains("contract::violations(")),
            "{bus} does not pass the suite in {suite}"
        );
    }
}

/// Modules of a crate import names from their defining modules, without cycles of first-level modules or large cycles
/// of files.
#[test]
fn modules_keep_the_laws_of_the_house() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let crates = modules::of(&Checkout::working_tree(root).expect("the sources"));
    assert!(crates.len() > FLOORS.len());
    let found = module_laws::breaches(&crates);
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn type_names_have_one_meaning() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let checkout = Checkout::working_tree(root).expect("the sources");
    let reuse = NameReuse::of(&type_names::definitions(&checkout));
    let percent = reuse.percent();
    assert!(
        percent < 8.0,
        "{percent:.1} % are reused: `cargo xtask names` lists them"
    );
}

#[test]
fn crates_are_used_by_their_own_names() {
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml");
    let text = std::fs::read_to_string(manifest).expect("Cargo.toml");
    let manifest: toml::Table = toml::from_str(&text).expect("TOML");
    let dependencies = manifest["workspace"]["dependencies"]
        .as_table()
        .expect("a table");
    assert!(dependencies.contains_key("asmotion-datum"));
    for (name, dependency) in dependencies {
        let renamed = dependency.get("package");
        assert!(renamed.is_none(), "{name} is renamed: {renamed:?}");
    }
}

/// A row of the glossary may end with a type: `| term | meaning | `Type` |`.
#[test]
fn terms_of_the_glossary_are_types_with_one_meaning() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(root.join("docs/glossary.md")).expect("the glossary");
    let rows = text.lines().filter_map(|line| line.strip_suffix("` |"));
    let names: Vec<&str> = rows
        .filter_map(|row| Some(row.rsplit_once("| `")?.1))
        .collect();
    assert!(names.len() > 20, "{names:?}");
    let checkout = Checkout::working_tree(root).expect("the sources");
    let definitions = type_names::definitions(&checkout);
    for name in names {
        let places = definitions.get(name).map_or(&[][..], Vec::as_slice);
        assert_eq!(places.len(), 1, "`{name}` is defined in {places:?}");
    }
}

#[test]
fn only_the_front_door_prints() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let checkout = Checkout::working_tree(root).expect("the sources");
    assert!(printing::calls(&checkout, &[]).len() > 1);
    let elsewhere = printing::calls(&checkout, &["src/", "xtask/src/main.rs"]);
    assert!(elsewhere.is_empty(), "{elsewhere:?}");
}

/// Prefixes of the requirements (research notes of the project), with their highest number: tasks, ROS, navigation, composition,
/// Orocos, JOrocos, youBot.
const REQUIREMENTS: [(char, u32); 7] = [
    ('t', 29),
    ('r', 12),
    ('n', 12),
    ('c', 21),
    ('o', 17),
    ('j', 22),
    ('y', 12),
];

#[test]
fn every_requirement_has_a_test_of_its_name() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let checkout = Checkout::working_tree(root).expect("the sources");
    let texts = checkout.files.iter().map(|file| &file.text);
    let tests = texts.flat_map(|text| text.split("#[test]").skip(1));
    let names = tests.filter_map(|test| test.split_once("fn ")?.1.split_once('('));
    // a test can begin with several requirements: `n7_n12_two_clients`
    let is_requirement = |word: &&str| {
        let prefix = word.chars().next().unwrap_or_default();
        let number = word.get(1..).unwrap_or_default();
        let known = REQUIREMENTS.iter().any(|(known, _)| *known == prefix);
        known && !number.is_empty() && number.bytes().all(|it| it.is_ascii_digit())
    };
    let tested: BTreeSet<&str> = names
        .flat_map(|(name, _)| name.split('_').take_while(is_requirement))
        .collect();
    let all = REQUIREMENTS
        .iter()
        .flat_map(|(prefix, last)| (1..=*last).map(move |number| format!("{prefix}{number}")));
    for requirement in all {
        assert!(tested.contains(&*requirement), "no test of `{requirement}`");
    }
}

/// Paths of the files of the modules that a file declares.
fn declared_modules(path: &Path, text: &str) -> Vec<PathBuf> {
    let folder = path.parent().expect("a folder");
    let is_folder = path
        .file_stem()
        .is_some_and(|it| it == "mod" || it == "main");
    let (mut files, mut written) = (Vec::new(), None);
    for line in text.lines().map(str::trim) {
        if let Some(quoted) = line.strip_prefix("#[path = \"") {
            written = quoted.split_once('"').map(|(path, _)| folder.join(path));
            continue;
        }
        let words: Vec<&str> = line.split([' ', ';']).collect();
        let of_module = words.iter().position(|it| *it == "mod");
        let name = of_module.and_then(|at| words.get(at + 1));
        if let (Some(name), true) = (name, line.ends_with(';') && !line.starts_with("//")) {
            let below = folder.join(path.file_stem().expect("a name"));
            let inside = if is_folder { folder } else { &below };
            files.extend(written.take());
            files.extend([folder, inside].map(|it| it.join(format!("{name}.rs"))));
            files.extend([folder, inside].map(|it| it.join(name).join("mod.rs")));
        }
    }
    files
}

/// A test target costs a compilation and a link, or a run of `rustdoc`, even if it contains no test: the manifest turns it off then.
#[test]
fn test_targets_are_built_exactly_where_there_are_tests() {
    const MARKS: [&str; 3] = ["#[test]", "#[cfg(test)]", "proptest!"];
    let checkout =
        Checkout::working_tree(Path::new(env!("CARGO_MANIFEST_DIR"))).expect("the sources");
    let is_fence = |line: &str| {
        let comment = line.trim_start();
        let text = ["//!", "///"]
            .iter()
            .find_map(|mark| comment.strip_prefix(mark));
        text.is_some_and(|text| text.trim_start().starts_with("```"))
    };
    let mut wrong = Vec::new();
    for package in &workspace().packages {
        let targets = package.targets.iter();
        let mains: Vec<_> = targets
            .clone()
            .filter(|it| it.is_bin())
            .map(|it| &it.src_path)
            .collect();
        for target in targets.filter(|it| it.is_lib() || it.is_proc_macro() || it.is_bin()) {
            let sources = package.manifest_path.with_file_name("src");
            let texts = checkout.files.iter().filter(|file| {
                let path = checkout.root.join(&file.path);
                let of_bin = mains.iter().any(|it| **it == path);
                path.starts_with(&sources)
                    && if target.is_bin() {
                        target.src_path == path
                    } else {
                        !of_bin
                    }
            });
            let texts: Vec<&str> = texts.map(|file| &*file.text).collect();
            let has_tests = texts
                .iter()
                .any(|text| MARKS.iter().any(|mark| text.contains(mark)));
            let has_examples =
                !target.is_bin() && texts.iter().any(|text| text.lines().any(is_fence));
            for (key, is, wanted) in [
                ("test", target.test, has_tests),
                ("doctest", target.doctest, has_examples),
            ] {
                if is != wanted {
                    wrong.push(format!(
                        "{}: `{key} = {wanted}` for `{}`",
                        package.manifest_path, target.name
                    ));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// A file that no test target reaches is not compiled, so its tests run nowhere.
#[test]
fn every_file_of_tests_is_part_of_a_test_target() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let checkout = Checkout::working_tree(root).expect("the sources");
    let texts: BTreeMap<PathBuf, &str> = checkout
        .files
        .iter()
        .map(|file| (root.join(&file.path), &*file.text))
        .collect();
    let packages = workspace().packages.iter();
    let targets = packages.clone().flat_map(|package| &package.targets);
    let mut open: Vec<PathBuf> = targets.map(|it| it.src_path.clone().into()).collect();
    let mut reached = BTreeSet::new();
    while let Some(path) = open.pop() {
        let Ok(path) = path.canonicalize() else {
            continue;
        };
        if let (Some(text), true) = (texts.get(&path), reached.insert(path.clone())) {
            open.extend(declared_modules(&path, text));
        }
    }
    let folders: Vec<PathBuf> = packages
        .filter_map(|package| Some(package.manifest_path.parent()?.join("tests").into()))
        .collect();
    let of_tests = texts.iter().filter(|(path, text)| {
        text.contains("#[test]") && folders.iter().any(|folder| path.starts_with(folder))
    });
    let lost = of_tests.filter(|(path, _)| !reached.contains(*path));
    let lost: Vec<_> = lost.map(|(path, _)| path).collect();
    assert!(lost.is_empty(), "not compiled: {lost:?}");
}
