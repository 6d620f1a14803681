//! A component of a plan.

use crate::plan::{Lifecycle, Pace, PropertyValues};
use asmotion_composite::model::{
    BuiltinComponent, PlannedNotify, PlannedPlot, PlannedProxyEntry, PlannedRosEntry, PlannedVerify,
};
use asmotion_coordinator::Binding;

/// A component.
#[derive(Clone, Debug, PartialEq)]
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
    pub inputs: Vec<Port>,
    /// Output ports.
    pub outputs: Vec<Port>,
    /// Services.
    pub services: Vec<Service>,
    /// References.
    pub references: Vec<Service>,
    /// Properties that are set.
    pub properties: PropertyValues,
    /// `bind`, of an ASM.
    pub binding: Option<Binding>,
    /// `verify`, of an ASM.
    pub verify: Option<PlannedVerify>,
    /// `map` of a port-proxy.
    pub proxy: Vec<PlannedProxyEntry>,
    /// `notify` of a port-proxy.
    pub notify: Option<PlannedNotify>,
    /// Both as the bridge executes them.
    pub bridge: Option<asmotion_bridge::ProxySettings>,
    /// `map` of a ros-bridge.
    pub ros: Vec<PlannedRosEntry>,
    /// `plots` of a web-monitor.
    pub plots: Vec<PlannedPlot>,
}

/// What a component is made of.
#[derive(Clone, Debug, PartialEq)]
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
#[derive(Clone, Debug, PartialEq)]
pub struct Asm {
    /// Its path, as the loader resolved it.
    pub path: String,
    /// Its main rule, where the composite names it.
    pub main: Option<String>,
}

/// A component of the engine.
#[derive(Clone, Debug, PartialEq)]
pub struct BuiltinSettings {
    /// Which one.
    pub kind: BuiltinComponent,
    /// The component whose ports it offers.
    pub target: Option<String>,
    /// The bridge it uses.
    pub bridge: Option<String>,
    /// The TCP port.
    pub port: Option<u64>,
}

/// A port.
#[derive(Clone, Debug, PartialEq)]
pub struct Port {
    /// Its name.
    pub name: String,
    /// The type of its messages.
    pub kind: String,
    /// The topic it is on.
    pub topic: Option<String>,
}

/// A service or a reference.
#[derive(Clone, Debug, PartialEq)]
pub struct Service {
    /// Its name.
    pub name: String,
    /// Its interface.
    pub interface: String,
}
