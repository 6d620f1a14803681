//! Every key of composite files has an effect that is observed here, or a code that says that it has none.
//!
//! `keys/keys.toml` has a change of a composite for each key. The composite is checked, described, drawn and run before and after
//! it, and at least one of the results differs. A key whose effect needs a broker, real time or several processes names the test
//! that observes it.

use rayon::prelude::*;
use serde::Deserialize;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Arc, Mutex, OnceLock};
use xtask::checkout::Checkout;

const KEYS: &str = include_str!("keys/keys.toml");

/// Codes that report a key as wrong, not its effect.
const SYNTAX: [&str; 3] = ["C003", "C005", "C006"];

#[derive(Deserialize)]
struct Keys {
    /// Keys that only describe a composite, for its readers and in SCDL.
    documentation: Vec<String>,
    edits: BTreeMap<String, Edit>,
    tests: BTreeMap<String, String>,
}

/// A change of a composite.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Edit {
    /// The composite below `specs`, without its suffix.
    of: String,
    /// Replacements before and after the change.
    #[serde(default)]
    base: Vec<(String, String)>,
    /// The text that changes; without it, `before` and `with` are added at the end.
    replace: Option<String>,
    /// The text before the change; `replace` by default.
    before: Option<String>,
    /// The text after the change.
    with: String,
    /// A change of another composite that goes with it.
    also: Option<Companion>,
    /// The composite that is observed, if it is another one.
    run: Option<String>,
    /// Property set on the command line.
    set: Option<String>,
    /// Duration of the run in virtual seconds.
    #[serde(default = "few_seconds")]
    seconds: u32,
    /// Code that says that the key has no effect.
    code: Option<String>,
}

