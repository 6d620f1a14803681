//! Components of a plan.

use crate::plan::{Lifecycle, Pace, PropertyValues};
use asmotion_composite::model::{
    BuiltinComponent, PlannedNotify, PlannedPlot, PlannedProxyEntry, PlannedRosEntry, PlannedVerify,
};
use asmotion_coordinator::Binding;

/// A component of a plan.
#[derive(Clone, Debug, PartialEq)]
pub struct Component {
    /// Name qualified by the enclosing composites, such as `Driver/youBotDriver`.
    pub name: String,
    /// Identifier used for queues, logs and metrics.
    pub id: String,
    /// Implementation to run.
    pub implementation: Implementation,
    /// Schedule of its cycles.
    pub pace: Pace,
    /// Automatic lifecycle transitions.
    pub lifecycle: Lifecycle,
    /// Input ports in declaration order.
    pub inputs: Vec<Port>,
    /// Output ports in declaration order.
    pub outputs: Vec<Port>,
    /// Provided services.
    pub services: Vec<Service>,
    /// Required references.
    pub references: Vec<Service>,
    /// Property values set by the composite.
    pub properties: PropertyValues,
    /// `bind` of an ASM component; `None` for other implementations.
    pub binding: Option<Binding>,
    /// `verify` of an ASM component.
    pub verify: Option<PlannedVerify>,
    /// `map` of a port-proxy; empty for other components.
    pub proxy: Vec<PlannedProxyEntry>,
    /// `notify` of a port-proxy.
    pub notify: Option<PlannedNotify>,
    /// `map` and `notify` compiled for the bridge; `None` for components other than port-proxies.
    pub bridge: Option<asmotion_bridge::ProxySettings>,
    /// `map` of a ros-bridge.
    pub ros: Vec<PlannedRosEntry>,
    /// `plots` of a web-monitor.
    pub plots: Vec<PlannedPlot>,
}

/// Implementation of a component.
#[derive(Clone, Debug, PartialEq)]
pub enum Implementation {
    /// Name in the catalogue.
    Rust(String),
    /// An ASM specification.
    Asm(Asm),
    /// A built-in component.
    Builtin(BuiltinSettings),
    /// Command line of an external program.
    Process(Vec<String>),
    /// Package and executable of a ROS node.
    Ros(Vec<String>),
    /// Component name in a running Orocos system and address of the name service.
    Orocos(Vec<String>),
}

/// An ASM specification.
#[derive(Clone, Debug, PartialEq)]
pub struct Asm {
    /// Resolved path of the file.
    pub path: String,
    /// Main rule; `None` if the composite does not name it.
    pub main: Option<String>,
}

/// Settings of a built-in component.
#[derive(Clone, Debug, PartialEq)]
pub struct BuiltinSettings {
    /// Kind of built-in component.
    pub kind: BuiltinComponent,
    /// `port-proxy`: component whose ports are accessed.
    pub target: Option<String>,
    /// `ros-bridge`: name of the bridge.
    pub bridge: Option<String>,
    /// `web-monitor`, `http-gateway`: TCP port.
    pub port: Option<u64>,
}

/// A port of a component.
#[derive(Clone, Debug, PartialEq)]
pub struct Port {
    /// Name in the component.
    pub name: String,
    /// Message type name; empty if unknown.
    pub kind: String,
    /// Topic of the port; `None` if it is only connected directly.
    pub topic: Option<String>,
}

/// A service or a reference.
#[derive(Clone, Debug, PartialEq)]
pub struct Service {
    /// Name in the component.
    pub name: String,
    /// Interface name.
    pub interface: String,
}
