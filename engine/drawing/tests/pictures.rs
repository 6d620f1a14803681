//! Pictures of the composites in this repository, which are also part of the documentation.
#![allow(missing_docs, clippy::expect_used, clippy::panic, reason = "tests")]

use std::sync::Arc;

use asmotion_composite::{AsmFiles, Context, EmptyEnvironment, Tables};
use asmotion_diagnostics::{LoadError, Loader};
use asmotion_drawing::Instances;
use asmotion_lang::MemoryFiles;
use asmotion_plan::Opened;

/// Loads files from `specs`, with a word replaced.
struct Specs {
    word: &'static str,
    other: &'static str,
}

impl Loader for Specs {
    fn read(&self, path: &str) -> Result<Arc<str>, LoadError> {
        let text = std::fs::read_to_string(format!("../../specs/{path}"));
        let text = text.map(|text| text.replace(self.word, self.other));
        text.map(Arc::from).map_err(|error| LoadError {
            path: path.to_owned(),
            reason: error.to_string(),
        })
    }

    fn resolve(&self, from: &str, import: &str) -> Option<String> {
        let folder = from.rsplit_once('/').map_or("", |(folder, _)| folder);
        let near = [folder, import].into_iter().filter(|it| !it.is_empty());
        let near = near.collect::<Vec<_>>().join("/");
        let all = [near.clone(), format!("{near}.asm")];
        all.into_iter()
            .find(|it| std::path::Path::new(&format!("../../specs/{it}")).is_file())
    }
}

/// The composites as they are.
const UNCHANGED: Specs = Specs {
    word: "\0",
    other: "",
};

fn open(file: &str, specs: &Specs) -> Opened {
    let context = Context {
        loader: specs,
        environment: &EmptyEnvironment,
        catalogue: &Tables::EMPTY,
        specifications: &AsmFiles::new(specs),
        programs: &asmotion_composite::NoPrograms,
        settings: &[],
    };
    asmotion_plan::open(file, &context)
}

/// Draws a composite in all formats, and checks that drawing it again gives the same.
fn drawn(file: &str) -> [String; 3] {
    drawn_from(file, &UNCHANGED)
}

fn drawn_from(file: &str, specs: &Specs) -> [String; 3] {
    let draw = || {
        let opened = open(file, specs);
        let plan = opened
            .plan(None)
            .unwrap_or_else(|| panic!("{:#?}", opened.report));
        [
            asmotion_drawing::dot(plan, Instances::Folded),
            asmotion_drawing::mermaid(plan, Instances::Folded),
            asmotion_drawing::svg(plan, Instances::Folded),
        ]
    };
    let once = draw();
    assert_eq!(once, draw());
    once
}

#[test]
fn c15_a_picture_is_equal_after_reloading_the_file() {
    for file in [
        "navigation/navigation.composite.toml",
        "courier/courier.composite.toml",
        "youbot/youbot.composite.toml",
    ] {
        drawn(file);
    }
}

#[test]
fn c15_every_format_shows_the_components_of_the_file() {
    let file = "navigation/navigation.composite.toml";
    let opened = open(file, &UNCHANGED);
    let plan = opened.plan(None).expect("a plan");
    assert_eq!(plan.components.len(), 10);
    for picture in drawn(file) {
        for component in &plan.components {
            assert!(
                picture.contains(&*component.name),
                "{}: {picture}",
                component.name
            );
        }
    }
}

#[test]
fn n5_the_picture_of_the_navigation_names_its_topics() {
    for picture in drawn("navigation/navigation.composite.toml") {
        for topic in ["goal", "cancel", "estop", "event", "plan", "permit", "odom"] {
            assert!(picture.contains(topic), "{topic}: {picture}");
        }
    }
}

