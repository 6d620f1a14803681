//! A composite in one profile, flattened: nested composites opened, promotions and renames
//! applied, substitutions made, defaults filled in. Plain data, in the order of the files.

mod flatten;
mod graph;
mod order;
mod part;
mod place;

use serde::{Serialize, Serializer};

use crate::binding::Binding;
use crate::model::{
    BridgeKind, Builtin, Cancel, Codec, Delivery, Direction, Flow, Lock, OnDeadline, OnException,
    OnStale, Overrun, ProxyMode, RestartPolicy, Scheduler, Sharing, Tls, Transport,
};
use crate::value::{REDACTED, Value};

pub(crate) use flatten::{Parts, flatten};
pub use graph::Link;

/// A composite in one profile, ready to be started.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Plan {
    /// The name of the composite.
    pub name: String,
    /// Its version.
    pub version: Option<String>,
    /// The profile; absent where the composite has none.
    pub profile: Option<String>,
    /// Environment variables that must be set before this can be started.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub missing: Vec<String>,
    /// The names of the components, providers before their callers, writers before their readers.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub start_order: Vec<String>,
    /// The properties of the outermost composite.
    #[serde(skip_serializing_if = "Settings::is_empty")]
    pub properties: Settings,
    /// Brokers.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub brokers: Vec<Broker>,
    /// Bridges.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub bridges: Vec<Bridge>,
    /// Components, in the order of the files.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub components: Vec<Component>,
    /// Topics, by name.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub topics: Vec<Topic>,
    /// Connections, one for each pair of ends.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub connections: Vec<Connection>,
    /// Wires.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub wires: Vec<Wire>,
    /// What the outside sees.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub promoted: Vec<Promoted>,
    /// Processes; one that has everything where the composite says nothing.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub processes: Vec<Process>,
    /// When a process is started again.
    pub restart: Option<Restart>,
    /// What is written down.
    pub record: Option<Record>,
}

/// Names and values, in the order they were declared or set.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Settings(pub Vec<(String, Value)>);

/// The end of a connection or wire; shown as `Component.name`.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct End {
    /// The component.
    pub component: String,
    /// Its port, service or reference.
    pub name: String,
}

/// One end of a connection; shown as `Component.port` or `topic:name`.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Terminal {
    /// A port.
    Port(End),
    /// A topic.
    Topic(String),
}

/// An address with its secrets; shows itself without them.
#[derive(Clone, PartialEq, Eq)]
pub struct Endpoint {
    full: String,
    shown: String,
}

/// A message broker.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Broker {
    /// Its name.
    pub name: String,
    /// Where it is; absent where a variable is missing.
    pub url: Option<Endpoint>,
    /// The topic exchange.
    pub exchange: String,
    /// How payloads are encoded.
    pub codec: Codec,
    /// Whether the line is encrypted.
    pub tls: Tls,
    /// First wait before a lost connection is taken up again.
    pub reconnect_first_ms: u64,
    /// Longest wait.
    pub reconnect_max_ms: u64,
    /// Share of the wait that is random.
    pub reconnect_jitter: f64,
}

/// A way to another middleware.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Bridge {
    /// Its name.
    pub name: String,
    /// Which middleware.
    pub kind: BridgeKind,
    /// Where roscore or the rosbridge server is.
    pub url: Option<Endpoint>,
    /// The domain of ROS 2.
    pub domain: Option<u64>,
    /// The name under which we appear there.
    pub node: Option<String>,
}

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
    /// The scheduling class of its thread.
    pub scheduler: Scheduler,
    /// The priority in that class.
    pub priority: Option<u64>,
    /// The processors it may run on.
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

/// A topic.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Topic {
    /// Its name.
    pub name: String,
    /// The type of its messages, if anybody says.
    #[serde(rename = "type")]
    pub kind: Option<String>,
    /// Whether the outside may publish and subscribe it.
    pub promoted: bool,
    /// The ports that publish it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub publishers: Vec<End>,
    /// The ports that subscribe it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub subscribers: Vec<End>,
}

/// A connection.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Connection {
    /// Who writes.
    pub from: Terminal,
    /// Who reads.
    pub to: Terminal,
    /// How.
    pub policy: Policy,
}

