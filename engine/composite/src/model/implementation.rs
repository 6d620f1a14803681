//! Implementations of components.

use asmotion_datum::Word as _;
use asmotion_derive::{Table, Word};
use asmotion_diagnostics::Span;

use crate::at::At;

/// Implementation of a component, exactly one of these.
#[derive(Clone, Debug, PartialEq, Table)]
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
        /// `port-proxy`: component whose ports are accessed through services. `remote`: component of another robot,
        /// `robot://ROBOT/Component`.
        #[key(example = "\"youBotDriver\"", local)]
        target: Option<At<String>>,
        /// `ros-bridge`: name of the bridge.
        #[key(example = "\"ros\"", local)]
        bridge: Option<At<String>>,
        /// `web-monitor`, `http-gateway`: TCP port.
        #[key(range = 0..=65_535)]
        port: Option<At<u64>>,
    },
    /// Program of its own, in any language.
    Process {
        /// Command of a program: the executable and its arguments. An executable without a slash is searched for in
        /// `PATH`.
        #[key(name = "process", example = "[\"python3\", \"gripper.py\"]", one)]
        command: Vec<At<String>>,
        /// Working directory of the program, relative to the directory of the composite, which is the default.
        #[key(example = "\"gripper\"")]
        directory: Option<At<String>>,
        /// Longest time from the start of the program to its declaration.
        #[key(unit = "seconds", range = 0.1..=600.0, default = Implementation::START_TIMEOUT_S)]
        start_timeout_s: Option<At<f64>>,
        /// Longest real time in which the program answers a request; afterwards it is killed.
        #[key(unit = "seconds", range = 0.001..=600.0, default = Implementation::TIMEOUT_S)]
        timeout_s: Option<At<f64>>,
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

/// Returns whether a built-in component talks to other programs.
fn is_outside(name: &str) -> bool {
    BuiltinComponent::of_word(name).is_some_and(|it| it != BuiltinComponent::PortProxy)
}

impl Implementation {
    /// Default of `start_timeout_s` in seconds.
    pub(crate) const START_TIMEOUT_S: f64 = 10.0;
    /// Default of `timeout_s` in seconds.
    pub(crate) const TIMEOUT_S: f64 = 2.0;

    /// Returns the source location.
    pub fn span(&self) -> Span {
        match self {
            Self::Rust(name) | Self::Composite(name) => name.span,
            Self::Asm { file, .. } => file.span,
            Self::Builtin { name, .. } => name.span,
            Self::Process { command, .. } => {
                command.first().map_or_else(Span::default, |word| word.span)
            }
            Self::Ros { package, .. } => package.span,
            Self::Orocos { component, .. } => component.span,
        }
    }

    /// Returns whether cycles can wait for another program or for the network: such a component does not share a thread with
    /// others.
    pub fn waits_outside(&self) -> bool {
        match self {
            Self::Process { .. } => true,
            Self::Builtin { name, .. } => is_outside(&name.value),
            Self::Rust(_)
            | Self::Asm { .. }
            | Self::Composite(_)
            | Self::Ros { .. }
            | Self::Orocos { .. } => false,
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

    /// Returns the target of a port-proxy; `None` for any other component.
    pub fn proxy_target(&self) -> Option<&At<String>> {
        let is_proxy = self.builtin() == Some(BuiltinComponent::PortProxy);
        match self {
            Self::Builtin { target, .. } if is_proxy => target.as_ref(),
            Self::Builtin { .. }
            | Self::Rust(_)
            | Self::Asm { .. }
            | Self::Composite(_)
            | Self::Process { .. }
            | Self::Ros { .. }
            | Self::Orocos { .. } => None,
        }
    }
}

impl PlannedImplementation {
    /// Returns whether cycles can wait for another program or for the network, as those of [`Implementation::waits_outside`].
    pub fn waits_outside(&self) -> bool {
        match self {
            Self::Process { .. } => true,
            Self::Builtin { name, .. } => is_outside(name),
            Self::Rust(_) | Self::Asm { .. } | Self::Ros { .. } | Self::Orocos { .. } => false,
        }
    }

    /// Returns the address of the component of another robot that a component stands for, `robot://ROBOT/Component`.
    pub fn robot_component(&self) -> Option<&str> {
        match self {
            Self::Builtin { name, target, .. }
                if BuiltinComponent::of_word(name) == Some(BuiltinComponent::Remote) =>
            {
                target.as_deref()
            }
            Self::Builtin { .. }
            | Self::Rust(_)
            | Self::Asm { .. }
            | Self::Process { .. }
            | Self::Ros { .. }
            | Self::Orocos { .. } => None,
        }
    }

    /// Returns the name, file or command, and the words that follow it on a command line.
    pub fn words(&self) -> Vec<&str> {
        match self {
            Self::Rust(name) | Self::Builtin { name, .. } => vec![name],
            Self::Asm { file, .. } => vec![file],
            Self::Process { command, .. } => command.iter().map(String::as_str).collect(),
            Self::Ros {
                package,
                executable,
            } => std::iter::once(package.as_str())
                .chain(executable.as_deref())
                .collect(),
            Self::Orocos {
                component,
                name_service,
            } => std::iter::once(component.as_str())
                .chain(name_service.as_deref())
                .collect(),
        }
    }
}

/// Components provided by the engine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Word)]
pub enum BuiltinComponent {
    /// Access to the ports of a data-flow component through services.
    #[default]
    #[word("port-proxy")]
    PortProxy,
    /// A component of another robot, with the ports and services that it announces.
    Remote,
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
