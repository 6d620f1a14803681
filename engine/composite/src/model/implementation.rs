//! Implementations of components.

use asmotion_datum::Word as _;
use asmotion_derive::{Table, Word};
use asmotion_diagnostics::Span;

use crate::at::At;

/// Implementation of a component, exactly one of these.
#[derive(Clone, Debug, Table)]
#[table(
    of = "an implementation",
    example = "{ rust = \"nav::MapServer\" }",
    reason = "a component has one implementation",
    resolved = PlannedImplementation
)]
pub enum Implementation {
    /// Component linked into the executable, by its name in the catalogue.
    #[key(example = "\"nav::MapServer\"")]
    Rust(At<String>),
    /// An ASM specification.
    Asm {
        /// File of an ASM specification.
        #[key(name = "asm", example = "\"guard.asm\"")]
        file: At<String>,
        /// Main rule; verified against the specification if given.
        #[key(example = "\"r_Main\"")]
        main: Option<At<String>>,
    },
    /// File of a nested composite.
    #[key(example = "\"driver.composite.toml\"", written)]
    Composite(At<String>),
    /// Component provided by the engine.
    Builtin {
        /// Component provided by the engine.
        #[key(name = "builtin", example = "\"port-proxy\"")]
        name: At<String>,
        /// `port-proxy`: component whose ports are accessed through services.
        #[key(example = "\"youBotDriver\"", local)]
        target: Option<At<String>>,
        /// `ros-bridge`: name of the bridge.
        #[key(example = "\"ros\"", local)]
        bridge: Option<At<String>>,
        /// `web-monitor`, `http-gateway`: TCP port.
        #[key(range = 0..=65_535)]
        port: Option<At<u64>>,
    },
    /// External program.
    Process {
        /// Command of an external program.
        #[key(name = "process", example = "\"./driver\"")]
        command: At<String>,
        /// Command-line arguments.
        #[key(example = "[\"--verbose\"]")]
        arguments: Vec<At<String>>,
    },
    /// ROS node.
    Ros {
        /// Package of a ROS node.
        #[key(name = "ros", example = "\"demo_nodes_cpp\"")]
        package: At<String>,
        /// Executable within the package.
        #[key(example = "\"talker\"")]
        executable: Option<At<String>>,
    },
    /// Component of a running Orocos system.
    Orocos {
        /// Component name in a running Orocos system.
        #[key(name = "orocos", example = "\"Driver\"")]
        component: At<String>,
        /// Address of the CORBA name service.
        #[key(example = "\"corbaloc::127.0.0.1:2809\"")]
        name_service: Option<At<String>>,
    },
}

impl Implementation {
    /// Returns the source location.
    pub fn span(&self) -> Span {
        match self {
            Self::Rust(name) | Self::Composite(name) => name.span,
            Self::Asm { file, .. } => file.span,
            Self::Builtin { name, .. } => name.span,
            Self::Process { command, .. } => command.span,
            Self::Ros { package, .. } => package.span,
            Self::Orocos { component, .. } => component.span,
        }
    }

    /// Returns the built-in component; `None` for other implementations and unknown names.
    pub fn builtin(&self) -> Option<BuiltinComponent> {
        match self {
            Self::Builtin { name, .. } => BuiltinComponent::of_word(name),
            Self::Rust(_)
            | Self::Asm { .. }
            | Self::Composite(_)
            | Self::Process { .. }
            | Self::Ros { .. }
            | Self::Orocos { .. } => None,
        }
    }
}

impl PlannedImplementation {
    /// Returns the name, file or command, and the words that follow it on a command line.
    pub fn words(&self) -> Vec<&str> {
        let (first, rest) = match self {
            Self::Rust(name) | Self::Builtin { name, .. } => (name, [].as_slice()),
            Self::Asm { file, .. } => (file, [].as_slice()),
            Self::Process { command, arguments } => (command, arguments.as_slice()),
            Self::Ros {
                package,
                executable,
            } => (package, executable.as_slice()),
            Self::Orocos {
                component,
                name_service,
            } => (component, name_service.as_slice()),
        };
        std::iter::once(first)
            .chain(rest)
            .map(String::as_str)
            .collect()
    }
}

/// Components provided by the engine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Word)]
pub enum BuiltinComponent {
    /// Access to the ports of a data-flow component through services.
    #[default]
    #[word("port-proxy")]
    PortProxy,
    /// Mapping of topics to ROS topics.
    #[word("ros-bridge")]
    RosBridge,
    /// Dashboard.
    #[word("web-monitor")]
    WebMonitor,
    /// Recorder of runs.
    Recorder,
    /// Replay of recorded runs.
    Replayer,
    /// Simulated world.
    Simulator,
    /// HTTP access to services.
    #[word("http-gateway")]
    HttpGateway,
    /// Timed events.
    Timer,
}
