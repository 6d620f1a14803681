//! The setup, as a component sees it while it is configured.

use std::any::Any;
use std::cell::Cell;
use std::sync::Arc;

use crate::background::WorkPlace;
use crate::fault::Fault;
use crate::handle::Property;
use crate::host::PropertyHost;
use crate::property::{PropertyValue, Slot};

/// Gives a component access to its properties while it is configured.
pub struct Setup<'a> {
    host: &'a dyn PropertyHost,
    name: &'a str,
    /// Set when a foreign handle was used.
    foreign: Cell<bool>,
    work_place: WorkPlace,
}

impl<'a> Setup<'a> {
    /// Creates the setup of a component. For runtimes, and for tests that configure a component by hand.
    pub fn new(host: &'a dyn PropertyHost, name: &'a str) -> Self {
        Self {
            host,
            name,
            foreign: Cell::new(false),
            work_place: WorkPlace::InCycle,
        }
    }

    /// Sets the thread of the component's background work (default: within the cycle, as in simulated time).
    #[must_use]
    pub fn with_work_place(self, work_place: WorkPlace) -> Self {
        Self { work_place, ..self }
    }

    /// A function that requests a cycle of the component, from any thread and at any time; `None` in simulated time, where
    /// nothing outside of the system triggers a cycle.
    pub fn waker(&self) -> Option<Arc<dyn Fn() + Send + Sync>> {
        match &self.work_place {
            WorkPlace::InCycle => None,
            WorkPlace::Thread(requests) => Some(Arc::clone(&requests.wake)),
        }
    }

    /// As [`waker`](Self::waker), for a thread that has brought data and has nothing else to do until more arrive: it is lent to the
    /// cycle and to those that this one triggers, so that none waits for another thread to wake. Cycles that usually take longer
    /// than half a millisecond run elsewhere, as do those of components with a thread of their own.
    ///
    /// The function may call hooks of the component in the current thread, so this one must hold no lock, must not be waited for
    /// by a cycle, and must be able to drop the component.
    pub fn thread_lender(&self) -> Option<Arc<dyn Fn() + Send + Sync>> {
        match &self.work_place {
            WorkPlace::InCycle => None,
            WorkPlace::Thread(requests) => Some(Arc::clone(&requests.lend_thread)),
        }
    }

    /// The component's name in the system.
    pub fn name(&self) -> &str {
        self.name
    }

    /// The value of a property.
    pub fn property<T: PropertyValue>(&self, property: Property<T>) -> T {
        value_of(self.host, property).unwrap_or_else(|| {
            self.foreign.set(true);
            T::initial()
        })
    }

    /// Ends the setup.
    ///
    /// # Errors
    /// [`Fault::ForeignHandle`] if the component used a handle that another one declared.
    pub fn finish(self) -> Result<(), Fault> {
        if !self.foreign.get() {
            return Ok(());
        }
        let kind = "property".into();
        Err(Fault::ForeignHandle { kind })
    }
}

/// The value of a property; `None` if the handle belongs to another component.
pub(crate) fn value_of<T: PropertyValue>(
    host: &dyn PropertyHost,
    property: Property<T>,
) -> Option<T> {
    let slot = host.property(property.position(host.owner()))?;
    let slot: &Slot<T> = (slot as &dyn Any).downcast_ref()?;
    Some(slot.value.clone())
}
