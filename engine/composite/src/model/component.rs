//! Components as written in the composite.

use std::sync::Arc;

use asmotion_derive::{Table, Word};
use asmotion_diagnostics::Span;

use super::binding::Bind;
use super::implementation::Implementation;
use super::instances::Instances;
use super::limits::DAY_MS;
use super::pace::{Lifecycle, Pace};
use super::setting::Setting;
use super::wiring::End;
use crate::at::At;
use crate::table::NamedValue;

/// A component of the composite.
#[derive(Clone, Debug, Table)]
#[table(
    of = "a component",
    example = "{ implementation = { rust = \"nav::MapServer\" } }",
    after = super::component_reader::belongs
)]
pub struct Component {
    /// Name of the component, unique in the composite.
    #[key(entry = thing)]
    pub name: At<String>,
    /// Instances: one component for each value of a variable, which is substituted in its names and strings. A string that is
    /// only the variable becomes its value. The components have the name with `$r`, or with the value at its end.
    #[key(name = "for", example = "\"$r in 1..20\"")]
    pub instances: Option<Instances>,
    /// Program, specification or composite that implements the component.
    #[key(needed, example = "{ rust = \"nav::MapServer\" }")]
    pub implementation: Option<Implementation>,
    /// Profiles that include it; all if empty.
    #[key(name = "profile", example = "\"sim\"")]
    pub profiles: Vec<At<String>>,
    /// Description.
    #[key(example = "\"Plans paths on a grid\"")]
    pub doc: Option<At<String>>,
    /// Schedule of a component reachable over a broker.
    #[key(example = "{ period_ms = 50 }")]
    pub task: Option<Pace>,
    /// Schedule of a component in a thread with a scheduling class.
    #[key(example = "{ period_ms = 50 }")]
    pub activity: Option<Pace>,
    /// Automatic lifecycle transitions.
    #[key(example = "{ autostart = true }")]
    pub lifecycle: Option<Lifecycle>,
    /// Ports used by connections.
    #[key(or_default, example = "{ in = { }, out = { } }")]
    pub ports: Ports,
    /// Input ports on the topic of the same name.
    #[key(example = "{ scan = \"sensor_msgs/LaserScan\" }")]
    pub subscribe: Vec<Listed>,
    /// Output ports on the topic of the same name.
    #[key(example = "{ scan = \"sensor_msgs/LaserScan\" }")]
    pub publish: Vec<Listed>,
    /// Maps port names to other topics (TCA's topicRename).
    #[key(example = "{ trajectory = \"plan\" }")]
    pub rename: Vec<Rename>,
    /// Services it provides, with their interfaces.
    #[key(example = "{ maps = \"nav/MapService\" }")]
    pub services: Vec<Listed>,
    /// References it needs, with their interfaces.
    #[key(example = "{ maps = \"nav/MapService\" }")]
    pub references: Vec<Wanted>,
    /// Operations of its services, with their signatures: the types of the request's fields, and of the response.
    #[key(example = "{ setPeriod = \"fn(f64) -> bool\" }")]
    pub operations: Vec<Listed>,
    /// File with property values; `properties` takes precedence.
    #[key(example = "\"site.toml\"")]
    pub load: Option<At<String>>,
    /// Property values.
    #[key(example = "{ inflation_m = 0.35 }")]
    pub properties: Vec<Setting>,
    /// Bindings of the functions of an ASM to ports and services.
    #[key(or_default, example = "{ monitored = { }, out = { } }")]
    pub bind: Arc<Bind>,
    /// Keys that only one kind of implementation has.
    #[key(flatten)]
    pub special: SpecialKeys,
}

impl Component {
    /// Returns `task` or `activity`, whichever is given.
    pub fn pace(&self) -> Option<&Pace> {
        self.task.as_ref().or(self.activity.as_ref())
    }
}

