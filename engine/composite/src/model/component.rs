//! A component as the composite describes it.

use asmotion_derive::{Table, Word};
use asmotion_diagnostics::Span;

use super::binding::Bind;
use super::{DAY_MS, End, Implementation, Lifecycle, Pace, Setting};
use crate::at::At;

/// A component of the composite.
#[derive(Clone, Debug, Table)]
#[table(
    of = "a component",
    example = "{ implementation = { rust = \"nav::MapServer\" } }",
    after = crate::read::belongs
)]
pub struct Component {
    /// Its name.
    #[key(entry = thing)]
    pub name: At<String>,
    /// What it is made of; absent where that could not be read.
    #[key(needed, example = "{ rust = \"nav::MapServer\" }")]
    pub implementation: Option<Implementation>,
    /// In which profiles; in all, if none is named.
    #[key(name = "profile", example = "\"sim\"")]
    pub profiles: Vec<At<String>>,
    /// What it is for.
    #[key(example = "\"what it is for\"")]
    pub doc: Option<At<String>>,
    /// When it cycles, over a broker.
    #[key(example = "{ period_ms = 50 }")]
    pub task: Option<Pace>,
    /// When it cycles, in a thread with a scheduling class.
    #[key(example = "{ period_ms = 50 }")]
    pub activity: Option<Pace>,
    /// Transitions that nobody has to ask for.
    #[key(example = "{ autostart = true }")]
    pub lifecycle: Option<Lifecycle>,
    /// Ports that connections join.
    #[key(or_default, example = "{ in = { }, out = { } }")]
    pub ports: Ports,
    /// Input ports on the topic of the same name.
    #[key(example = "{ scan = \"sensor_msgs/LaserScan\" }")]
    pub subscribe: Vec<Listed>,
    /// Output ports on the topic of the same name.
    #[key(example = "{ scan = \"sensor_msgs/LaserScan\" }")]
    pub publish: Vec<Listed>,
    /// Other topics for those names (TCA's topicRename).
    #[key(example = "{ trajectory = \"plan\" }")]
    pub rename: Vec<Rename>,
    /// Services it provides, with their interfaces.
    #[key(example = "{ maps = \"nav/MapService\" }")]
    pub services: Vec<Listed>,
    /// References it needs, with their interfaces.
    #[key(example = "{ maps = \"nav/MapService\" }")]
    pub references: Vec<Wanted>,
    /// Operations it offers to anybody, with their signatures.
    #[key(example = "{ setPeriod = \"fn(f64) -> bool\" }")]
    pub operations: Vec<Listed>,
    /// File of properties; what `properties` says holds.
    #[key(example = "\"site.toml\"")]
    pub load: Option<At<String>>,
    /// Properties that are set.
    #[key(example = "{ inflation_m = 0.35 }")]
    pub properties: Vec<Setting>,
    /// Functions of an ASM and the world.
    #[key(or_default, example = "{ monitored = { }, out = { } }")]
    pub bind: Bind,
    /// What must hold of an ASM before it may start.
    #[key(example = "{ ctl = true }")]
    pub verify: Option<Verify>,
    /// `port-proxy`: operations that are ports. `ros-bridge`: topics here that are topics of ROS.
    #[key(
        example = "[{ operation = \"sending.set\", port = \"Driver.commands\", mode = \"oneway\" }]"
    )]
    pub map: Vec<MapEntry>,
    /// `port-proxy`: the events it sends, and when.
    #[key(example = "{ reference = \"notifying\", stale_ms = 1000 }")]
    pub notify: Option<Notify>,
    /// `web-monitor`: its charts.
    #[key(example = "[{ title = \"Speed\", series = [\"velocity\"] }]")]
    pub plots: Vec<Plot>,
}

impl Component {
    /// When it cycles: its `task` or its `activity`.
    pub fn pace(&self) -> Option<&Pace> {
        self.task.as_ref().or(self.activity.as_ref())
    }
}

/// Ports that connections join.
#[derive(Clone, Debug, Default, Table)]
#[table(of = "`ports`", example = "{ in = { }, out = { } }")]
pub struct Ports {
    /// Input ports, with their types.
    #[key(name = "in", example = "{ scan = \"sensor_msgs/LaserScan\" }")]
    pub inputs: Vec<Listed>,
    /// Output ports, with their types.
    #[key(name = "out", example = "{ scan = \"sensor_msgs/LaserScan\" }")]
    pub outputs: Vec<Listed>,
}

/// A name and its type or interface, as in `scan = "sensor_msgs/LaserScan"`.
#[derive(Clone, Debug)]
pub struct Listed {
    /// The name.
    pub name: At<String>,
    /// The type or interface.
    pub kind: At<String>,
}

/// A reference, or its interface alone.
#[derive(Clone, Debug, Table)]
#[table(
    of = "a reference",
    short = "interface",
    example = "\"nav/MapService\""
)]
pub struct Wanted {
    /// Its name.
    #[key(entry = thing)]
    pub name: At<String>,
    /// The interface it needs.
    #[key(example = "\"nav/MapService\"")]
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

/// What must hold of an ASM before it may start.
#[derive(Clone, Debug, Table)]
#[table(of = "`verify`", example = "{ ctl = true }", resolved = PlannedVerify)]
pub struct Verify {
    /// Its CTL properties.
    #[key(default)]
    pub ctl: Option<At<bool>>,
    /// Its LTL properties.
    #[key(default)]
    pub ltl: Option<At<bool>>,
    /// Its invariants.
    #[key(default)]
    pub invariants: Option<At<bool>>,
    /// Whether a failure keeps the composite from starting.
    #[key(default)]
    pub refuse_start_on_failure: Option<At<bool>>,
}

/// An entry of `map`.
#[derive(Clone, Debug, Table)]
#[table(
    of = "an entry of `map`",
    example = "{ operation = \"sending.set\", port = \"Driver.commands\", mode = \"oneway\" }",
    reason = "an entry maps either an operation or a topic"
)]
pub enum MapEntry {
    /// Of a port-proxy.
    #[key(flatten)]
    Proxy(ProxyEntry),
    /// Of a ros-bridge.
    #[key(flatten)]
    Ros(RosEntry),
}

