//! Mission files: a composite, actions at given times or conditions, and expectations about the run.
//!
//! The file is read here; `asmotion test` resolves the conditions against a plan and runs the mission.

use asmotion_derive::Table;
use asmotion_diagnostics::{FileId, Report, Span};
use serde_json::{Value as Json, json};

use crate::at::At;
use crate::codes::c004::MissingKey;
use crate::finding::Findings;
use crate::read::{top, tree};
use crate::table::derived::{Keys, Reader};
use crate::table::{Dialect, Key, NamedValue, Table as _, Value};
use crate::tree::{Branch, Node};
use crate::value::SettingValue;

/// A mission: runs a composite in virtual time and checks what must hold.
#[derive(Clone, Debug, Table)]
#[table(of = "a mission file")]
pub struct MissionFile {
    /// Dialect and version of the file.
    #[key(needed, example = "\"mission/1\"")]
    pub schema: Option<Dialect>,
    /// Composite to run, relative to the folder of the mission.
    #[key(example = "\"navigation.composite.toml\"")]
    pub composite: At<String>,
    /// Description of the mission; the name in reports.
    #[key(example = "\"the e-stop stops the rover\"")]
    pub doc: Option<At<String>>,
    /// Profile of the composite.
    #[key(example = "\"sim\"")]
    pub profile: Option<At<String>>,
    /// Seed for choices, and for the property `seed` of the composite if it has one; that of the command line by default.
    #[key(range = 0..=4_294_967_295_i64)]
    pub seed: Option<At<u64>>,
    /// Values of properties of the composite.
    #[key(example = "{ place = \"office\" }")]
    pub properties: Vec<NamedValue<MissionValue>>,
    /// Settings of components, by name.
    #[key(example = "{ }")]
    pub components: Vec<MissionComponent>,
    /// Condition that ends the mission; its time limit is an error then. Without it, the mission ends at the time limit.
    #[key(example = "\"Coordinator.mode = ARRIVED\"")]
    pub end: Option<At<String>>,
    /// Time limit.
    #[key(unit = "seconds", range = 0.001..=86_400.0, default = 60.0)]
    pub limit_s: Option<At<f64>>,
    /// Components that may fail without failing the mission; those that an action fails are included.
    #[key(name = "may_fail", example = "[\"TrajectoryPlanner\"]")]
    pub may_fail: Vec<At<String>>,
    /// Compare the steps, life cycles and faults of the run with the accepted ones in the `.snap` file beside the mission.
    #[key(default = false)]
    pub snapshot: Option<At<bool>>,
    /// Actions, carried out once each.
    #[key(name = "at", example = "[[at]]")]
    pub actions: Vec<MissionAction>,
    /// Expectations, checked during the run.
    #[key(name = "expect", example = "[[expect]]")]
    pub expectations: Vec<MissionExpectation>,
}

/// Settings of a component.
#[derive(Clone, Debug, Table)]
#[table(of = "a component of a mission", example = "{ properties = { } }")]
pub struct MissionComponent {
    /// Name of the component.
    #[key(entry = thing)]
    pub name: At<String>,
    /// Values of its properties, in place of those of the composite.
    #[key(example = "{ slip = 0.01 }")]
    pub properties: Vec<NamedValue<MissionValue>>,
}

/// An action of a mission, at a time or when a condition becomes true.
#[derive(Clone, Debug, Table)]
#[table(
    of = "an action of a mission",
    example = "{ time_s = 15, stop = \"TrajectoryPlanner\" }",
    after = one_trigger
)]
pub struct MissionAction {
    /// Source location of the table.
    pub span: Span,
    /// Time of the action since the start.
    #[key(unit = "seconds", range = 0.0..=86_400.0, example = "15")]
    pub time_s: Option<At<f64>>,
    /// Condition that triggers the action when it becomes true for the first time.
    #[key(example = "\"Coordinator.mode = FOLLOWING\"")]
    pub when: Option<At<String>>,
    /// Delay of the action after its condition.
    #[key(unit = "seconds", range = 0.0..=86_400.0, default = 0.0)]
    pub delay_s: Option<At<f64>>,
    /// The action.
    #[key(flatten)]
    pub act: MissionAct,
}