/// Keys of a component that only one kind of implementation has.
#[derive(Clone, Debug, Table)]
#[table(of = "a component", resolved = PlannedSpecialKeys)]
pub struct SpecialKeys {
    /// Properties of an ASM verified before it starts, with what the other components send it.
    #[key(example = "{ ctl = true }")]
    pub verify: Option<Verify>,
    /// Properties of an ASM watched while it runs, and the reaction to a violation.
    #[key(example = "{ safe_rule = \"r_halt[IDLE]\" }")]
    pub watch: Option<Watch>,
    /// Specification of what the component sends, depending on what it receives, for the verification of others. `check`
    /// compares its functions with the ports and operations of the component (`C160`), and their values with those that the ports
    /// carry (`C161`).
    #[key(example = "\"gripper.asm\"")]
    pub protocol: Option<At<String>>,
    /// `port-proxy`: mapping of operations to ports. `ros-bridge`: mapping of topics to topics of ROS, and of operations to
    /// services and actions of ROS.
    #[key(
        example = "[{ operation = \"sending.set\", port = \"Driver.commands\", mode = \"oneway\" }]"
    )]
    pub map: Vec<MapEntry>,
    /// `port-proxy`: conditions of the events it sends.
    #[key(example = "{ reference = \"notifying\", stale_ms = 1000 }")]
    pub notify: Option<Notify>,
    /// `port-proxy`: lists of commands that must have as many elements as a list of the target's state. Lists of
    /// floating-point numbers with the same path in both are found.
    #[key(example = "[{ of = \"commands.position\", on = \"jointStatus.position\" }]")]
    pub lengths: Vec<ListLength>,
    /// `ros-bridge`: components whose properties are parameters of ROS, or single properties as `Component.property`. The value is
    /// the name in ROS. ROS 1: of the parameter, or of the one that contains those of the component. ROS 2: of the node with the
    /// parameters of the component.
    #[key(
        example = "{ Follower = \"follower\", \"Driver.max_speed\" = \"/move_base/max_vel_x\" }"
    )]
    pub parameters: Vec<NamedValue<At<String>>>,
    /// `ros-bridge`, ROS 2: components whose life cycle is that of a managed node, with the names of the nodes.
    #[key(example = "{ Follower = \"follower\" }")]
    pub managed: Vec<NamedValue<At<String>>>,
    /// `web-monitor`: charts of the dashboard.
    #[key(example = "[{ title = \"Speed\", series = [\"velocity\"] }]")]
    pub plots: Vec<Plot>,
}

/// Ports used by connections.
#[derive(Clone, Debug, Default, Table)]
#[table(of = "`ports`", example = "{ in = { }, out = { } }")]
pub struct Ports {
    /// Input ports with their message types.
    #[key(name = "in", example = "{ scan = \"sensor_msgs/LaserScan\" }")]
    pub inputs: Vec<Listed>,
    /// Output ports with their message types.
    #[key(name = "out", example = "{ scan = \"sensor_msgs/LaserScan\" }")]
    pub outputs: Vec<Listed>,
}

/// A name and its type or interface, as in `scan = "sensor_msgs/LaserScan"`.
#[derive(Clone, Debug, PartialEq)]
pub struct Listed {
    /// Port, service or operation name.
    pub name: At<String>,
    /// Message type, interface or signature.
    pub kind: At<String>,
}

/// A reference, or its interface only.
#[derive(Clone, Debug, PartialEq, Table)]
#[table(
    of = "a reference",
    short = "interface",
    example = "\"nav/MapService\""
)]
pub struct Wanted {
    /// Name of the reference, unique in the component.
    #[key(entry = thing)]
    pub name: At<String>,
    /// Required interface.
    #[key(example = "\"nav/MapService\"")]
    pub interface: At<String>,
    /// Whether the reference may remain unconnected.
    pub optional: bool,
}

/// An entry of `rename`, as in `rename = { trajectory = "plan" }`.
#[derive(Clone, Debug)]
pub struct Rename {
    /// Port name in the component.
    pub from: At<String>,
    /// Topic name in the composite.
    pub to: At<String>,
}

/// Properties of an ASM verified before it starts.
#[derive(Clone, Debug, Table)]
#[table(of = "`verify`", example = "{ ctl = true }", resolved = PlannedVerify)]
pub struct Verify {
    /// Verify the CTL properties of the specification.
    #[key(default)]
    pub ctl: Option<At<bool>>,
    /// Verify the LTL properties of the specification.
    #[key(default)]
    pub ltl: Option<At<bool>>,
    /// Verify the invariants of the specification.
    #[key(default)]
    pub invariants: Option<At<bool>>,
    /// Refuse to start the composite if a property is violated, or not known to hold within the limits below. Otherwise
    /// the start is preceded by a warning.
    #[key(default)]
    pub refuse_start_on_failure: Option<At<bool>>,
    /// Largest number of steps from the initial state; unlimited by default.
    #[key(range = 1..=1_000_000)]
    pub bound: Option<At<u64>>,
    /// Largest number of states; unlimited by default.
    #[key(range = 1..=1_000_000_000)]
    pub states: Option<At<u64>>,
    /// Longest time of the verification.
    #[key(unit = "seconds", range = 0.001..=86_400.0, default = Verify::TIME_S)]
    pub time_s: Option<At<f64>>,
}

