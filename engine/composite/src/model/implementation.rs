//! What a component is made of.

use asmotion_datum::Word as _;
use asmotion_derive::{Table, Word};
use asmotion_diagnostics::Span;

use crate::at::At;

/// What a component is made of: one of these.
#[derive(Clone, Debug, Table)]
#[table(
    of = "an implementation",
    example = "{ rust = \"nav::MapServer\" }",
    reason = "a component has one implementation"
)]
pub enum Implementation {
    /// A component of this build, by its name in the catalogue.
    #[key(example = "\"nav::MapServer\"")]
    Rust(At<String>),
    /// An ASM specification.
    Asm {
        /// An ASM specification: its file.
        #[key(name = "asm", example = "\"guard.asm\"")]
        file: At<String>,
        /// Its main rule, where it is to be checked.
        #[key(example = "\"r_Main\"")]
        main: Option<At<String>>,
    },
    /// Another composite: its file.
    #[key(example = "\"driver.composite.toml\"")]
    Composite(At<String>),
    /// A component that is part of the engine.
    Builtin {
        /// A component that is part of the engine.
        #[key(name = "builtin", example = "\"port-proxy\"")]
        name: At<String>,
        /// `port-proxy`: component whose ports it offers as services.
        #[key(example = "\"youBotDriver\"")]
        target: Option<At<String>>,
        /// `ros-bridge`: bridge it uses.
        #[key(example = "\"ros\"")]
        bridge: Option<At<String>>,
        /// `web-monitor`, `http-gateway`: the TCP port.
        #[key(range = 0..=65_535)]
        port: Option<At<u64>>,
    },
    /// Another program.
    Process {
        /// Another program.
        #[key(name = "process", example = "\"./driver\"")]
        command: At<String>,
        /// Its arguments.
        #[key(example = "[\"--verbose\"]")]
        arguments: Vec<At<String>>,
    },
    /// A ROS node.
    Ros {
        /// A ROS node: its package.
        #[key(name = "ros", example = "\"demo_nodes_cpp\"")]
        package: At<String>,
        /// The executable in it.
        #[key(example = "\"talker\"")]
        executable: Option<At<String>>,
    },
    /// A component of a running Orocos system.
    Orocos {
        /// A component of a running Orocos system: its name there.
        #[key(name = "orocos", example = "\"Driver\"")]
        component: At<String>,
        /// Address of the name service.
        #[key(example = "\"corbaloc::127.0.0.1:2809\"")]
        name_service: Option<At<String>>,
    },
}

impl Implementation {
    /// Where it was written.
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

    /// The component of the engine that it is, if there is one of this name.
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

/// The components that are part of the engine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Word)]
pub enum BuiltinComponent {
    /// Ports of a data-flow component offered as services.
    #[default]
    #[word("port-proxy")]
    PortProxy,
    /// Topics here joined to topics of ROS.
    #[word("ros-bridge")]
    RosBridge,
    /// The dashboard.
    #[word("web-monitor")]
    WebMonitor,
    /// Writes runs down.
    Recorder,
    /// Plays a run that was written down.
    Replayer,
    /// A simulated world.
    Simulator,
    /// Services over HTTP.
    #[word("http-gateway")]
    HttpGateway,
    /// Events at times.
    Timer,
}
