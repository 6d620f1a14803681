//! A running system, whichever executor drives it.

mod asked;
mod call;
mod change;
mod every;
mod executor;
mod reader;
mod writer;

use std::sync::Arc;
use std::time::Duration;

use asmotion_component::{
    CallError, Declaration, Fault, LifeCycleError, Losses, Operation, State, Transition,
};
use asmotion_datum::{Datum, Message, Sample};
use asmotion_port::{Policy, Time};

use crate::build_error::BuildError;
use crate::descriptor::CycleTime;
use crate::event::Event;
use crate::run_error::RunError;

pub use asked::Asked;
pub use call::SentCall;
pub use change::{Change, ChangeError};
pub(crate) use executor::{Act, Executor, Watch};
pub use reader::{PortReader, PortSubscription};
pub use writer::{PortWriter, WriteError};

/// A running system: time passes, samples come from outside, components are looked at and told to start or stop.
pub trait Run {
    /// The present time.
    fn now(&self) -> Time;

    /// Lets time pass until then.
    fn run_until(&mut self, until: Time);

    /// Lets time pass until something has happened, at the longest until `limit`. Says whether it has. What happened
    /// before does not count.
    fn run_until_event(
        &mut self,
        limit: Time,
        wanted: &mut dyn FnMut(Time, &Event<'_>) -> bool,
    ) -> bool;

    /// Gives a sample to an input port from outside: an operator, a test. `port` is `Component.port`.
    fn inject_sample(
        &mut self,
        at: Time,
        port: &str,
        sample: Arc<dyn Sample>,
    ) -> Result<(), RunError>;

    /// Publishes a sample on a topic from outside.
    fn publish_sample(
        &mut self,
        at: Time,
        topic: &str,
        sample: Arc<dyn Sample>,
    ) -> Result<(), RunError>;

    /// Connects an output to an input while both run: the reader has the connection from its next cycle on, then the
    /// writer.
    fn connect(&mut self, from: &str, to: &str, policy: Policy) -> Result<(), BuildError>;

    /// Ends a direct connection of an output and an input, after the cycles under way. What came through it and was not
    /// read is gone; an input whose last sample came through it has no data then, as in RTT.
    fn disconnect(&mut self, from: &str, to: &str) -> Result<(), BuildError>;

    /// Makes several changes, or none of them: where one is not possible, nobody feels anything. Each component's are
    /// made at one border of its cycles; what they do not concern goes on.
    fn change(&mut self, changes: &[Change]) -> Result<(), ChangeError>;

    /// Takes a component through a transition of its life cycle.
    fn transition(&mut self, component: &str, transition: Transition)
    -> Result<(), LifeCycleError>;

    /// Asks for a cycle of a component that is event-driven or driven by hand.
    fn trigger(&mut self, component: &str) -> Result<(), RunError>;

    /// Changes what drives a periodic or event-driven component, from its next cycle on; zero means event-driven.
    fn set_period(&mut self, component: &str, period: Duration) -> Result<(), RunError>;

    /// Sets properties of a component, all or none, from its next cycle on.
    fn set_properties(
        &mut self,
        component: &str,
        values: &[(String, Datum)],
    ) -> Result<(), RunError>;

    /// Asks for a transition, and does not wait for it: a component takes it when its present cycle has ended.
    fn begin_transition(
        &mut self,
        component: &str,
        transition: Transition,
    ) -> Result<Asked, RunError>;

    /// Asks to set properties, all or none, and does not wait for it.
    fn begin_set_properties(
        &mut self,
        component: &str,
        values: &[(String, Datum)],
    ) -> Result<Asked, RunError>;

    /// The components' names, in order of addition.
    fn components(&self) -> Vec<String>;

    /// A component's state.
    fn state(&self, component: &str) -> Option<State>;

    /// The state that a transition under way leads to, as long as its hook is at work (RTT `getTargetState`); without
    /// one, the component's state.
    fn target_state(&self, component: &str) -> Option<State>;

    /// How many cycles a component has begun; none for one that does not exist.
    fn cycles(&self, component: &str) -> u64;

    /// How often a component shall cycle, as of now; zero for one without period.
    fn period(&self, component: &str) -> Duration;

    /// How many periods a component has missed.
    fn overruns(&self, component: &str) -> u64;

    /// How many cycles of a component took longer than their deadline.
    fn late(&self, component: &str) -> u64;

    /// How long the cycles of a component took.
    fn cycle_time(&self, component: &str) -> CycleTime;

    /// What a component says that it has lost.
    fn losses(&self, component: &str) -> Losses;

    /// A component's last fault.
    fn fault(&self, component: &str) -> Option<Fault>;

    /// What a component declares.
    fn declaration(&self, component: &str) -> Option<Declaration>;

    /// A component's properties with their present values.
    fn properties(&mut self, component: &str) -> Result<Vec<(String, Datum)>, RunError>;

    /// Stops every running component, in reverse order of addition. Names those that did not stop in time.
    fn stop(&mut self) -> Vec<String>;

    /// Writes to an input port from outside, by a connection of one's own: from any thread, without the run.
    fn writer<T: Message>(
        &mut self,
        port: &str,
        policy: Policy,
    ) -> Result<PortWriter<T>, BuildError>
    where
        Self: Sized;

    /// Reads an output port from outside, by a connection of one's own: from any thread, without the run. How slowly
    /// it reads is nothing to the writer, nor to other readers.
    fn reader<T: Message>(
        &mut self,
        port: &str,
        policy: Policy,
    ) -> Result<PortReader<T>, BuildError>
    where
        Self: Sized;

    /// Calls an operation of a service from outside, and does not wait (RTT `send`): the answer is collected from what
    /// this returns, within `patience`.
    fn send<O: Operation>(
        &mut self,
        service: &str,
        argument: O::Request,
        patience: Duration,
    ) -> Result<SentCall<O>, BuildError>
    where
        Self: Sized;

    /// Lets time pass until an operation that was called is done (RTT `collect`).
    fn collect<O: Operation>(&mut self, sent: SentCall<O>) -> Result<O::Response, CallError>
    where
        Self: Sized;

    /// Lets time pass.
    fn run_for(&mut self, duration: Duration) {
        let until = self.now() + duration;
        self.run_until(until);
    }

    /// Gives a sample to an input port from outside; see [`Run::inject_sample`].
    fn inject<T: Message>(&mut self, at: Time, port: &str, sample: T) -> Result<(), RunError>
    where
        Self: Sized,
    {
        self.inject_sample(at, port, Arc::new(sample))
    }

    /// Publishes a sample on a topic from outside; see [`Run::publish_sample`].
    fn publish<T: Message>(&mut self, at: Time, topic: &str, sample: T) -> Result<(), RunError>
    where
        Self: Sized,
    {
        self.publish_sample(at, topic, Arc::new(sample))
    }

    /// Whether a component cycles (TCA `isRunning()`).
    fn is_running(&self, component: &str) -> bool {
        self.state(component).is_some_and(State::is_running)
    }
}
