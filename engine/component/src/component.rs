//! The trait that every component implements.

use std::any::{Any, type_name};

use asmotion_datum::Datum;
use asmotion_port::Time;

use crate::cycle::Cycle;
use crate::fault::Fault;
use crate::frozen::{CannotFreeze, FreezeProblem, FrozenState, ThawError, ThawProblem};
use crate::setup::Setup;

/// The components that stop before one that reads their samples.
///
/// Components stop in reverse order of addition. One that passes samples on to the world outside would stop before its
/// writers if it was added after them, and their [safe samples](crate::Interface::safe) would not leave. It therefore awaits
/// them in any order of addition, and its stop begins with a cycle if samples have arrived since the last one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum AwaitedWriters {
    /// None, and samples that arrive after the last cycle are not read.
    #[default]
    None,
    /// Those that write a safe sample to it.
    Safe,
    /// All that write to it: for a bridge to another middleware.
    All,
}

/// A component of a running system: an object with a cycle.
///
/// Its constructor declares its ports, services, references and properties on an [`Interface`](crate::Interface)
/// and keeps the handles. The hooks are Orocos RTT's; all but `update` may be left out.
pub trait Component: Any + Send {
    /// Runs one cycle, with frozen inputs and constant time. Samples, calls and replies leave only if this returns `Ok`
    /// (RTT `updateHook`, TCA `execute`).
    ///
    /// # Errors
    /// A fault of the component. Nothing that it wrote, called or replied in this cycle is sent.
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault>;

    /// Reads the properties and prepares the component, for example by opening files (RTT `configureHook`, TCA
    /// `initialize`).
    ///
    /// # Errors
    /// A fault if a resource cannot be opened or a property is unusable; the component stays unconfigured.
    fn configure(&mut self, setup: &mut Setup<'_>) -> Result<(), Fault> {
        let _ = setup;
        Ok(())
    }

    /// Called right before the first cycle (RTT `startHook`).
    ///
    /// # Errors
    /// A fault if the component cannot run; it stays stopped.
    fn start(&mut self) -> Result<(), Fault> {
        Ok(())
    }

    /// Runs the last cycle, with the inputs of the cycle before (RTT `stopHook`): the place for the last samples and for
    /// replies to waiting requests. One-way calls leave too; other calls end as cancelled at once. The engine then writes
    /// the [safe samples](crate::Interface::safe) of the outputs, also if this hook panics.
    fn stop(&mut self, _: &mut Cycle<'_>) {}

    /// [Prefetches](asmotion_port::prefetch) memory that the next cycle uses, apart from the component's own fields and its ports.
    /// Called in simulated time, in systems of many components, with `depth` 1, 2 and 3 some cycles of other components before:
    /// depth 1 is for what the fields point to, depth 2 for what that points to. Default: nothing.
    fn prefetch(&self, depth: usize) {
        let _ = depth;
    }

    /// The writers that stop before this component, because it passes their last samples on. Default: none.
    fn awaited_writers(&self) -> AwaitedWriters {
        AwaitedWriters::None
    }

    /// Answers requests while the component is configured and stopped (a TCA task that is not scheduled still answers its
    /// services). Called instead of `update`, without counting as a cycle, when there are requests of operations marked
    /// with [`Interface::while_stopped`](crate::Interface::while_stopped). Inputs are not frozen; replies, reports and a
    /// new period take effect.
    ///
    /// # Errors
    /// A fault of the component, after which it is in [`State::Exception`](crate::State::Exception). Writing a sample or
    /// making a call is one too: a stopped component commands nothing.
    fn serve(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        let _ = cycle;
        Ok(())
    }

    /// Releases what `configure` acquired (RTT `cleanupHook`).
    fn cleanup(&mut self) {}

    /// Called after an exception, once the component has been stopped and cleaned up as far as it had been started and
    /// configured (RTT `exceptionHook`).
    fn exception(&mut self) {}

    /// Runs the cycle of a component in [`State::RunTimeError`](crate::State::RunTimeError), instead of `update` (RTT
    /// `errorHook`). `Ok` means that it has recovered, unless it calls [`Cycle::error`] again.
    ///
    /// # Errors
    /// A fault that cannot be recovered from; the outputs of the cycle are discarded.
    fn recover(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        let _ = cycle;
        Ok(())
    }

    /// Describes the internal state to observers, by names in display order. Called between two cycles, and only when an
    /// observer asks, at most a few times a second; the description has no influence on the run.
    fn inspect(&self) -> Vec<(String, Datum)> {
        Vec::new()
    }

    /// Continues in the state of the component that this one replaces in a running system, between two of its cycles.
    /// Both have the same declaration, and `configure` and `start` are not called again. Returns notes for the operator:
    /// the parts of the state that are not kept.
    ///
    /// # Errors
    /// The reason that it cannot continue in this state; the predecessor then keeps running. Components that do not
    /// implement this method cannot replace a running one.
    fn take_over(&mut self, predecessor: &dyn Component, now: Time) -> Result<Vec<String>, Fault> {
        let _ = (predecessor, now);
        Err(Fault::new(
            "components of this kind cannot be replaced while they run",
        ))
    }

    /// Returns the state of the component between two cycles: everything that later cycles depend on except inputs,
    /// properties and time. `#[derive(Freeze)]` and [`freeze_by_fields!`](crate::freeze_by_fields) implement this
    /// method and [`thaw`](Self::thaw).
    ///
    /// ```
    /// use asmotion_component::{Component, Cycle, Fault, Freeze, freeze_by_fields};
    ///
    /// /// Counts its cycles.
    /// #[derive(Freeze)]
    /// #[freeze(component = "test::Counter", version = 1)]
    /// struct Counter {
    ///     count: u64,
    /// }
    ///
    /// impl Component for Counter {
    ///     freeze_by_fields!();
    ///
    ///     fn update(&mut self, _: &mut Cycle<'_>) -> Result<(), Fault> {
    ///         self.count += 1;
    ///         Ok(())
    ///     }
    /// }
    ///
    /// let mut counter = Counter { count: 7 };
    /// let frozen = counter.freeze()?;
    /// counter.count = 0;
    /// counter.thaw(&frozen)?;
    /// assert_eq!((counter.count, counter.freeze()?), (7, frozen));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// An error if the component does not implement this method, which is the default, if it owns something that cannot
    /// be represented as data, such as a device, or if background work is in progress.
    fn freeze(&self) -> Result<FrozenState, CannotFreeze> {
        Err(CannotFreeze {
            component: type_name::<Self>().to_owned(),
            reason: FreezeProblem::NotImplemented,
        })
    }

    /// Restores a state frozen by a component of the same type. The component must be configured, in a system of the
    /// same composite; it continues where the frozen one stopped.
    ///
    /// # Errors
    ///
    /// An error if the component does not implement this method, or if the state has another type, another version or
    /// malformed content. The component is then unchanged.
    fn thaw(&mut self, state: &FrozenState) -> Result<(), ThawError> {
        let _ = state;
        Err(ThawError {
            component: type_name::<Self>().to_owned(),
            problem: ThawProblem::NotImplemented,
        })
    }
}
