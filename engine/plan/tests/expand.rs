//! Expanded composites are valid and expand to themselves.

use std::sync::Arc;

use crate::support::{Files, Variables};
use asmotion_composite::{AsmFiles, Context, Tables};
use asmotion_diagnostics::{LoadError, Loader};
use asmotion_plan::{Opened, expand};

/// The files of a folder and one additional file.
struct With<'w> {
    files: Files,
    name: &'w str,
    text: &'w str,
}

impl Loader for With<'_> {
    fn read(&self, path: &str) -> Result<Arc<str>, LoadError> {
        if path == self.name {
            Ok(Arc::from(self.text))
        } else {
            self.files.read(path)
        }
    }

    fn resolve(&self, from: &str, import: &str) -> Option<String> {
        if import == self.name {
            Some(import.to_owned())
        } else {
            self.files.resolve(from, import)
        }
    }
}

fn open(loader: &dyn Loader, file: &str) -> Opened {
    open_with(loader, file, &[])
}

fn open_with(loader: &dyn Loader, file: &str, settings: &[(String, String)]) -> Opened {
    let context = Context {
        loader,
        environment: &Variables,
        catalogue: &Tables::EMPTY,
        specifications: &AsmFiles::new(loader),
        programs: &asmotion_composite::NoPrograms,
        settings,
    };
    asmotion_plan::open(file, &context)
}

/// Names of the components of a composite, with properties that are set from outside.
fn components(settings: &[(&str, &str)]) -> Vec<String> {
    let settings = settings.iter();
    let settings = settings.map(|(name, text)| ((*name).to_owned(), (*text).to_owned()));
    let settings: Vec<_> = settings.collect();
    let loader = Files::new("tests/composites");
    let opened = open_with(&loader, "instances_of_properties_are_fine.toml", &settings);
    let plan = opened.plan(None);
    let said = || crate::support::render::report(&opened.sources, &opened.report);
    let plan = plan.unwrap_or_else(|| panic!("{}", said()));
    plan.components.iter().map(|it| it.name.clone()).collect()
}

#[test]
fn properties_determine_the_number_of_instances() {
    let nested = ["Motor1", "Motor2", "Motor3", "Motor4"].map(|it| format!("Nested/{it}"));
    let with_nested = |own: &[&str]| -> Vec<String> {
        let own = own.iter().map(|it| (*it).to_owned());
        own.chain(nested.clone()).collect()
    };
    let default = ["Robot1", "Robot2", "Robot3", "Gate_left", "Gate_right"];
    assert_eq!(components(&[]), with_nested(&default));
    let set = components(&[("robots", "1"), ("sides", "north")]);
    assert_eq!(set, with_nested(&["Robot1", "Gate_north"]));
    // those of a nested file keep their number
    assert_eq!(components(&[("robots", "20")]).len(), 20 + 2 + 4);
}

#[test]
fn instances_share_their_bindings_unless_the_messages_differ() {
    let file = "instances_with_bindings_are_fine.toml";
    let opened = crate::support::open("tests/composites", file);
    let plan = opened.plan(None).unwrap();
    let [a, b, c] = ["a", "b", "c"].map(|it| {
        let component = plan.component(&format!("Guard{it}")).unwrap();
        component.binding.clone().unwrap()
    });
    assert!(Arc::ptr_eq(&a, &b));
    let field = |of: &asmotion_coordinator::Binding| of.monitored[0].field.clone();
    assert_eq!(
        [field(&a), field(&c)],
        ["told", "heard"].map(|it| Some(it.to_owned()))
    );
}

/// Returns the expansions of a composite by profile, after verifying that each expands to itself.
fn expansions(folder: &str, file: &str) -> Vec<String> {
    let opened = open(&Files::new(folder), file);
    let profiles: Vec<Option<&str>> = if opened.profiles.is_empty() {
        vec![None]
    } else {
        opened.profiles.iter().map(|it| Some(it.as_str())).collect()
    };
    let plans = profiles
        .into_iter()
        .filter_map(|profile| opened.plan(profile));
    // a composite with unset variables cannot be expanded
    let plans = plans.filter(|plan| plan.missing.is_empty());
    let expand_again = |plan| {
        let text = expand(&opened, plan);
        let name = "expanded.toml";
        let loader = With {
            files: Files::new(folder),
            name,
            text: &text,
        };
        let again = open(&loader, name);
        let said = crate::support::render::report(&again.sources, &again.report);
        let Some(plan) = again.plan(None) else {
            panic!("{file}\n{text}\n{said}");
        };
        assert!(!again.report.has_errors(), "{file}\n{said}");
        assert_eq!(expand(&again, plan), text, "{file}");
        text
    };
    plans.map(|plan| expand_again(plan)).collect()
}