impl Verify {
    /// Default of `time_s` in seconds.
    pub(crate) const TIME_S: f64 = 60.0;
}

/// Properties of an ASM watched while it runs.
#[derive(Clone, Debug, Table)]
#[table(
    of = "`watch`",
    example = "{ safe_rule = \"r_halt[IDLE]\" }",
    resolved = PlannedWatch
)]
pub struct Watch {
    /// Watch temporal properties: those of the specification, and `properties`. Invariants are always checked.
    #[key(default = true)]
    pub temporal: Option<At<bool>>,
    /// Rule of the specification that makes a step in place of the main rule, if the step would violate a property.
    #[key(example = "\"r_halt[IDLE]\"")]
    pub safe_rule: Option<At<String>>,
    /// Properties in addition to those of the specification.
    #[key(example = "[{ property = \"ag(asked implies af(answered))\", within_ms = 2000 }]")]
    pub properties: Vec<StatedProperty>,
}

/// A property that a composite states.
#[derive(Clone, Debug, Table)]
#[table(
    of = "a property",
    example = "{ property = \"ag(asked implies af(answered))\", within_ms = 2000 }",
    resolved = PlannedStatedProperty
)]
pub struct StatedProperty {
    /// Formula of CTL or LTL, or a condition of every state, as a term of the specification.
    #[key(needed, example = "\"ag(asked implies af(answered))\"")]
    pub property: At<String>,
    /// Time within which what has to happen eventually has to happen.
    #[key(unit = "milliseconds", range = 1..=DAY_MS)]
    pub within_ms: Option<At<u64>>,
}

/// An entry of `map`.
#[derive(Clone, Debug, Table)]
#[table(
    of = "an entry of `map`",
    example = "{ operation = \"sending.set\", port = \"Driver.commands\", mode = \"oneway\" }",
    reason = "an entry maps either an operation or a topic",
    resolved = PlannedMapEntry
)]
#[expect(
    clippy::large_enum_variant,
    reason = "a composite has few entries, and most of them are of this variant"
)]
pub enum MapEntry {
    /// Mapping of a port-proxy.
    #[key(flatten)]
    Proxy(ProxyEntry),
    /// Mapping of a ros-bridge.
    #[key(flatten)]
    Ros(RosEntry),
}

/// Mapping of a service operation to a port.
#[derive(Clone, Debug, Table)]
#[table(of = "an entry of `map`", resolved = PlannedProxyEntry)]
pub struct ProxyEntry {
    /// Source location of the entry.
    pub span: Span,
    /// `service.operation` of the proxy; the `component` of the end is the service.
    #[key(example = "\"sending.set\"")]
    pub operation: End,
    /// Port of the target; mirrored by a port of the same name in the proxy.
    #[key(example = "\"Driver.commands\"")]
    pub port: End,
    /// Access of the operation to the port.
    #[key(example = "\"oneway\"")]
    pub mode: At<ProxyMode>,
    /// Message field holding the argument or result; the whole message by default.
    #[key(example = "\"position\"")]
    pub field: Option<MessagePath>,
}

/// Access of an operation to a port.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Word)]
pub enum ProxyMode {
    /// Write a message.
    #[default]
    Oneway,
    /// Write a message and reply once the target has read it.
    Taken,
    /// Write a message and reply once the motion has ended.
    Done,
    /// Read the last message.
    Last,
    /// Read all messages since the previous call.
    All,
}

