//! The life cycle: Orocos RTT's states and guards (rtt/base/TaskCore).

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::fault::Fault;

/// Where a component is in its life.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[repr(u8)]
pub enum State {
    /// Built, and in a system that does not run yet: nothing can be asked of it.
    Init,
    /// In a system that runs; not configured.
    PreOperational,
    /// Failed for good, even in its clean-up.
    FatalError,
    /// Failed in a hook or a cycle; it was stopped and cleaned up.
    Exception,
    /// Configured, ready to run.
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

    /// Whether cycles run: normal ones or the error hook (RTT `isRunning`, TCA `isRunning()`).
    pub fn is_running(self) -> bool {
        matches!(self, Self::Running | Self::RunTimeError)
    }

    /// Whether it is configured (RTT `isConfigured`).
    pub fn is_configured(self) -> bool {
        self == Self::Stopped || self.is_running()
    }

    /// The state of a number, as `state as u8` gives it and threads share it; [`FatalError`](Self::FatalError) for a
    /// number that is none.
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

/// What can be asked of a component's life.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Transition {
    /// Read the properties, get ready.
    Configure,
    /// Begin to cycle.
    Start,
    /// End cycling.
    Stop,
    /// Give everything back.
    Cleanup,
    /// Leave the error hook, or leave an exception (RTT `recover`).
    Recover,
    /// Leave an exception (RTT `resetException`).
    ResetException,
}

impl Transition {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::Configure,
        Self::Start,
        Self::Stop,
        Self::Cleanup,
        Self::Recover,
        Self::ResetException,
    ];

    /// Where it leads from a state when its hook succeeds; `None` where RTT refuses it: from all states not named here.
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

/// Why a transition did not happen.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum LifeCycleError {
    /// RTT's guard: not from this state.
    #[error("cannot {transition} `{component}`: it is {state}")]
    Refused {
        /// The component.
        component: String,
        /// What was asked.
        transition: Transition,
        /// The state it is in.
        state: State,
    },
    /// The component's hook failed.
    #[error("cannot {transition} `{component}`: {fault}")]
    Failed {
        /// The component.
        component: String,
        /// What was asked.
        transition: Transition,
        /// The hook's reason.
        fault: Fault,
    },
    /// There is no such component.
    #[error("there is no component `{component}`")]
    Unknown {
        /// The name asked for.
        component: String,
    },
    /// The component did not answer in time: its cycle is still under way.
    #[error("`{component}` is busy and did not {transition} in time")]
    Busy {
        /// The component.
        component: String,
        /// What was asked.
        transition: Transition,
    },
}