#[test]
fn t26_c11_three_composites_in_each_other_are_opened_up() {
    let expansions = expansions("tests/composites", "c11_three_levels.toml");
    insta::assert_snapshot!(expansions.first().expect("an expansion"));
}

#[test]
fn c12_a_promoted_property_overrides_the_one_inside() {
    let expansions = expansions("tests/composites", "c11_three_levels.toml");
    let text = expansions.first().expect("an expansion");
    let (_, motor) = text
        .split_once("[components.\"Robot/Base/Motor\"]")
        .expect("the motor");
    let (_, properties) = motor.split_once("\nproperties = ").expect("its properties");
    let line = properties.lines().next();
    assert_eq!(line, Some("{ gain = 2.5, wheels = 4, colour = \"red\" }"));
}

#[test]
fn it_writes_the_tables_within_a_binding() {
    let expansions = expansions("tests/composites", "calls_are_fine.toml");
    let text = expansions.first().expect("an expansion");
    let call = "with = { map = \"@map\", start = \"@goal\", goal = \"@goal\" }, keep = \"path\", ok = \"PATH_OK\", \
        failed = \"CALL_FAILED\", faults = { NO_PATH = \"CALL_FAILED\" }, timeout = \"CALL_FAILED\"";
    assert!(text.contains(call), "{text}");
}

#[test]
fn it_expands_every_composite_of_this_repository_to_itself() {
    for folder in ["navigation", "youbot", "courier"] {
        let folder = format!("../../specs/{folder}");
        for entry in std::fs::read_dir(&folder).expect("a folder") {
            let file = entry.expect("an entry").file_name();
            let file = file.to_str().expect("a name");
            if file.ends_with(".composite.toml") {
                assert!(!expansions(&folder, file).is_empty(), "{file}");
            }
        }
    }
    for file in std::fs::read_dir("tests/composites").expect("a folder") {
        let file = file.expect("an entry").file_name();
        let file = file.to_str().expect("a name");
        if file.ends_with(".toml") {
            expansions("tests/composites", file);
        }
    }
}

#[test]
fn ends_that_share_one_queue_stay_together() {
    let text = "schema = \"composite/1\"\n[composite]\nname = \"shared\"\n\
        [components.A]\nimplementation = { process = \"a\" }\nports.out = { n = \"f64\", m = \"f64\" }\n\
        [components.B]\nimplementation = { process = \"b\" }\nports.in = { n = \"f64\", m = \"f64\" }\n\
        [[connections]]\nfrom = [\"A.n\", \"A.m\"]\nto = [\"B.n\", \"B.m\"]\n\
        policy = { type = \"buffer\", size = 8, buffer = \"shared\" }\n";
    let loader = With {
        files: Files::new("tests/composites"),
        name: "shared.toml",
        text,
    };
    let opened = open(&loader, "shared.toml");
    let expanded = expand(&opened, opened.plan(None).expect("a plan"));
    assert_eq!(expanded.matches("[[connections]]").count(), 1, "{expanded}");
    assert!(
        expanded.contains("from = [\"A.n\", \"A.m\"]\nto = [\"B.n\", \"B.m\"]"),
        "{expanded}"
    );
}

#[test]
fn it_shows_no_secret() {
    let text = "schema = \"composite/1\"\n[composite]\nname = \"secret\"\n[properties]\nword = { type = \"secret\", default = \"${ROBOT_PASSWORD_FILE}\" }\n\
        [brokers.main]\nurl = \"amqp://${ROBOT_USER}:${ROBOT_PASSWORD_FILE}@desk\"\n\
        [components.A]\nimplementation = { process = \"a\" }\nproperties = { word = \"${properties.word}\" }\ntask = { broker = \"main\" }\n";
    let loader = With {
        files: Files::new("tests/composites"),
        name: "secret.toml",
        text,
    };
    let opened = open(&loader, "secret.toml");
    let expanded = expand(&opened, opened.plan(None).expect("a plan"));
    assert!(!expanded.contains("geheim"), "{expanded}");
    assert_eq!(expanded.matches("***").count(), 2, "{expanded}");
}

/// Instances are the same as elements that are written one by one.
#[test]
fn it_expands_instances_to_elements() {
    let expanded = expansions("tests/composites", "instances_are_fine.toml");
    insta::assert_snapshot!("instances", expanded.join("\n"));
}