/// Mapping of a topic to a topic of ROS, or of an operation to a service or an action of ROS.
#[derive(Clone, Debug, Table)]
#[table(of = "an entry of `map`", resolved = PlannedRosEntry)]
pub struct RosEntry {
    /// Source location of the entry.
    pub span: Span,
    /// Port of the bridge; or `service.operation`, which ROS carries out, or `reference.operation`, which ROS can call.
    #[key(example = "\"plan\"")]
    pub from: At<String>,
    /// Name of the topic, service or action in ROS.
    #[key(example = "\"/plan\"")]
    pub ros: At<String>,
    /// Type of the messages, the service or the action in ROS.
    #[key(name = "type", example = "\"nav_msgs/Path\"")]
    pub kind: At<String>,
    /// Direction of the messages or requests.
    #[key(example = "\"to_ros\"")]
    pub direction: At<Direction>,
    /// Actions: port with the feedback, an output of the bridge (`to_ros`) or an input (`from_ros`).
    #[key(example = "\"progress\"")]
    pub feedback: Option<At<String>>,
    /// Actions `to_ros`: output of the bridge with the results of goals that end without success.
    #[key(example = "\"failure\"")]
    pub result: Option<At<String>>,
    /// Actions `to_ros`: `service.operation` that cancels the goals of all callers.
    #[key(example = "\"moving.cancel\"")]
    pub cancel: Option<At<String>>,
    /// Quality of service in ROS.
    #[key(example = "{ depth = 1, durability = \"transient_local\" }")]
    pub qos: Option<RosQos>,
    /// Topics: for each field that differs, what it is here and in ROS: units, as in `rad = deg`, or the values of an
    /// enumeration, as in `IDLE = 0, MOVING = 1`.
    #[key(example = "{ angle = \"rad = deg\" }")]
    pub convert: Vec<NamedValue<At<String>>>,
    /// Topics: transform stamped messages into another frame, by the transforms of `/tf` and `/tf_static` in ROS.
    #[key(example = "{ frame = \"map\" }")]
    pub transform: Option<FrameTransform>,
}

/// Transformation of stamped messages into another frame.
#[derive(Clone, Debug, Table)]
#[table(of = "`transform`", example = "{ frame = \"map\" }", resolved = PlannedFrameTransform)]
pub struct FrameTransform {
    /// Frame of the messages that are passed on.
    #[key(example = "\"map\"")]
    pub frame: At<String>,
    /// Time for which a message waits for the transforms at its stamp; then it is dropped, counted and reported.
    #[key(unit = "milliseconds", range = 0..=60_000, default = 200)]
    pub timeout_ms: Option<At<u64>>,
}

/// Quality of service of a mapped topic, in the terms of ROS 2.
#[derive(Clone, Debug, Table)]
#[table(of = "`qos`", example = "{ depth = 1 }", resolved = PlannedRosQos)]
pub struct RosQos {
    /// Number of messages that wait for a subscriber; then the oldest one is dropped and counted.
    #[key(range = 1..=100_000, default = 10)]
    pub depth: Option<At<u64>>,
    /// Messages for subscribers that join later. In ROS 2, a subscriber that asks for them receives nothing from a publisher
    /// without them.
    #[key(default)]
    pub durability: Option<At<Durability>>,
    /// ROS 2: repetition of lost messages. A `reliable` subscriber receives nothing from a `best_effort` publisher, such as
    /// many drivers of sensors.
    #[key(default)]
    pub reliability: Option<At<RosReliability>>,
    /// ROS 2: longest time between two messages, which is offered to subscribers, or requested from publishers. Nothing is
    /// received from a publisher that offers a longer one, and a gap that is longer is reported.
    #[key(unit = "milliseconds", range = 1..=DAY_MS)]
    pub deadline_ms: Option<At<u64>>,
    /// ROS 2, direction `to_ros`: age at which peers no longer deliver a message.
    #[key(unit = "milliseconds", range = 1..=DAY_MS)]
    pub lifespan_ms: Option<At<u64>>,
}

/// Repetition of lost messages.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Word)]
pub enum RosReliability {
    /// A lost message is sent again.
    #[default]
    Reliable,
    /// A lost message stays lost.
    BestEffort,
}

/// Messages of a topic for subscribers that join later.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Word)]
pub enum Durability {
    /// None.
    #[default]
    Volatile,
    /// The last ones, as many as `depth`; in ROS 1 the last one, which is called latched there.
    TransientLocal,
}

/// Direction of messages through a bridge.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Word)]
pub enum Direction {
    /// From the composite to ROS.
    #[default]
    ToRos,
    /// From ROS to the composite.
    FromRos,
}

/// A field path such as `pose.position.x`; each step has its source location.
#[derive(Clone, Debug, PartialEq)]
pub struct MessagePath {
    /// Field names, outermost first.
    pub steps: Vec<At<String>>,
    /// Source location of the whole path.
    pub span: Span,
}

impl MessagePath {
    /// The path with this text, as if it were written at this place.
    pub(crate) fn at(text: &str, span: Span) -> Self {
        let steps = text.split('.');
        Self {
            steps: steps.map(|step| At::new(step.to_owned(), span)).collect(),
            span,
        }
    }
}

