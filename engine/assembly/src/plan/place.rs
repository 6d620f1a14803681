//! Which process runs what.

use std::collections::BTreeMap;

use serde::Serialize;

use super::Plan;
use super::fill::{given, number};
use crate::model::{Composite, Deploy, RestartPolicy, Scheduler};

/// A process and the components in it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Process {
    /// Its name.
    pub name: String,
    /// The machine it runs on.
    pub host: Option<String>,
    /// The components in it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub components: Vec<String>,
    /// The scheduling class of its components that name none.
    pub scheduler: Scheduler,
    /// The priority in it of those that name none.
    pub priority: Option<u64>,
    /// The processors that its components may run on that name none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub cpu: Vec<u64>,
}

/// When a process is started again.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Restart {
    /// After what.
    pub policy: RestartPolicy,
    /// How often within the window.
    pub max: u64,
    /// The window.
    pub window_s: u64,
    /// The waits; the last one repeats.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub backoff_ms: Vec<u64>,
}

/// What of a run is written down.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Record {
    /// Where to.
    pub dir: String,
    /// Which topics; `*` is all.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub topics: Vec<String>,
    /// Calls and replies.
    pub calls: bool,
    /// States of the ASM components.
    pub asm_states: bool,
    /// How large a file grows.
    pub rotate_mb: u64,
}

impl Plan {
    /// The process that a component is placed in.
    pub fn process_of(&self, component: &str) -> Option<&Process> {
        let mut processes = self.processes.iter();
        processes.find(|process| process.components.iter().any(|it| it == component))
    }
}

/// Fills in processes, restarts and recording. `nested` has the prefix of every nested composite:
/// its components all go where the composite goes.
pub(super) fn place(composite: &Composite, nested: &BTreeMap<&str, String>, plan: &mut Plan) {
    let Some(deploy) = &composite.deploy else {
        plan.processes = vec![Process {
            name: composite.name.value.clone(),
            host: None,
            components: plan
                .components
                .iter()
                .map(|component| component.name.clone())
                .collect(),
            scheduler: Scheduler::default(),
            priority: None,
            cpu: Vec::new(),
        }];
        return;
    };
    plan.processes = deploy
        .processes
        .iter()
        .map(|it| process(it, nested, plan))
        .collect();
    plan.restart = deploy.restart.as_ref().map(|restart| Restart {
        policy: given(&restart.policy),
        max: number(&restart.max).unwrap_or(5),
        window_s: number(&restart.window_s).unwrap_or(60),
        backoff_ms: numbers(&restart.backoff_ms),
    });
    plan.record = record(deploy);
}

fn process(
    written: &crate::model::Process,
    nested: &BTreeMap<&str, String>,
    plan: &Plan,
) -> Process {
    let placed = |component: &str| {
        written
            .components
            .iter()
            .any(|name| match nested.get(name.value.as_str()) {
                Some(prefix) => component.starts_with(prefix),
                None => component == name.value,
            })
    };
    let components = plan
        .components
        .iter()
        .map(|component| component.name.clone());
    Process {
        name: written.name.value.clone(),
        host: written.host.as_ref().map(|host| host.value.clone()),
        components: components.filter(|component| placed(component)).collect(),
        scheduler: given(&written.scheduler),
        priority: number(&written.priority),
        cpu: numbers(&written.cpu),
    }
}

fn record(deploy: &Deploy) -> Option<Record> {
    let record = deploy.record.as_ref()?;
    let topics: Vec<String> = record
        .topics
        .iter()
        .map(|topic| topic.value.clone())
        .collect();
    Some(Record {
        dir: record
            .dir
            .as_ref()
            .map_or_else(|| "runs/".to_owned(), |dir| dir.value.clone()),
        topics: if topics.is_empty() {
            vec!["*".to_owned()]
        } else {
            topics
        },
        calls: record.calls.as_ref().is_none_or(|calls| calls.value),
        asm_states: record.asm_states.as_ref().is_none_or(|states| states.value),
        rotate_mb: number(&record.rotate_mb).unwrap_or(256),
    })
}

fn numbers(numbers: &[crate::At<i64>]) -> Vec<u64> {
    numbers
        .iter()
        .filter_map(|number| u64::try_from(number.value).ok())
        .collect()
}
