//! The life cycle: Orocos RTT's states and guards (rtt/base/TaskCore).

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::fault::Fault;

/// State of a component in its life cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[repr(u8)]
pub enum State {
    /// Built, in a system that does not run yet; no transition is possible.
    Init,
    /// In a running system, not configured.
    PreOperational,
    /// Failed during the handling of a failure; no transition is possible.
    FatalError,
    /// Failed in a hook or a cycle; stopped and cleaned up.
    Exception,
    /// Configured, not cycling.
    Stopped,
    /// Cycling.
    Running,
    /// Cycling in its error hook ([`Component::recover`](crate::Component::recover)).
    RunTimeError,
}

impl State {
    /// All states, in RTT's order.
    pub const ALL: [Self; 7] = [
        Self::Init,
        Self::PreOperational,
        Self::FatalError,
        Self::Exception,
        Self::Stopped,
        Self::Running,
        Self::RunTimeError,
    ];

    /// Returns whether the component cycles, normally or in the error hook (RTT `isRunning`, TCA `isRunning()`).
    pub fn is_running(self) -> bool {
        matches!(self, Self::Running | Self::RunTimeError)
    }

    /// Returns whether the component is configured (RTT `isConfigured`).
    pub fn is_configured(self) -> bool {
        self == Self::Stopped || self.is_running()
    }

    /// The state with this number, as `state as u8` returns it for sharing between threads;
    /// [`FatalError`](Self::FatalError) for any other number.
    pub fn from_number(number: u8) -> Self {
        Self::ALL
            .into_iter()
            .find(|state| *state as u8 == number)
            .unwrap_or(Self::FatalError)
    }
}

impl fmt::Display for State {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(self, f)
    }
}

/// A transition of the life cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Transition {
    /// Reads the properties and prepares the component.
    Configure,
    /// Begins cycling.
    Start,
    /// Ends cycling.
    Stop,
    /// Releases the component's resources.
    Cleanup,
    /// Leaves the error hook or an exception (RTT `recover`).
    Recover,
    /// Leaves an exception (RTT `resetException`).
    ResetException,
}

impl Transition {
    /// All transitions.
    pub const ALL: [Self; 6] = [
        Self::Configure,
        Self::Start,
        Self::Stop,
        Self::Cleanup,
        Self::Recover,
        Self::ResetException,
    ];

    /// The state it leads to when its hook succeeds; `None` if RTT refuses it in the given state.
    pub fn target(self, from: State) -> Option<State> {
        match (self, from) {
            (Self::Configure, State::PreOperational | State::Stopped) => Some(State::Stopped),
            (Self::Start, State::Stopped) => Some(State::Running),
            (Self::Stop, State::Running | State::RunTimeError) => Some(State::Stopped),
            (Self::Cleanup, State::Stopped) => Some(State::PreOperational),
            (Self::Recover, State::RunTimeError) => Some(State::Running),
            (Self::Recover | Self::ResetException, State::Exception) => Some(State::PreOperational),
            (
                Self::Configure
                | Self::Start
                | Self::Stop
                | Self::Cleanup
                | Self::Recover
                | Self::ResetException,
                State::Init
                | State::PreOperational
                | State::FatalError
                | State::Exception
                | State::Stopped
                | State::Running
                | State::RunTimeError,
            ) => None,
        }
    }
}

impl fmt::Display for Transition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Configure => "configure",
            Self::Start => "start",
            Self::Stop => "stop",
            Self::Cleanup => "clean up",
            Self::Recover => "recover",
            Self::ResetException => "reset the exception of",
        })
    }
}

/// The reason that a transition did not happen.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum LifeCycleError {
    /// RTT's guard refuses the transition in this state.
    #[error("cannot {transition} `{component}`: it is {state}")]
    Refused {
        /// Name of the component.
        component: String,
        /// The requested transition.
        transition: Transition,
        /// The current state.
        state: State,
    },
    /// The component's hook failed.
    #[error("cannot {transition} `{component}`: {fault}")]
    Failed {
        /// Name of the component.
        component: String,
        /// The requested transition.
        transition: Transition,
        /// The fault that the hook returned.
        fault: Fault,
    },
    /// There is no such component.
    #[error("unknown component `{component}`")]
    Unknown {
        /// The name that was looked for.
        component: String,
    },
    /// The component did not reply in time: its cycle is still under way.
    #[error("`{component}` is busy and did not {transition} in time")]
    Busy {
        /// Name of the component.
        component: String,
        /// The requested transition.
        transition: Transition,
    },
}
