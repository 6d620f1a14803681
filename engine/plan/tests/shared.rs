//! Composites of `shared/specs`: no errors in any profile, and detection of the five planted mistakes of robotics §4.4.

use std::path::Path;
use std::sync::Arc;

use crate::support::{Files, Variables};
use asmotion_composite::{AsmFiles, Context, Tables};
use asmotion_diagnostics::{LoadError, Loader, Severity};
use asmotion_plan::Opened;

const FOLDER: &str = "../../../shared/specs";

fn is_there() -> bool {
    asmotion_skip::shared("specs").is_some()
}

/// The files of the folder without the demand for a verification, and with a converter in place of the name of one.
struct Unverified(Files);

impl Loader for Unverified {
    fn read(&self, path: &str) -> Result<Arc<str>, LoadError> {
        let text = self.0.read(path)?;
        let text = text.replace(", refuse_start_on_failure = true", "");
        let named = "convert = \"event_from_string\"";
        Ok(Arc::from(text.replace(
            named,
            "convert = { data = \"REACHED = reached, BLOCKED = blocked\" }",
        )))
    }

    fn resolve(&self, from: &str, import: &str) -> Option<String> {
        self.0.resolve(from, import)
    }
}

/// The same files, one of them modified.
struct Changed<'c> {
    files: Unverified,
    path: &'c str,
    from: &'c str,
    to: &'c str,
}

impl Loader for Changed<'_> {
    fn read(&self, path: &str) -> Result<Arc<str>, LoadError> {
        let text = self.files.read(path)?;
        if path != self.path {
            return Ok(text);
        }
        assert!(text.contains(self.from), "`{}` is not in {path}", self.from);
        Ok(Arc::from(text.replacen(self.from, self.to, 1)))
    }

    fn resolve(&self, from: &str, import: &str) -> Option<String> {
        self.files.resolve(from, import)
    }
}

fn open(loader: &dyn Loader, file: &str) -> Opened {
    let specifications = AsmFiles::new(loader);
    let context = Context {
        loader,
        environment: &Variables,
        catalogue: &Tables::EMPTY,
        specifications: &specifications,
        programs: &asmotion_composite::NoPrograms,
        settings: &[],
    };
    asmotion_plan::open(file, &context)
}

fn errors(opened: &Opened) -> Vec<String> {
    let errors = opened.report.diagnostics.iter();
    let errors = errors.filter(|finding| finding.severity == Severity::Error);
    errors
        .map(|finding| format!("{}: {}", finding.code, finding.message))
        .collect()
}

#[test]
fn it_finds_no_error_in_any_of_them() {
    if !is_there() {
        return;
    }
    for file in ["navigation", "youbot", "youbot_driver"] {
        let path = format!("{file}.composite.toml");
        let opened = open(&Unverified(Files::new(FOLDER)), &path);
        let rendered = crate::support::render::report(&opened.sources, &opened.report);
        assert_eq!(errors(&opened), [""; 0], "{rendered}");
        insta::with_settings!({ prepend_module_to_snapshot => false, omit_expression => true }, {
            insta::assert_snapshot!(format!("shared_{file}"), rendered);
        });
        let profiles: Vec<Option<&str>> = if opened.profiles.is_empty() {
            vec![None]
        } else {
            opened
                .profiles
                .iter()
                .map(|name| Some(name.as_str()))
                .collect()
        };
        for profile in profiles {
            let plan = format!("{:#?}", opened.plan(profile).expect("a plan"));
            let name = format!("plan_{file}_{}", profile.unwrap_or("any"));
            insta::with_settings!({ prepend_module_to_snapshot => false, omit_expression => true }, {
                insta::assert_snapshot!(name, plan);
            });
        }
    }
}

#[test]
fn it_finds_no_error_in_the_composites_of_this_repository() {
    let specs = Path::new("../../specs");
    let folders = std::fs::read_dir(specs).expect("the folder of specifications");
    for folder in folders {
        let folder = folder.expect("an entry").path();
        let Ok(entries) = std::fs::read_dir(&folder) else {
            continue;
        };
        for entry in entries {
            let name = entry
                .expect("an entry")
                .file_name()
                .into_string()
                .expect("a name");
            if name.ends_with(".composite.toml") {
                // composites have bases in other folders
                let of = folder.file_name().expect("a name").to_string_lossy();
                let opened = open(&Files::new("../../specs"), &format!("{of}/{name}"));
                let rendered = crate::support::render::report(&opened.sources, &opened.report);
                assert_eq!(errors(&opened), [""; 0], "{rendered}");
            }
        }
    }
}

fn planted(path: &str, from: &str, to: &str, file: &str) -> Vec<String> {
    let loader = Changed {
        files: Unverified(Files::new(FOLDER)),
        path,
        from,
        to,
    };
    errors(&open(&loader, file))
}

#[test]
fn it_finds_a_misspelt_port_once() {
    if !is_there() {
        return;
    }
    let path = "youbot_driver.composite.toml";
    let found = planted(
        path,
        "to     = \"youBotDriver.commands\"",
        "to = \"youBotDriver.command\"",
        path,
    );
    assert_eq!(found, ["C021: unknown port `command` of `youBotDriver`"]);
}

#[test]
fn it_finds_a_clash_of_types() {
    if !is_there() {
        return;
    }
    let path = "youbot_driver.composite.toml";
    let found = planted(
        path,
        "to     = \"youBotDriver.commands\"",
        "to = \"youBotDriver.period\"",
        path,
    );
    assert_eq!(
        found,
        [
            "C045: unconnected input `youBotDriver.commands`",
            "C042: mismatched types: `SCAyouBotDriver.commands` is `youbot/JointCommand`, but `youBotDriver.period` is `f64`",
            "C043: two writers of `youBotDriver.period`, which keeps only the last value",
        ]
    );
}

#[test]
fn it_finds_a_misspelt_rename() {
    if !is_there() {
        return;
    }
    let path = "navigation.composite.toml";
    let found = planted(
        path,
        "{ trajectory = \"plan\"",
        "{ trajectroy = \"plan\"",
        path,
    );
    assert_eq!(
        found,
        [
            "C052: cannot rename `trajectroy`: `TrajectoryPlanner` neither subscribes nor publishes it"
        ]
    );
    // the unconnected port resulting from the misspelling
    let loader = Changed {
        files: Unverified(Files::new(FOLDER)),
        path,
        from: "{ trajectory = \"plan\"",
        to: "{ trajectroy = \"plan\"",
    };
    let opened = open(&loader, path);
    let silent = opened
        .report
        .diagnostics
        .iter()
        .any(|it| it.message == "no component publishes `plan`");
    assert!(silent);
}

#[test]
fn it_finds_a_forgotten_wire() {
    if !is_there() {
        return;
    }
    let wire = "[[wires]]\nreference = \"Monitor.period\"\nservice   = \"Driver.settingPeriod\"\nbinding   = \"amqp\"\n";
    let path = "youbot.composite.toml";
    let found = planted(path, wire, "", path);
    assert_eq!(found, ["C031: unconnected reference `Monitor.period`"]);
}
