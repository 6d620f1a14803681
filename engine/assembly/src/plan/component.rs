//! A component of a plan.

use serde::Serialize;

use super::Settings;
use crate::model::{Builtin, Direction, OnDeadline, OnException, Overrun, ProxyMode, Scheduler};
use asmotion_coordinator::Binding;

/// A component.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Component {
    /// Its name, behind those of the composites it is nested in: `Driver/youBotDriver`.
    pub name: String,
    /// Its id: names its queue, its log, its metrics.
    pub id: String,
    /// What it is made of.
    pub implementation: Implementation,
    /// When it cycles.
    pub pace: Pace,
    /// What happens without anybody asking.
    pub lifecycle: Lifecycle,
    /// Input ports.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub inputs: Vec<Port>,
    /// Output ports.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub outputs: Vec<Port>,
    /// Services.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub services: Vec<Service>,
    /// References.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub references: Vec<Service>,
    /// Properties that are set.
    #[serde(skip_serializing_if = "Settings::is_empty")]
    pub properties: Settings,
    /// `bind`, of an ASM.
    pub binding: Option<Binding>,
    /// `verify`, of an ASM.
    pub verify: Option<Verify>,
    /// `map` of a port-proxy.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub proxy: Vec<ProxyEntry>,
    /// `notify` of a port-proxy.
    pub notify: Option<Notify>,
    /// Both as the bridge executes them.
    #[serde(skip)]
    pub bridge: Option<asmotion_bridge::Settings>,
    /// `map` of a ros-bridge.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub ros: Vec<RosEntry>,
    /// `plots` of a web-monitor.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub plots: Vec<Plot>,
}

/// What a component is made of.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Implementation {
    /// A component of the build, by its name in the catalogue.
    Rust(String),
    /// A specification.
    Asm(Asm),
    /// A component of the engine.
    Builtin(BuiltinSettings),
    /// Another program and its arguments.
    Process(Vec<String>),
    /// A ROS node: package and executable.
    Ros(Vec<String>),
    /// A component of a running Orocos system, and where its name service is.
    Orocos(Vec<String>),
}

/// A specification.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Asm {
    /// Its path, as the loader resolved it.
    pub path: String,
    /// Its main rule, where the composite names it.
    pub main: Option<String>,
}

/// A component of the engine.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BuiltinSettings {
    /// Which one.
    pub kind: Builtin,
    /// The component whose ports it offers.
    pub target: Option<String>,
    /// The bridge it uses.
    pub bridge: Option<String>,
    /// The TCP port.
    pub port: Option<u64>,
}

/// When a component cycles.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Pace {
    /// Time between two cycles; 0 is event-driven.
    pub period_ms: u64,
    /// Time before the first cycle.
    pub delay_ms: u64,
    /// Whether it cycles as soon as the composite runs.
    pub run_on_startup: bool,
    /// Whether a stop may cut a cycle short.
    pub may_interrupt_if_running: bool,
    /// What happens to a cycle that could not begin in time.
    pub overrun: Overrun,
    /// The broker its topics go through; in process where absent.
    pub broker: Option<String>,
    /// The scheduling class of its thread; that of its process, if absent.
    pub scheduler: Option<Scheduler>,
    /// The priority in that class; that of its process, if absent.
    pub priority: Option<u64>,
    /// The processors it may run on; those of its process, if none is named.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub cpu: Vec<u64>,
    /// How long a cycle may take.
    pub deadline_ms: Option<u64>,
    /// What happens when it takes longer.
    pub on_deadline: OnDeadline,
    /// The component in whose thread, and after which, it cycles.
    pub master: Option<String>,
}

/// What happens without anybody asking.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Lifecycle {
    /// Configure when loaded.
    pub autoconf: bool,
    /// Start when configured.
    pub autostart: bool,
    /// What follows an exception.
    pub on_exception: OnException,
    /// How often it is reset before it is given up.
    pub max_resets: u64,
}

/// A port.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Port {
    /// Its name.
    pub name: String,
    /// The type of its messages.
    #[serde(rename = "type")]
    pub kind: String,
    /// The topic it is on.
    pub topic: Option<String>,
}

/// A service or a reference.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Service {
    /// Its name.
    pub name: String,
    /// Its interface.
    pub interface: String,
}

/// What must hold of a specification before it may start.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verify {
    /// Its CTL properties.
    pub ctl: bool,
    /// Its LTL properties.
    pub ltl: bool,
    /// Its invariants.
    pub invariants: bool,
    /// Whether a failure keeps the composite from starting.
    pub refuse_start_on_failure: bool,
}

/// A service operation that is a port.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ProxyEntry {
    /// The service of the proxy.
    pub service: String,
    /// Its operation.
    pub operation: String,
    /// The port of the proxy, which has the name of the target's port.
    pub port: String,
    /// How the operation uses the port.
    pub mode: ProxyMode,
    /// The part of the message that is argument or result.
    pub field: Option<String>,
}

/// Which events a port-proxy tells, and when.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Notify {
    /// The reference it tells them through.
    pub reference: String,
    /// When `busy` is told.
    pub busy: Option<String>,
    /// When `idle` is told.
    pub idle: Option<Idle>,
    /// When `refresh` is told.
    pub refresh: Option<String>,
    /// When `fault` is told.
    pub fault: Option<String>,
    /// After how long without data `stale` is told.
    pub stale_ms: Option<u64>,
}

/// What was measured is near what was commanded, for some time.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Idle {
    /// How near.
    pub within: f64,
    /// `port.field` of what was commanded.
    pub of: String,
    /// `port.field` of what is measured.
    pub on: String,
    /// For how long.
    pub for_ms: u64,
}

/// A topic here that is a topic of ROS.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RosEntry {
    /// The port of the bridge component.
    pub port: String,
    /// The topic there.
    pub ros: String,
    /// The type there.
    #[serde(rename = "type")]
    pub kind: String,
    /// Which way messages go.
    pub direction: Direction,
    /// The converter.
    pub convert: Option<String>,
}

/// A chart.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Plot {
    /// Its title.
    pub title: String,
    /// A range of indices, one chart each.
    pub each: Option<String>,
    /// The fields drawn.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub series: Vec<String>,
    /// A field whose bits are shown as flags.
    pub flags: Option<String>,
    /// How much of the past is drawn.
    pub window_s: u64,
}
