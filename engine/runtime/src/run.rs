//! A running system, independent of the executor that drives it.

mod addition;
mod asked;
mod call;
mod change;
mod executor;
mod joining;
mod reader;
mod removal;
mod replacement;
mod run_impl;
mod stop_order;
mod topic_change;
mod writer;

use std::sync::Arc;
use std::time::Duration;

use asmotion_component::{
    CallError, Declaration, Fault, LifeCycleError, Losses, Operation, State, ThreadUse, Transition,
};
use asmotion_datum::{Datum, Message, Sample};
use asmotion_port::{Policy, Time};

use crate::build_error::BuildError;
use crate::descriptor::CycleTime;
use crate::event::{Event, ReportInterest};
use crate::run_error::RunError;

pub use addition::{ADDITION_REPORT, ComponentAddition};
pub use asked::Asked;
pub use call::SentCall;
pub use change::{Change, ChangeError};
pub(crate) use executor::{Act, Executor, Watch};
pub use reader::{PortReader, PortSubscription};
pub use replacement::Replacement;
pub use writer::{PortWriter, WriteError};

/// A running system: lets time pass, injects samples, inspects components, and starts, stops and changes them.
pub trait Run {
    /// Current time of the system's clock.
    fn now(&self) -> Time;

    /// Lets time pass until `until`.
    fn run_until(&mut self, until: Time);