/// Kinds of actions of a mission.
#[derive(Clone, Debug, Table)]
#[table(
    of = "an action of a mission",
    example = "{ time_s = 15, stop = \"TrajectoryPlanner\" }",
    reason = "an action does one thing; add another `[[at]]` for the other"
)]
pub enum MissionAct {
    /// Writes a message from outside.
    Write {
        /// Topic or input port that receives a message from outside.
        #[key(name = "write", example = "\"topic:estop\"")]
        to: At<String>,
        /// The message; omitted fields have their initial values.
        #[key(example = "{ data = true }")]
        value: At<MissionValue>,
    },
    /// Sets properties of a running component.
    Set {
        /// Component whose properties change.
        #[key(name = "set", example = "\"TrajectoryFollower\"")]
        component: At<String>,
        /// Names and new values of the properties.
        #[key(needed, example = "{ max_speed = 0.3 }")]
        properties: Vec<NamedValue<MissionValue>>,
    },
    /// Component to stop, as an operator would; its services no longer answer.
    #[key(example = "\"TrajectoryPlanner\"")]
    Stop(At<String>),
    /// Component to start again.
    #[key(example = "\"TrajectoryPlanner\"")]
    Start(At<String>),
    /// Component that fails, as by an error in its own code; its `on_exception` applies.
    #[key(example = "\"TrajectoryPlanner\"")]
    Fail(At<String>),
}

/// A requirement on the run.
#[derive(Clone, Debug, Table)]
#[table(
    of = "an expectation",
    example = "{ eventually = \"Coordinator.mode = ARRIVED\" }"
)]
pub struct MissionExpectation {
    /// Source location of the table.
    pub span: Span,
    /// Description of the requirement, for reports.
    #[key(example = "\"e-stop: stands still within 0.6 s\"")]
    pub doc: Option<At<String>>,
    /// Condition that begins the requirement each time it becomes true; the start of the mission by default.
    #[key(example = "\"topic:estop.data\"")]
    pub after: Option<At<String>>,
    /// Condition that ends the requirement; the end of the mission by default.
    #[key(example = "\"not topic:estop.data\"")]
    pub until: Option<At<String>>,
    /// Time allowed from the beginning until the requirement holds; for `eventually` until the end by default, for `always`
    /// and `never` none.
    #[key(unit = "seconds", range = 0.0..=86_400.0, example = "0.6")]
    pub within_s: Option<At<f64>>,
    /// The requirement.
    #[key(flatten)]
    pub requirement: MissionRequirement,
}

/// Kinds of requirements of an expectation.
#[derive(Clone, Debug, Table)]
#[table(
    of = "an expectation",
    example = "{ eventually = \"Coordinator.mode = ARRIVED\" }",
    reason = "an expectation has one requirement; add another `[[expect]]` for the other"
)]
pub enum MissionRequirement {
    /// Condition that must become true.
    #[key(example = "\"Coordinator.mode = ARRIVED\"")]
    Eventually(At<String>),
    /// Condition that must hold all the time.
    #[key(example = "\"speed(World.truth) < 0.6\"")]
    Always(At<String>),
    /// Condition that must not become true.
    #[key(example = "\"Coordinator.mode = FAILED\"")]
    Never(At<String>),
}

/// A value of a property or a message, without substitutions.
#[derive(Clone, Debug, PartialEq)]
pub struct MissionValue(pub SettingValue);

impl Value for MissionValue {
    fn schema(_: &Key) -> Json {
        json!({})
    }

    fn read(reader: &mut Reader<'_>, key: &At<String>, spec: &Key, node: &Node) -> Option<Self> {
        literal(reader, key, spec, node).then(|| Self(SettingValue::of(&node.value)))
    }
}

/// Reports substitutions in a value, which have no scope in a mission. Returns whether there are none.
fn literal(reader: &mut Reader<'_>, key: &At<String>, spec: &Key, node: &Node) -> bool {
    match &node.value {
        Branch::Text(_) => reader.text(key, node, spec.example).is_some(),
        Branch::List(items) => {
            let literal = |item| literal(reader, key, spec, item);
            items.iter().all(literal)
        }
        Branch::Table(table) => {
            let mut entries = table.entries.iter();
            entries.all(|entry| literal(reader, key, spec, &entry.node))
        }
        Branch::Integer(_) | Branch::Float(_) | Branch::Boolean(_) | Branch::Date(_) => true,
    }
}

/// Reports an action without a trigger or with two.
fn one_trigger(action: &mut MissionAction, keys: &mut Keys<'_, '_, '_>) {
    let reason = "an action has one trigger";
    keys.either("time_s", "when", reason);
    keys.either("time_s", "delay_s", "a delay counts from a condition");
    if action.time_s.is_none() && action.when.is_none() {
        keys.reader.report.found(MissingKey {
            key: "time_s",
            of: "an action of a mission",
            at: action.span,
            example: "15".to_owned(),
        });
    }
}

/// Reads a mission file. The model is `None` if nothing could be read, and incomplete if there are errors.
pub fn read(file: FileId, path: &str, text: &str) -> (Option<MissionFile>, Report) {
    let (tree, mut report) = tree(file, path, text);
    let mut reader = Reader::new(text);
    let mission = tree.and_then(|tree| {
        let top = top(file);
        let mut keys = reader.keys(&tree, MissionFile::outline().of, top);
        MissionFile::read_keys(&mut keys, &At::new(String::new(), top))
    });
    report.extend(reader.report);
    (mission, report.finish())
}