fn few_seconds() -> u32 {
    8
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Companion {
    of: Option<String>,
    replace: String,
    with: String,
}

fn keys() -> Keys {
    toml::from_str(KEYS).unwrap()
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The keys in the schema that are no tables, with `*` for names; lists are not marked.
fn schema_keys() -> BTreeSet<String> {
    fn walk(node: &Value, path: &str, keys: &mut BTreeSet<String>) {
        for choice in ["anyOf", "oneOf", "allOf"] {
            let choices = node[choice].as_array().into_iter().flatten();
            choices.for_each(|node| walk(node, path, keys));
        }
        for (name, node) in node["properties"].as_object().into_iter().flatten() {
            let path = if path.is_empty() {
                name.clone()
            } else {
                format!("{path}.{name}")
            };
            walk(node, &path, keys);
            keys.insert(path);
        }
        if node["additionalProperties"].is_object() {
            walk(&node["additionalProperties"], &format!("{path}.*"), keys);
        }
        if node["items"].is_object() {
            walk(&node["items"], path, keys);
        }
    }
    let output = asmotion(root(), &["schema"]);
    let schema: Value = serde_json::from_str(&output.1).unwrap();
    let mut keys = BTreeSet::new();
    walk(&schema, "", &mut keys);
    let is_table = |key: &String| {
        keys.iter()
            .any(|other| other.starts_with(&format!("{key}.")))
    };
    keys.iter().filter(|key| !is_table(key)).cloned().collect()
}

/// Exit code and standard output.
fn asmotion(folder: &Path, arguments: &[&str]) -> (Option<i32>, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    let output = command
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap();
    (
        output.status.code(),
        String::from_utf8(output.stdout).unwrap(),
    )
}

/// Codes and messages of the findings.
fn findings(folder: &Path, path: &str) -> BTreeSet<(String, String)> {
    let (_, out) = asmotion(folder, &["check", "--json", path]);
    let report: Value = serde_json::from_str(&out).unwrap();
    let findings = report["findings"].as_array().unwrap();
    let text = |value: &Value| value.as_str().unwrap().to_owned();
    findings
        .iter()
        .map(|it| (text(&it["code"]), text(&it["message"])))
        .collect()
}

/// Output of tools about a composite, without the findings and the run.
fn shown(folder: &Path, path: &str) -> String {
    let commands: [&[&str]; 4] = [
        &["check", "--connections", path],
        &["describe", "--asyncapi", path],
        &["graph", "--format", "svg", path],
        &["scdl", "export", path],
    ];
    let outputs = commands.map(|arguments| asmotion(folder, arguments).1);
    // comments repeat what SCDL cannot express
    let is_comment = |line: &&str| line.trim_start().starts_with("<!--");
    let lines = outputs
        .iter()
        .flat_map(|output| output.lines())
        .filter(|line| !is_comment(line));
    lines.collect::<Vec<_>>().join("\n")
}

/// Exit code, events and trace of a run in virtual time.
fn ran(folder: &Path, path: &str, edit: &Edit) -> String {
    let seconds = edit.seconds.to_string();
    let mut arguments = vec![
        "run", path, "--json", "--for", &seconds, "--trace", "run.txt",
    ];
    arguments.extend(["--bus", "local", "--http", "off"]);
    arguments.extend(edit.set.iter().flat_map(|set| ["--set", set]));
    let (code, out) = asmotion(folder, &arguments);
    // the summary has the wall time
    let events = out.lines().filter(|line| !line.contains("\"wall_s\""));
    let events: Vec<&str> = events.collect();
    let trace = std::fs::read_to_string(folder.join("run.txt")).unwrap_or_default();
    format!("{code:?}\n{}\n{trace}", events.join("\n"))
}

/// Replaces a text that occurs in the file of a composite.
fn replaced(text: &str, from: &str, to: &str, of: &str) -> String {
    assert!(text.contains(from), "`{from}` is not in {of}");
    text.replacen(from, to, 1)
}

/// The specifications, with other texts of some composites.
#[derive(Default, Clone, PartialEq, Eq, PartialOrd, Ord)]
struct Version {
    composites: BTreeMap<String, String>,
}

impl Version {
    fn path(folder: &Path, of: &str) -> PathBuf {
        folder.join(format!("specs/{of}.composite.toml"))
    }

    /// The text of a composite.
    fn text(&self, of: &str) -> String {
        let own = || std::fs::read_to_string(Self::path(root(), of)).unwrap();
        self.composites.get(of).cloned().unwrap_or_else(own)
    }

    /// With a text that occurs in a composite replaced by another.
    fn with(mut self, of: &str, from: &str, to: &str) -> Self {
        let text = replaced(&self.text(of), from, to, of);
        self.composites.insert(of.to_owned(), text);
        self
    }

    /// With a text at the end of a composite, which may be empty.
    fn with_end(mut self, of: &str, end: &str) -> Self {
        let mut text = self.text(of);
        if !end.is_empty() {
            text = format!("{text}\n{end}\n");
        }
        self.composites.insert(of.to_owned(), text);
        self
    }

    /// A copy of the specifications.
    fn folder(&self) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        let copied = Command::new("cp")
            .arg("-r")
            .arg(root().join("specs"))
            .arg(folder.path())
            .status();
        assert!(copied.unwrap().success());
        for (of, text) in &self.composites {
            std::fs::write(Self::path(folder.path(), of), text).unwrap();
        }
        folder
    }
}

/// A version, and the way of looking at it.
type Subject = (Version, String);

/// Observations of versions. Most changes have the same version before them, which is observed once.
struct Observed<T>(Mutex<BTreeMap<Subject, Arc<OnceLock<T>>>>);

impl<T: Clone> Observed<T> {
    fn new() -> Self {
        Self(Mutex::default())
    }

    /// Looks at a folder with a version, unless it has been looked at in this way.
    fn get(&self, version: &Version, way: String, look: impl FnOnce(&Path) -> T) -> T {
        let subject = (version.clone(), way);
        let known = Arc::clone(self.0.lock().unwrap().entry(subject).or_default());
        let looked = known.get_or_init(|| look(version.folder().path()));
        looked.clone()
    }
}

/// Observations of all changes.
struct Observations {
    findings: Observed<BTreeSet<(String, String)>>,
    texts: Observed<String>,
}

impl Edit {
    /// Before and after the change.
    fn versions(&self) -> [Version; 2] {
        let (of, replaced) = (&*self.of, self.replace.as_deref());
        let base = self.base.iter();
        let base = base.fold(Version::default(), |it, (from, to)| it.with(of, from, to));
        let changed = |text: &str| match replaced {
            Some(from) => base.clone().with(of, from, text),
            None => base.clone().with_end(of, text),
        };
        let before = self.before.as_deref().or(replaced).unwrap_or_default();
        let mut after = changed(&self.with);
        if let Some(Companion { of, replace, with }) = &self.also {
            after = after.with(of.as_ref().unwrap_or(&self.of), replace, with);
        }
        [changed(before), after]
    }

    /// The reason that no effect is observed.
    fn failure(&self, observations: &Observations) -> Option<String> {
        let versions = self.versions();
        let name = self.run.as_ref().unwrap_or(&self.of);
        let path = format!("specs/{name}.composite.toml");
        let [before, after] = versions.each_ref().map(|version| {
            let look = |folder: &Path| findings(folder, &path);
            observations.findings.get(version, path.clone(), look)
        });
        let new: Vec<_> = after.difference(&before).collect();
        if new.iter().any(|(code, _)| SYNTAX.contains(&&**code)) {
            return Some(format!("the change is not valid: {new:?}"));
        }
        if let Some(code) = &self.code {
            let said = after.iter().any(|(found, _)| found == code);
            return (!said).then(|| format!("{code} is not reported: {after:?}"));
        }
        if before != after {
            return None;
        }
        let differ = |way: String, look: &dyn Fn(&Path) -> String| {
            let looked = |version| observations.texts.get(version, way.clone(), look);
            let [before, after] = versions.each_ref().map(looked);
            before != after
        };
        let run = format!("run {path} {} {:?}", self.seconds, self.set);
        let is_seen = differ(format!("show {path}"), &|folder| shown(folder, &path))
            || differ(run, &|folder| ran(folder, &path, self));
        (!is_seen).then(|| "the change has no effect".to_owned())
    }
}

#[test]
fn every_key_has_an_effect_or_a_code_that_says_it_has_none() {
    let observations = Observations {
        findings: Observed::new(),
        texts: Observed::new(),
    };
    let failures: Vec<String> = keys()
        .edits
        .par_iter()
        .filter_map(|(key, edit)| Some(format!("{key}: {}", edit.failure(&observations)?)))
        .collect();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn every_key_of_the_schema_is_observed_once() {
    let keys = keys();
    let tested = keys.edits.keys().chain(keys.tests.keys());
    let observed: Vec<&String> = tested.chain(&keys.documentation).collect();
    let once: BTreeSet<String> = observed.iter().map(|key| (*key).clone()).collect();
    assert_eq!(once.len(), observed.len(), "a key is observed twice");
    let known = schema_keys();
    let missing: Vec<_> = known.difference(&once).collect();
    let unknown: Vec<_> = once.difference(&known).collect();
    assert!(missing.is_empty(), "not observed: {missing:?}");
    assert!(unknown.is_empty(), "not in the schema: {unknown:?}");
}

#[test]
fn the_tests_that_observe_keys_exist() {
    let checkout = Checkout::working_tree(root()).unwrap();
    let texts = checkout.files.iter().map(|file| &file.text);
    let tests = texts.flat_map(|text| text.split("#[test]").skip(1));
    let names: BTreeSet<&str> = tests
        .filter_map(|test| Some(test.split_once("fn ")?.1.split_once('(')?.0))
        .collect();
    for (key, test) in keys().tests {
        assert!(
            names.contains(&*test),
            "`{key}` names the test `{test}`, which does not exist"
        );
    }
}

#[test]
fn what_the_readme_calls_missing_is_reported_and_nothing_else() {
    let readme = std::fs::read_to_string(root().join("README.md")).unwrap();
    let (_, missing) = readme.split_once("Not implemented yet").unwrap();
    let (missing, _) = missing.split_once("\n\n").unwrap();
    let claimed = missing.split('`').skip(1).step_by(2);
    let claimed: BTreeSet<&str> = claimed.filter(|name| !name.contains(' ')).collect();
    // the tables all of whose keys are reported by C076
    let mut found = BTreeSet::new();
    for (key, edit) in keys().edits {
        let table = ["bridges"];
        let Some(table) = table.iter().find(|it| key.starts_with(**it)) else {
            continue;
        };
        let [_, after] = edit.versions();
        let path = format!("specs/{}.composite.toml", edit.of);
        let findings = findings(after.folder().path(), &path);
        assert!(
            findings.iter().any(|(code, _)| code == "C076"),
            "{key}: {findings:?}"
        );
        found.insert(*table);
    }
    assert_eq!(claimed, found);
}