    /// Lets time pass until an event satisfies `predicate`, at most until `limit`. Returns whether one did. Events
    /// before the call do not count.
    fn run_until_event(
        &mut self,
        limit: Time,
        predicate: &mut dyn FnMut(Time, &Event<'_>) -> bool,
    ) -> bool {
        self.run_until_event_among(limit, ReportInterest::All, predicate)
    }

    /// As [`run_until_event`](Self::run_until_event), with a predicate that uses these reports only: components spare the cost of
    /// others, unless an observer uses them.
    fn run_until_event_among(
        &mut self,
        limit: Time,
        reports: ReportInterest,
        predicate: &mut dyn FnMut(Time, &Event<'_>) -> bool,
    ) -> bool;

    /// Injects a sample into an input port (`component.port`) from outside, as an operator or a test does.
    ///
    /// # Errors
    /// [`RunError::Unknown`] if there is no such input, [`RunError::Mismatch`] if it cannot read the sample.
    fn inject_sample(
        &mut self,
        at: Time,
        port: &str,
        sample: Arc<dyn Sample>,
    ) -> Result<(), RunError>;

    /// Publishes a sample on a topic from outside.
    ///
    /// # Errors
    /// [`RunError::Unknown`] if there is no such topic, [`RunError::Mismatch`] if a subscriber cannot read the sample.
    fn publish_sample(
        &mut self,
        at: Time,
        topic: &str,
        sample: Arc<dyn Sample>,
    ) -> Result<(), RunError>;

    /// Connects an output to an input of the running system: the reader uses the connection from its next cycle on,
    /// then the writer.
    ///
    /// # Errors
    /// An end does not exist or has the wrong direction, the two are connected already, their types differ, or the
    /// policy is impossible for their threads. Nothing is changed.
    fn connect(&mut self, from: &str, to: &str, policy: Policy) -> Result<(), BuildError>;

    /// Removes the direct connection of an output and an input, after the cycles under way. Its unread samples are
    /// lost; an input whose last sample came through it has no data afterwards, as in RTT.
    ///
    /// # Errors
    /// [`BuildError::NotConnected`] if there is no such connection, [`BuildError::Unknown`] or [`BuildError::Direction`]
    /// if an end is none.
    fn disconnect(&mut self, from: &str, to: &str) -> Result<(), BuildError>;

    /// Makes several changes, or none of them if one is impossible. Each component's changes are made between the same
    /// two of its cycles, its replacement before all others; components that are not concerned keep running. Returns the
    /// notes of the new components: the parts of their state that they do not keep.
    ///
    /// New components are configured and started first, in the caller's thread and without a time limit, as at the start of
    /// a system. Removed ones stop last, after their current cycle; a change does not wait for them.
    ///
    /// # Errors
    /// The first change that is not possible, as [`connect`](Self::connect), [`disconnect`](Self::disconnect) or
    /// [`set_properties`](Self::set_properties) report it; [`ChangeError::Replacement`], [`ChangeError::Addition`] or
    /// [`ChangeError::Removal`] if a component cannot be replaced, added or removed.
    fn change(&mut self, changes: &[Change]) -> Result<Vec<String>, ChangeError>;

    /// Checks whether [`change`](Self::change) would make these changes now. Nothing is changed; new components are constructed,
    /// but not configured.
    ///
    /// # Errors
    /// As [`change`](Self::change).
    fn check_change(&mut self, changes: &[Change]) -> Result<Vec<String>, ChangeError>;

    /// Takes a component through a transition of its life cycle.
    ///
    /// # Errors
    /// [`LifeCycleError::Refused`] if the present state does not allow it, [`LifeCycleError::Failed`] with the fault of
    /// the component, [`LifeCycleError::Unknown`] without such a component, [`LifeCycleError::Busy`] if its cycle does
    /// not end in time.
    fn transition(&mut self, component: &str, transition: Transition)
    -> Result<(), LifeCycleError>;

    /// Fails a component as an error in its own code does, between two of its cycles, to test how a system handles it.
    ///
    /// # Errors
    /// [`RunError::Unknown`] if there is no such component, [`RunError::Busy`] if its cycle does not end in time.
    fn inject_fault(&mut self, component: &str, fault: Fault) -> Result<(), RunError>;

    /// Requests one cycle of a component that is event-driven or driven manually.
    ///
    /// # Errors
    /// [`RunError::Unknown`] if there is no such component.
    fn trigger(&mut self, component: &str) -> Result<(), RunError>;

    /// Changes the period of a periodic or event-driven component, from its next cycle on; zero makes it event-driven.
    ///
    /// # Errors
    /// [`RunError::Unknown`] if there is no such component, [`RunError::Busy`] if its cycle does not end in time.
    fn set_period(&mut self, component: &str, period: Duration) -> Result<(), RunError>;

    /// Sets properties of a component, all or none, from its next cycle on.
    ///
    /// # Errors
    /// [`RunError::Unknown`] if there is no such component, [`RunError::Property`] with the first value that is
    /// refused, [`RunError::Busy`] if its cycle does not end in time.
    fn set_properties(
        &mut self,
        component: &str,
        values: &[(String, Datum)],
    ) -> Result<(), RunError>;

    /// Requests a transition without waiting for it: the component makes it after its current cycle.
    ///
    /// # Errors
    /// [`RunError::Unknown`] if there is no such component. A refusal arrives in [`Asked`].
    fn begin_transition(
        &mut self,
        component: &str,
        transition: Transition,
    ) -> Result<Asked, RunError>;

    /// Requests a change of properties, all or none, without waiting for it.
    ///
    /// # Errors
    /// [`RunError::Unknown`] if there is no such component. A refusal arrives in [`Asked`].
    fn begin_set_properties(
        &mut self,
        component: &str,
        values: &[(String, Datum)],
    ) -> Result<Asked, RunError>;

    /// Names of all components, in order of addition.
    fn components(&self) -> Vec<String>;

    /// Current state of a component; `None` if there is no such component.
    fn state(&self, component: &str) -> Option<State>;

    /// The state that the transition under way leads to while its hook runs (RTT `getTargetState`); outside a
    /// transition, the current state.
    fn target_state(&self, component: &str) -> Option<State>;

    /// Number of cycles that a component has begun; zero if there is no such component.
    fn cycles(&self, component: &str) -> u64;

    /// Current period of a component; zero without a period.
    fn period(&self, component: &str) -> Duration;

    /// The thread in which a component cycles; `None` in virtual time, which has one thread, and without such a component.
    fn thread_use(&self, component: &str) -> Option<ThreadUse>;

    /// Number of periods that a component has missed.
    fn overruns(&self, component: &str) -> u64;

    /// Number of cycles of a component that exceeded their deadline.
    fn late(&self, component: &str) -> u64;

    /// Statistics of the duration of a component's cycles.
    fn cycle_time(&self, component: &str) -> CycleTime;

    /// The losses of a component: messages dropped on the way into its inputs, requests refused by its services because their
    /// queues were full, and losses that it has reported.
    fn losses(&self, component: &str) -> Losses;

    /// Number of messages lost on the way into each input of a component, in order of declaration; empty if there is no such
    /// component.
    fn lost(&self, component: &str) -> Vec<u64>;

    /// Number of requests that each service of a component refused because its queue was full, in order of declaration; empty if
    /// there is no such component.
    fn refused_requests(&self, component: &str) -> Vec<u64>;

    /// The newest fault of a component; `None` if it never failed.
    fn fault(&self, component: &str) -> Option<Fault>;

    /// The ports, services, references and properties that a component declares.
    fn declaration(&self, component: &str) -> Option<Declaration>;

    /// A component's properties with their current values.
    ///
    /// # Errors
    /// [`RunError::Unknown`] if there is no such component, [`RunError::Busy`] if its cycle does not end soon.
    fn properties(&mut self, component: &str) -> Result<Vec<(String, Datum)>, RunError>;

    /// A component's description of its internal state, by names in display order; empty for most components.
    ///
    /// # Errors
    /// [`RunError::Unknown`] if there is no such component, [`RunError::Busy`] if its cycle does not end soon.
    fn inspect(&mut self, component: &str) -> Result<Vec<(String, Datum)>, RunError>;

    /// Stops all running components in reverse order of addition, but a component after the
    /// [writers that it awaits](asmotion_component::Component::awaited_writers). Returns the names of those that did not stop
    /// in time.
    fn stop(&mut self) -> Vec<String>;

    /// Opens a connection of its own into an input port. The writer works from any thread, without the run.
    ///
    /// # Errors
    /// There is no such input, its type is another, or the policy is impossible for it.
    fn writer<T: Message>(
        &mut self,
        port: &str,
        policy: Policy,
    ) -> Result<PortWriter<T>, BuildError>
    where
        Self: Sized;

    /// Opens a connection of its own from an output port. The reader works from any thread, without the run; a slow
    /// reader delays neither the writer nor other readers.
    ///
    /// # Errors
    /// There is no such output, its type is another, or the policy is impossible for it.
    fn reader<T: Message>(
        &mut self,
        port: &str,
        policy: Policy,
    ) -> Result<PortReader<T>, BuildError>
    where
        Self: Sized;

    /// Calls an operation of a service from outside without waiting (RTT `send`). The returned handle collects the
    /// response; the call ends after `timeout`.
    ///
    /// # Errors
    /// There is no such service, it does not serve the operation, or the types of request or response differ.
    fn send<O: Operation>(
        &mut self,
        service: &str,
        argument: O::Request,
        timeout: Duration,
    ) -> Result<SentCall<O>, BuildError>
    where
        Self: Sized;

    /// Lets time pass until a call has ended, and returns its result (RTT `collect`).
    ///
    /// # Errors
    /// [`CallError::Timeout`] at the end of the patience, [`CallError::Unavailable`] if the provider is not running or
    /// its queue is full, [`CallError::Fault`] with the answer of the operation.
    fn collect<O: Operation>(&mut self, sent: SentCall<O>) -> Result<O::Response, CallError>
    where
        Self: Sized;

    /// Lets this much time pass.
    fn run_for(&mut self, duration: Duration) {
        let until = self.now() + duration;
        self.run_until(until);
    }

    /// Injects a sample into an input port from outside; see [`Run::inject_sample`].
    ///
    /// # Errors
    /// As [`inject_sample`](Self::inject_sample).
    fn inject<T: Message>(&mut self, at: Time, port: &str, sample: T) -> Result<(), RunError>
    where
        Self: Sized,
    {
        self.inject_sample(at, port, Arc::new(sample))
    }

    /// Publishes a sample on a topic from outside; see [`Run::publish_sample`].
    ///
    /// # Errors
    /// As [`publish_sample`](Self::publish_sample).
    fn publish<T: Message>(&mut self, at: Time, topic: &str, sample: T) -> Result<(), RunError>
    where
        Self: Sized,
    {
        self.publish_sample(at, topic, Arc::new(sample))
    }

    /// Returns whether a component is in a running state (TCA `isRunning()`).
    fn is_running(&self, component: &str) -> bool {
        self.state(component).is_some_and(State::is_running)
    }
}