/// How a connection carries messages.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Policy {
    /// Last value or queue.
    #[serde(rename = "type")]
    pub kind: Flow,
    /// Length of the queue; 1 for the last value.
    pub size: u64,
    /// How writers and readers are kept apart.
    pub lock: Lock,
    /// Whether a new reader gets the last value written before.
    pub init: bool,
    /// Whether data stays with the writer until asked for.
    pub pull: bool,
    /// Whether a write that does not get through is an error of the writer.
    pub mandatory: bool,
    /// Who shares the queue.
    pub buffer: Sharing,
    /// How many threads may use it.
    pub max_threads: u64,
    /// How old data may be.
    pub max_age_ms: Option<u64>,
    /// What a reader sees instead of data that is too old.
    pub on_stale: OnStale,
    /// Whether new data wakes the reader.
    pub delivery: Delivery,
    /// How often a polling reader looks.
    pub poll_ms: Option<u64>,
}

/// A wire.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Wire {
    /// Who calls.
    pub reference: End,
    /// Who answers.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub services: Vec<End>,
    /// The interface of both.
    pub interface: String,
    /// Over what.
    pub binding: Transport,
    /// Over which broker.
    pub broker: Option<String>,
    /// How long the caller waits.
    pub timeout_ms: u64,
    /// How often a call is tried again.
    pub retry_attempts: u64,
    /// How long to wait in between.
    pub retry_backoff_ms: u64,
    /// Whether a call that came too late is withdrawn.
    pub cancel: Cancel,
    /// Whether nobody waits for a reply.
    pub oneway: bool,
}

/// Something that the outside sees.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Promoted {
    /// `service`, `reference`, `property`, `port` or `topic`.
    pub what: &'static str,
    /// Its name outside.
    pub name: String,
    /// What it is inside: `Component.name`, or a topic.
    pub inside: String,
    /// Over what the outside reaches it.
    pub binding: Transport,
    /// Over which broker.
    pub broker: Option<String>,
}

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
    /// The scheduling class of its threads.
    pub scheduler: Scheduler,
    /// The priority in that class.
    pub priority: Option<u64>,
    /// The processors it may run on.
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
    /// The plan as TOML: the composite with everything filled in, secrets left out.
    ///
    /// # Errors
    /// A value that TOML cannot write.
    pub fn to_toml(&self) -> Result<String, toml::ser::Error> {
        toml::to_string(self)
    }

    /// The component of this name.
    pub fn component(&self, name: &str) -> Option<&Component> {
        self.components.iter().find(|component| component.name == name)
    }
}

impl Settings {
    fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The value of a property.
    pub fn get(&self, name: &str) -> Option<&Value> {
        self.0.iter().find(|(known, _)| known == name).map(|(_, value)| value)
    }
}

impl Endpoint {
    /// An address and how it is shown.
    pub fn new(full: impl Into<String>, shown: impl Into<String>) -> Self {
        let shown = mask(&shown.into());
        Self { full: full.into(), shown }
    }

    /// The address with its secrets; not for logs.
    pub fn reveal(&self) -> &str {
        &self.full
    }

    /// The address without its secrets.
    pub fn shown(&self) -> &str {
        &self.shown
    }
}

/// Blots out the password of `scheme://user:password@host`.
fn mask(url: &str) -> String {
    match password(url) {
        Some(range) => format!("{}{REDACTED}{}", &url[..range.start], &url[range.end..]),
        None => url.to_owned(),
    }
}

/// Where the password of an address stands.
pub(crate) fn password(url: &str) -> Option<std::ops::Range<usize>> {
    let start = url.find("://")? + 3;
    // up to the last `@`, since a password may be written with a `/` that should be escaped
    let at = start + url[start..].rfind('@')?;
    let colon = start + url[start..at].find(':')?;
    Some(colon + 1..at)
}

impl std::fmt::Debug for Endpoint {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.shown)
    }
}

impl Serialize for Endpoint {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&self.shown)
    }
}

impl Serialize for Settings {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(name, value)| (name, value)))
    }
}

impl std::fmt::Display for End {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}.{}", self.component, self.name)
    }
}

impl Serialize for End {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl std::fmt::Display for Terminal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Port(end) => end.fmt(f),
            Self::Topic(topic) => write!(f, "topic:{topic}"),
        }
    }
}

impl Serialize for Terminal {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

#[cfg(test)]
mod tests {
    use super::Endpoint;

    #[test]
    fn it_never_shows_a_password() {
        let endpoint = Endpoint::new("amqp://guest:geheim@host:5672/%2f", "amqp://guest:geheim@host:5672/%2f");
        assert_eq!(format!("{endpoint:?}"), "amqp://guest:***@host:5672/%2f");
        assert_eq!(endpoint.reveal(), "amqp://guest:geheim@host:5672/%2f");
    }

    #[test]
    fn it_shows_an_address_without_a_password_as_it_is() {
        assert_eq!(Endpoint::new("http://a:80/x", "http://a:80/x").shown(), "http://a:80/x");
    }
}