impl std::fmt::Display for MessagePath {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let steps: Vec<&str> = self.steps.iter().map(|step| step.value.as_str()).collect();
        f.write_str(&steps.join("."))
    }
}

/// Events sent by a port-proxy and their conditions.
#[derive(Clone, Debug, Table)]
#[table(
    of = "`notify`",
    example = "{ reference = \"notifying\", stale_ms = 1000 }",
    resolved = PlannedNotify
)]
pub struct Notify {
    /// Source location of the table.
    pub span: Span,
    /// Reference used to send the events.
    #[key(example = "\"notifying\"")]
    pub reference: At<String>,
    /// Condition of the event `busy`.
    pub busy: Option<At<Busy>>,
    /// Condition of the event `idle`.
    #[key(
        example = "{ within = 0.01, of = \"commands.position\", on = \"jointStatus.position\" }"
    )]
    pub idle: Option<Idle>,
    /// Condition of the event `refresh`.
    #[key(example = "\"jointStatus.new\"")]
    pub refresh: Option<Condition>,
    /// Condition of the event `fault`.
    #[key(example = "\"jointStatus.error_flags != 0\"")]
    pub fault: Option<Condition>,
    /// Time without data after which the event `stale` is sent.
    #[key(unit = "milliseconds", range = 1..=DAY_MS)]
    pub stale_ms: Option<At<u64>>,
}

/// Condition of the event `busy`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Word)]
pub enum Busy {
    /// A command has been accepted and written.
    #[default]
    CommandWritten,
}

/// Condition of an event, such as `jointStatus.new` or `jointStatus.error_flags != 0`.
#[derive(Clone, Debug)]
pub struct Condition {
    /// Complete text of the condition.
    pub text: At<String>,
    /// Leading `port.field`; `None` if the text is invalid.
    pub path: Option<MessagePath>,
}

/// Detection of the end of a motion: the measured value stays within a tolerance of the commanded one.
#[derive(Clone, Debug, Table)]
#[table(
    of = "`idle`",
    example = "{ within = 0.01, of = \"commands.position\", on = \"jointStatus.position\" }",
    resolved = PlannedIdle
)]
pub struct Idle {
    /// Tolerance in the unit of the fields.
    #[key(range = 0.0..=1e9, example = "0.01")]
    pub within: At<f64>,
    /// Commanded value: `port.field`.
    #[key(example = "\"commands.position\"")]
    pub of: MessagePath,
    /// Measured value: `port.field`.
    #[key(example = "\"jointStatus.position\"")]
    pub on: MessagePath,
    /// Minimum time within the tolerance.
    #[key(unit = "milliseconds", range = 0..=DAY_MS, default = 0)]
    pub for_ms: Option<At<u64>>,
}

/// A list of a command whose number of elements the target determines, for example one for each joint. A command with another
/// number is refused.
#[derive(Clone, Debug, Table)]
#[table(
    of = "an entry of `lengths`",
    example = "{ of = \"commands.position\", on = \"jointStatus.position\" }",
    resolved = PlannedListLength
)]
pub struct ListLength {
    /// Source location of the entry.
    pub span: Span,
    /// List of a command: `port.field`.
    #[key(example = "\"commands.position\"")]
    pub of: MessagePath,
    /// List of the target's state with as many elements: `port.field`. Without it, a command can have any number of elements.
    #[key(example = "\"jointStatus.position\"")]
    pub on: Option<MessagePath>,
}

/// A chart of a web-monitor.
#[derive(Clone, Debug, Table)]
#[table(
    of = "a plot",
    example = "[{ title = \"Speed\", series = [\"velocity\"] }]",
    resolved = PlannedPlot
)]
pub struct Plot {
    /// Title above the chart.
    #[key(example = "\"Speed\"")]
    pub title: At<String>,
    /// Index range; one chart per index.
    #[key(example = "\"0..5\"")]
    pub each: Option<At<String>>,
    /// Fields drawn as curves.
    #[key(needed, example = "[\"velocity\"]")]
    pub series: Vec<At<String>>,
    /// Field whose bits are shown as flags.
    #[key(example = "\"error_flags\"")]
    pub flags: Option<At<String>>,
    /// Time span of the chart.
    #[key(unit = "seconds", range = 1..=86_400, default = 60)]
    pub window_s: Option<At<u64>>,
}
