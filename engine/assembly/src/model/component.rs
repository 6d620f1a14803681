//! A component as the composite describes it.

use asmotion_derive::Word;
use asmotion_diagnostics::Span;

use super::binding::Bind;
use super::{End, Implementation, Lifecycle, Pace, Setting};
use crate::At;

/// `[components.<name>]`.
#[derive(Clone, Debug)]
pub struct Component {
    /// Its name.
    pub name: At<String>,
    /// In which profiles; everywhere where empty.
    pub profiles: Vec<At<String>>,
    /// What it is for.
    pub doc: Option<At<String>>,
    /// What it is made of; `None` where that could not be read.
    pub implementation: Option<Implementation>,
    /// `task` or `activity`: when it cycles.
    pub pace: Option<Pace>,
    /// `lifecycle`: what happens without anybody asking.
    pub lifecycle: Option<Lifecycle>,
    /// `ports.in`.
    pub inputs: Vec<Listed>,
    /// `ports.out`.
    pub outputs: Vec<Listed>,
    /// `subscribe`: input ports on the topic of the same name.
    pub subscribe: Vec<Listed>,
    /// `publish`: output ports on the topic of the same name.
    pub publish: Vec<Listed>,
    /// `rename`: other topics for those names (TCA's topicRename).
    pub rename: Vec<Rename>,
    /// `services` it provides, with their interfaces.
    pub services: Vec<Listed>,
    /// `references` it needs.
    pub references: Vec<Wanted>,
    /// `operations` it offers to anybody, with their signatures.
    pub operations: Vec<Listed>,
    /// `properties` that are set.
    pub properties: Vec<Setting>,
    /// `bind`: functions of an ASM and the world.
    pub bind: Bind,
    /// `verify`: what must hold before it may start.
    pub verify: Option<Verify>,
    /// `map` of a built-in.
    pub map: Vec<MapEntry>,
    /// `notify` of a port-proxy.
    pub notify: Option<Notify>,
    /// `plots` of a web-monitor.
    pub plots: Vec<Plot>,
}

/// A name and its type or interface, as in `scan = "sensor_msgs/LaserScan"`.
#[derive(Clone, Debug)]
pub struct Listed {
    /// The name.
    pub name: At<String>,
    /// The type or interface.
    pub kind: At<String>,
}

/// A reference.
#[derive(Clone, Debug)]
pub struct Wanted {
    /// Its name.
    pub name: At<String>,
    /// The interface it needs.
    pub interface: At<String>,
    /// Whether the component can do without.
    pub optional: bool,
}

/// `rename = { trajectory = "plan" }`.
#[derive(Clone, Debug)]
pub struct Rename {
    /// The name in the component.
    pub from: At<String>,
    /// The topic in the composite.
    pub to: At<String>,
}

/// `verify`: what must hold of an ASM before it may start.
#[derive(Clone, Debug)]
pub struct Verify {
    /// Its CTL properties.
    pub ctl: Option<At<bool>>,
    /// Its LTL properties.
    pub ltl: Option<At<bool>>,
    /// Its invariants.
    pub invariants: Option<At<bool>>,
    /// Whether a failure keeps the composite from starting.
    pub refuse_start_on_failure: Option<At<bool>>,
}

/// An entry of `map`.
#[derive(Clone, Debug)]
pub enum MapEntry {
    /// Of a port-proxy.
    Proxy(ProxyEntry),
    /// Of a ros-bridge.
    Ros(RosEntry),
}

/// A service operation that is a port.
#[derive(Clone, Debug)]
pub struct ProxyEntry {
    /// The place of the entry.
    pub span: Span,
    /// `service.operation`; the `component` of the end is the service.
    pub operation: End,
    /// The port of the target.
    pub port: End,
    /// How the operation uses the port.
    pub mode: At<ProxyMode>,
    /// The part of the message that is argument or result.
    pub field: Option<Path>,
}

/// How an operation uses a port.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, Word)]
#[serde(rename_all = "snake_case")]
pub enum ProxyMode {
    /// Writes it.
    #[default]
    Oneway,
    /// Writes it; a reply means that the target has read it.
    Taken,
    /// Writes it; a reply means that the motion has ended.
    Done,
    /// Reads its last value.
    Last,
    /// Reads everything since the last call.
    All,
}

/// A topic here that is a topic of ROS.
#[derive(Clone, Debug)]
pub struct RosEntry {
    /// The place of the entry.
    pub span: Span,
    /// The name here.
    pub from: At<String>,
    /// The name there.
    pub ros: At<String>,
    /// The type there.
    pub kind: At<String>,
    /// Which way messages go.
    pub direction: At<Direction>,
    /// The converter, where the types differ.
    pub convert: Option<At<String>>,
}

/// Which way messages go through a bridge.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, Word)]
#[serde(rename_all = "snake_case")]
pub enum Direction {
    /// Out.
    #[default]
    ToRos,
    /// In.
    FromRos,
}

/// A part of a message, as in `pose.position.x`; each step with its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    /// The steps.
    pub steps: Vec<At<String>>,
    /// The place of all of it.
    pub span: Span,
}

impl std::fmt::Display for Path {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let steps: Vec<&str> = self.steps.iter().map(|step| step.value.as_str()).collect();
        f.write_str(&steps.join("."))
    }
}

/// `notify` of a port-proxy: which events it tells, and when.
#[derive(Clone, Debug)]
pub struct Notify {
    /// The place of the table.
    pub span: Span,
    /// The reference it tells them through.
    pub reference: At<String>,
    /// When the event `busy` is told.
    pub busy: Option<At<Busy>>,
    /// When the event `idle` is told.
    pub idle: Option<Idle>,
    /// When the event `refresh` is told.
    pub refresh: Option<Condition>,
    /// When the event `fault` is told.
    pub fault: Option<Condition>,
    /// After how long without data the event `stale` is told.
    pub stale_ms: Option<At<i64>>,
}

/// When the event `busy` is told.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, Word)]
#[serde(rename_all = "snake_case")]
pub enum Busy {
    /// When a command has been accepted and written.
    #[default]
    CommandWritten,
}

/// When an event is told: `jointStatus.new`, `jointStatus.error_flags != 0`.
#[derive(Clone, Debug)]
pub struct Condition {
    /// All of it.
    pub text: At<String>,
    /// `port.field`, which it begins with.
    pub path: Option<Path>,
}

/// The motion has ended: what was measured is near what was commanded, for some time.
#[derive(Clone, Debug)]
pub struct Idle {
    /// How near.
    pub within: At<f64>,
    /// `port.field` of what was commanded.
    pub of: Path,
    /// `port.field` of what is measured.
    pub on: Path,
    /// For how long.
    pub for_ms: Option<At<i64>>,
}

/// A chart of a web-monitor.
#[derive(Clone, Debug)]
pub struct Plot {
    /// Its title.
    pub title: At<String>,
    /// A range of indices, one chart each.
    pub each: Option<At<String>>,
    /// The fields drawn.
    pub series: Vec<At<String>>,
    /// A field whose bits are shown as flags.
    pub flags: Option<At<String>>,
    /// How much of the past is drawn.
    pub window_s: Option<At<i64>>,
}
