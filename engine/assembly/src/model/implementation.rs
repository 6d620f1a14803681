//! What a component is made of.

use asmotion_derive::Word;
use asmotion_diagnostics::Span;

use crate::At;

/// What a component is made of.
#[derive(Clone, Debug)]
pub enum Implementation {
    /// A component of this build, by its name in the catalogue.
    Rust(At<String>),
    /// An ASM specification.
    Asm {
        /// The `.asm` file.
        file: At<String>,
        /// Its main rule, where it is to be checked.
        main: Option<At<String>>,
    },
    /// Another composite file.
    Composite(At<String>),
    /// A component that is part of the engine.
    Builtin {
        /// Which one.
        name: At<String>,
        /// `None` where no built-in has this name.
        kind: Option<Builtin>,
        /// `port-proxy`: the component whose ports it offers as services.
        target: Option<At<String>>,
        /// `ros-bridge`: the bridge it uses.
        bridge: Option<At<String>>,
        /// `web-monitor`, `http-gateway`: the TCP port.
        port: Option<At<i64>>,
    },
    /// Another program.
    Process {
        /// The program.
        command: At<String>,
        /// Its arguments.
        arguments: Vec<At<String>>,
    },
    /// A ROS node.
    Ros {
        /// The package.
        package: At<String>,
        /// The executable in it.
        executable: Option<At<String>>,
    },
    /// A component of a running Orocos system.
    Orocos {
        /// Its name there.
        component: At<String>,
        /// Where the name service is.
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
}

/// The components that are part of the engine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, Word)]
#[serde(rename_all = "snake_case")]
pub enum Builtin {
    /// Ports of a data-flow component offered as services.
    #[default]
    #[word("port-proxy")]
    #[serde(rename = "port-proxy")]
    PortProxy,
    /// Topics here joined to topics of ROS.
    #[word("ros-bridge")]
    #[serde(rename = "ros-bridge")]
    RosBridge,
    /// The dashboard.
    #[word("web-monitor")]
    #[serde(rename = "web-monitor")]
    WebMonitor,
    /// Writes runs down.
    Recorder,
    /// Plays a run that was written down.
    Replayer,
    /// A simulated world.
    Simulator,
    /// Services over HTTP.
    #[word("http-gateway")]
    #[serde(rename = "http-gateway")]
    HttpGateway,
    /// Events at times.
    Timer,
}