#[test]
fn c15_a_picture_follows_a_change_of_the_file() {
    let file = "courier/courier.composite.toml";
    let before = drawn(file);
    let renamed = drawn_from(
        file,
        &Specs {
            word: "Dispatcher",
            other: "Headquarters",
        },
    );
    let unwired = drawn_from(
        file,
        &Specs {
            word: "timeout_ms = 500",
            other: "timeout_ms = 400",
        },
    );
    for (before, after) in before.iter().zip(&renamed) {
        assert!(
            before.contains("Dispatcher") && !before.contains("Headquarters"),
            "{before}"
        );
        assert!(
            after.contains("Headquarters") && !after.contains("Dispatcher"),
            "{after}"
        );
    }
    // what a picture does not show does not change it
    assert_eq!(before, unwired);
}

#[test]
fn it_draws_nested_composites_as_frames() {
    let [dot, mermaid, svg] = drawn("youbot/youbot.composite.toml");
    insta::assert_snapshot!("youbot.dot", dot);
    insta::assert_snapshot!("youbot.mermaid", mermaid);
    assert_eq!(svg.matches(">Driver</text>").count(), 1, "{svg}");
}

/// A composite of the repository, or one of these files, in DOT.
fn dot_of(file: &str, loader: &dyn Loader, instances: Instances) -> String {
    let context = Context {
        loader,
        environment: &EmptyEnvironment,
        catalogue: &Tables::EMPTY,
        specifications: &AsmFiles::new(loader),
        programs: &asmotion_composite::NoPrograms,
        settings: &[],
    };
    let opened = asmotion_plan::open(file, &context);
    let plan = opened.plan(None);
    let plan = plan.unwrap_or_else(|| panic!("{:#?}", opened.report));
    asmotion_drawing::dot(plan, instances)
}

/// A component with a mode and a partner that takes it, in DOT, as often as `instances` says.
fn pairs(more: &str, instances: Instances) -> String {
    let mut files = MemoryFiles::new();
    let source = "asm source\nsignature:\n  out level: Integer\ndefinitions:\n  main rule r_Main = level := 1\n";
    let sink = "asm sink\nsignature:\n  monitored level: Integer\n  controlled last: Integer\ndefinitions:\n  main rule r_Main = last := level\n";
    files.add("source.asm", source);
    files.add("sink.asm", sink);
    files.add(
        "main.toml",
        format!(
            "schema = \"composite/1\"
[composite]
name = \"pairs\"
[components.Source]
for = \"$n in 1..12\"
implementation = {{ asm = \"source.asm\" }}
task = {{ period_ms = 100 }}
publish = {{ level = \"std_msgs/Int64\" }}
rename = {{ level = \"pair$n/level\" }}
bind.out = {{ level = {{ topic = \"level\", field = \"data\" }} }}
[components.Sink]
for = \"$n in 1..12\"
implementation = {{ asm = \"sink.asm\" }}
task = {{ period_ms = 100 }}
subscribe = {{ level = \"std_msgs/Int64\" }}
rename = {{ level = \"pair$n/level\" }}
bind.monitored = {{ level = {{ topic = \"level\", map = \"data\", none = 0 }} }}
{more}"
        ),
    );
    dot_of("main.toml", &files, instances)
}

#[test]
fn instances_are_drawn_as_one() {
    insta::assert_snapshot!("instances.dot", pairs("", Instances::Folded));
    let each = pairs("", Instances::Each);
    assert_eq!(each.matches("shape=record").count(), 24, "{each}");
}

/// A sink that reads another topic as well is drawn by itself, with its source and its topic.
#[test]
fn an_instance_with_a_connection_of_its_own_is_not_folded() {
    let more = "[components.Observer]
implementation = { asm = \"sink.asm\" }
task = { period_ms = 100 }
subscribe = { level = \"std_msgs/Int64\" }
rename = { level = \"pair7/level\" }
bind.monitored = { level = { topic = \"level\", map = \"data\", none = 0 } }
";
    insta::assert_snapshot!("instances_and_another.dot", pairs(more, Instances::Folded));
}

#[test]
fn the_instances_of_a_nested_composite_are_one_frame() {
    insta::assert_snapshot!("fleet.dot", drawn("fleet/fleet.composite.toml")[0]);
}