/// A service operation that is a port.
#[derive(Clone, Debug, Table)]
#[table(of = "an entry of `map`", resolved = PlannedProxyEntry)]
pub struct ProxyEntry {
    /// The place of the entry.
    pub span: Span,
    /// `service.operation` of the proxy; the `component` of the end is the service.
    #[key(example = "\"sending.set\"")]
    pub operation: End,
    /// Port of the target; the proxy has one of the same name.
    #[key(example = "\"Driver.commands\"")]
    pub port: End,
    /// How the operation uses the port.
    #[key(example = "\"oneway\"")]
    pub mode: At<ProxyMode>,
    /// The part of the message that is argument or result.
    #[key(example = "\"position\"")]
    pub field: Option<MessagePath>,
}

/// How an operation uses a port.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Word)]
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
#[derive(Clone, Debug, Table)]
#[table(of = "an entry of `map`", resolved = PlannedRosEntry)]
pub struct RosEntry {
    /// The place of the entry.
    pub span: Span,
    /// The name here, a port of the bridge.
    #[key(example = "\"plan\"")]
    pub from: At<String>,
    /// The name there.
    #[key(example = "\"/plan\"")]
    pub ros: At<String>,
    /// The type there.
    #[key(name = "type", example = "\"nav_msgs/Path\"")]
    pub kind: At<String>,
    /// Which way messages go.
    #[key(example = "\"to_ros\"")]
    pub direction: At<Direction>,
    /// The converter, where the types differ.
    #[key(example = "\"event_from_string\"")]
    pub convert: Option<At<String>>,
}

/// Which way messages go through a bridge.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Word)]
pub enum Direction {
    /// Out.
    #[default]
    ToRos,
    /// In.
    FromRos,
}

/// A part of a message, as in `pose.position.x`; each step with its place.
#[derive(Clone, Debug, PartialEq)]
pub struct MessagePath {
    /// The steps.
    pub steps: Vec<At<String>>,
    /// The place of all of it.
    pub span: Span,
}

impl std::fmt::Display for MessagePath {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let steps: Vec<&str> = self.steps.iter().map(|step| step.value.as_str()).collect();
        f.write_str(&steps.join("."))
    }
}

/// Events that a port-proxy sends, and when.
#[derive(Clone, Debug, Table)]
#[table(
    of = "`notify`",
    example = "{ reference = \"notifying\", stale_ms = 1000 }",
    resolved = PlannedNotify
)]
pub struct Notify {
    /// The place of the table.
    pub span: Span,
    /// Reference that it sends them through.
    #[key(example = "\"notifying\"")]
    pub reference: At<String>,
    /// When the event `busy` is sent.
    pub busy: Option<At<Busy>>,
    /// When the event `idle` is sent.
    #[key(
        example = "{ within = 0.01, of = \"commands.position\", on = \"jointStatus.position\" }"
    )]
    pub idle: Option<Idle>,
    /// When the event `refresh` is sent.
    #[key(example = "\"jointStatus.new\"")]
    pub refresh: Option<Condition>,
    /// When the event `fault` is sent.
    #[key(example = "\"jointStatus.error_flags != 0\"")]
    pub fault: Option<Condition>,
    /// After how long without data the event `stale` is sent.
    #[key(unit = "milliseconds", range = 1..=DAY_MS)]
    pub stale_ms: Option<At<u64>>,
}

/// When the event `busy` is told.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Word)]
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
    pub path: Option<MessagePath>,
}

/// The motion has ended: what was measured is near what was commanded, for some time.
#[derive(Clone, Debug, Table)]
#[table(
    of = "`idle`",
    example = "{ within = 0.01, of = \"commands.position\", on = \"jointStatus.position\" }",
    resolved = PlannedIdle
)]
pub struct Idle {
    /// How near, in the unit of the fields.
    #[key(range = 0.0..=1e9, example = "0.01")]
    pub within: At<f64>,
    /// `port.field` of what was commanded.
    #[key(example = "\"commands.position\"")]
    pub of: MessagePath,
    /// `port.field` of what is measured.
    #[key(example = "\"jointStatus.position\"")]
    pub on: MessagePath,
    /// For how long.
    #[key(unit = "milliseconds", range = 0..=DAY_MS, default = 0)]
    pub for_ms: Option<At<u64>>,
}

/// A chart of a web-monitor.
#[derive(Clone, Debug, Table)]
#[table(
    of = "a plot",
    example = "[{ title = \"Speed\", series = [\"velocity\"] }]",
    resolved = PlannedPlot
)]
pub struct Plot {
    /// Its title.
    #[key(example = "\"Speed\"")]
    pub title: At<String>,
    /// A range of indices, one chart each.
    #[key(example = "\"0..5\"")]
    pub each: Option<At<String>>,
    /// The fields drawn.
    #[key(needed, example = "[\"velocity\"]")]
    pub series: Vec<At<String>>,
    /// A field whose bits are shown as flags.
    #[key(example = "\"error_flags\"")]
    pub flags: Option<At<String>>,
    /// How much of the past is drawn.
    #[key(unit = "seconds", range = 1..=86_400, default = 60)]
    pub window_s: Option<At<u64>>,
}
