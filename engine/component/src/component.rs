//! The component: what a robot programmer writes.

use crate::cycle::Cycle;
use crate::fault::Fault;
use crate::setup::Setup;

/// A component: something with a cycle. Everything that lives in a running system is one.
///
/// Its constructor declares its ports, services, references and properties on an [`Interface`](crate::Interface)
/// and keeps the handles. The hooks are Orocos RTT's; all but `update` may be left out.
pub trait Component: Send {
    /// One cycle: inputs are frozen, time stands still. What is written, called or replied leaves only if this
    /// returns `Ok` (RTT `updateHook`, TCA `execute`).
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault>;

    /// Reads the properties, gets ready: files are opened here (RTT `configureHook`, TCA `initialize`).
    fn configure(&mut self, setup: &mut Setup<'_>) -> Result<(), Fault> {
        let _ = setup;
        Ok(())
    }

    /// Right before the first cycle (RTT `startHook`).
    fn start(&mut self) -> Result<(), Fault> {
        Ok(())
    }

    /// Right after the last cycle (RTT `stopHook`).
    fn stop(&mut self) {}

    /// Gives back what `configure` took (RTT `cleanupHook`).
    fn cleanup(&mut self) {}

    /// After an exception, when the component has been stopped and cleaned up, as far as it had been started and
    /// configured (RTT `exceptionHook`).
    fn exception(&mut self) {}

    /// The cycle of a component in [`State::RunTimeError`](crate::State::RunTimeError), instead of `update` (RTT
    /// `errorHook`). `Ok` means recovered, unless it calls [`Cycle::error`] again.
    fn recover(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        let _ = cycle;
        Ok(())
    }
}
