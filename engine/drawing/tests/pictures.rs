//! Pictures of the composites in this repository, which are also part of the documentation.
#![allow(missing_docs, clippy::expect_used, clippy::panic, reason = "tests")]

use std::sync::Arc;

use asmotion_composite::{AsmFiles, Context, EmptyEnvironment, Tables};
use asmotion_diagnostics::{LoadError, Loader};
use asmotion_plan::Opened;

/// Loads files from `specs`.
struct Specs;

impl Loader for Specs {
    fn read(&self, path: &str) -> Result<Arc<str>, LoadError> {
        let text = std::fs::read_to_string(format!("../../specs/{path}"));
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

fn open(file: &str) -> Opened {
    let context = Context {
        loader: &Specs,
        environment: &EmptyEnvironment,
        catalogue: &Tables::EMPTY,
        specifications: &AsmFiles::new(&Specs),
        settings: &[],
    };
    asmotion_plan::open(file, &context)
}

/// Draws a composite in all formats, and checks that drawing it again gives the same.
fn drawn(file: &str) -> [String; 3] {
    let draw = || {
        let opened = open(file);
        let plan = opened
            .plan(None)
            .unwrap_or_else(|| panic!("{:#?}", opened.report));
        [
            asmotion_drawing::dot(plan),
            asmotion_drawing::mermaid(plan),
            asmotion_drawing::svg(plan),
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
fn it_draws_nested_composites_as_frames() {
    let [dot, mermaid, svg] = drawn("youbot/youbot.composite.toml");
    insta::assert_snapshot!("youbot.dot", dot);
    insta::assert_snapshot!("youbot.mermaid", mermaid);
    assert_eq!(svg.matches(">Driver</text>").count(), 1, "{svg}");
}
