//! A component's runtime state: what its handles stand for, and what its cycle has done so far.

use std::sync::Arc;
use std::time::Duration;

use asmotion_datum::{Datum, Sample};

use crate::background;
use crate::cause::Cause;
use crate::declaration::Declaration;
use crate::outside::Leaving;
use crate::port::{AnyInput, AnyOutput};
use crate::property::{AnyProperty, PropertyError, PropertyProblem, suggestion_among};
use crate::service::{CallId, Caller, Reference, RequestId, Service, ServiceFault, Slot};
use crate::{Event, Fault, Interface};

/// Everything that belongs to a component besides its own code.
pub(crate) struct Body {
    /// The interface its handles were declared on.
    pub owner: u32,
    pub declaration: Declaration,
    pub inputs: Vec<Box<dyn AnyInput>>,
    pub outputs: Vec<Box<dyn AnyOutput>>,
    /// The topic each output publishes to.
    pub topics: Vec<Option<String>>,
    pub properties: Vec<Box<dyn AnyProperty>>,
    pub services: Vec<Service>,
    pub references: Vec<Reference>,
    pub provided: Vec<Slot>,
    pub required: Vec<Slot>,
    pub caller: Caller,
    /// What the present cycle follows from.
    pub cause: Arc<Cause>,
    /// What the present cycle has done, in order; it happens when the cycle is committed.
    pub journal: Vec<Action>,
    /// Where its slow work runs.
    pub background: background::WorkPlace,
    /// How long the present cycle takes in simulated time.
    pub lasts: Duration,
}

/// Something a cycle does.
pub(crate) enum Action {
    /// Sends the oldest pending sample of an output.
    Write(usize),
    Call {
        slot: Slot,
        call: CallId,
        argument: Arc<dyn Sample>,
        one_way: bool,
    },
    Cancel(CallId),
    Answer {
        service: usize,
        to: RequestId,
        result: Result<Arc<dyn Sample>, ServiceFault>,
    },
    Report(&'static str, Datum),
    SetPeriod(Duration),
    /// Another cycle, if news bring them about.
    Again,
}

impl Body {
    pub(crate) fn new(interface: Interface, component: usize) -> Self {
        let declaration = interface.declaration().clone();
        let cause = Arc::new(Cause::new());
        Self {
            owner: interface.owner,
            topics: declaration.outputs.iter().map(|_| None).collect(),
            services: (declaration.services.iter().cloned().zip(interface.handlers))
                .map(|(declaration, handlers)| Service::new(declaration, handlers))
                .collect(),
            references: (declaration.references.iter().cloned())
                .map(|declaration| Reference {
                    declaration,
                    wirings: Vec::new(),
                })
                .collect(),
            declaration,
            inputs: interface.inputs,
            outputs: interface.outputs,
            properties: interface.properties,
            provided: interface.provided,
            required: interface.required,
            caller: Caller::new(component, Arc::clone(&cause)),
            cause,
            journal: Vec::new(),
            background: background::WorkPlace::default(),
            lasts: Duration::ZERO,
        }
    }

    /// What came since the last cycle becomes visible to the next one.
    pub(crate) fn freeze(&mut self, leaving: &mut Leaving<'_>) {
        self.cause.freeze();
        self.lasts = Duration::ZERO;
        for (input, declared) in self.inputs.iter_mut().zip(&self.declaration.inputs) {
            let unreadable = input.freeze(leaving.now);
            if unreadable > 0 {
                leaving.emit(&Event::Dropped {
                    component: leaving.name,
                    port: &declared.name,
                    to: "what it takes",
                    total: unreadable,
                    reason: None,
                });
            }
        }
        for service in &mut self.services {
            service.freeze(leaving.now);
        }
        self.caller.settle(&self.references, leaving);
        self.caller.freeze();
    }

    /// Everything the cycle has done happens, in its order. A mandatory connection that failed is the fault; what
    /// else the cycle did has happened by then.
    pub(crate) fn commit(
        &mut self,
        leaving: &mut Leaving<'_>,
        mut set_period: impl FnMut(Duration),
    ) -> Result<(), Fault> {
        let mut result = Ok(());
        let mut journal = std::mem::take(&mut self.journal);
        for action in journal.drain(..) {
            match action {
                Action::Write(port) => result = result.and(self.flush(port, leaving)),
                Action::Call {
                    slot,
                    call,
                    argument,
                    one_way,
                } => {
                    let references = &self.references;
                    (self.caller).call(references, slot, call.0, argument, one_way, leaving);
                }
                Action::Cancel(call) => self.caller.cancel(&self.references, call, leaving),
                Action::Answer {
                    service,
                    to,
                    result,
                } => {
                    if let Some(service) = self.services.get_mut(service) {
                        service.answer(to, result, leaving);
                    }
                }
                Action::Report(kind, what) => leaving.emit(&Event::Report {
                    component: leaving.name,
                    kind,
                    what: &what,
                }),
                Action::SetPeriod(period) => set_period(period),
                Action::Again => leaving.outside.trigger(leaving.me),
            }
        }
        // The journal's memory serves the next cycle.
        self.journal = journal;
        result
    }

    fn flush(&mut self, port: usize, leaving: &mut Leaving<'_>) -> Result<(), Fault> {
        let declared = self.declaration.outputs.get(port);
        let (Some(output), Some(declared)) = (self.outputs.get_mut(port), declared) else {
            return Ok(());
        };
        let topic = self.topics.get(port).and_then(Option::as_deref);
        output.flush(&declared.name, topic, leaving)
    }

    /// Nothing the cycle has done happens.
    pub(crate) fn discard(&mut self) {
        self.journal.clear();
        for output in &mut self.outputs {
            output.discard();
        }
    }

    /// The component begins to run: its services open.
    pub(crate) fn open(&mut self) {
        for service in &self.services {
            service.open();
        }
    }

    /// The component ends running: whoever waits for it is told, and what it waits for is cancelled.
    pub(crate) fn close(&mut self, leaving: &mut Leaving<'_>) {
        for service in &mut self.services {
            service.close(leaving);
        }
        self.caller.abandon(&self.references, leaving);
    }

    /// Whether properties can have these values.
    pub(crate) fn check(
        &mut self,
        component: &str,
        values: &[(String, Datum)],
    ) -> Result<(), PropertyError> {
        for (name, value) in values {
            self.property(component, name)?
                .check(value)
                .map_err(|problem| PropertyError {
                    component: component.to_owned(),
                    property: name.clone(),
                    problem: Box::new(problem),
                })?;
        }
        Ok(())
    }

    /// Sets properties, all or none; see [`Body::apply`].
    pub(crate) fn prepare(
        &mut self,
        component: &str,
        values: &[(String, Datum)],
    ) -> Result<(), PropertyError> {
        self.check(component, values)?;
        for (name, value) in values {
            self.property(component, name)?.prepare(value);
        }
        Ok(())
    }

    /// A reference has a service no more.
    pub(crate) fn unwire(&mut self, reference: usize, service: &str, leaving: &mut Leaving<'_>) {
        let wirings = (self.references.get(reference)).map_or(&[][..], |it| &it.wirings);
        if wirings.first().is_some_and(|first| first.to == service) {
            self.caller.part(&self.references, reference, leaving);
        }
        if let Some(reference) = self.references.get_mut(reference) {
            reference.wirings.retain(|wiring| wiring.to != service);
        }
    }

    fn property(
        &mut self,
        component: &str,
        name: &str,
    ) -> Result<&mut dyn AnyProperty, PropertyError> {
        let known = &self.declaration.properties;
        let Some(index) = known.iter().position(|property| property.name == name) else {
            let nearest = suggestion_among(name, known.iter().map(|known| &*known.name));
            return Err(PropertyError {
                component: component.to_owned(),
                property: name.to_owned(),
                problem: Box::new(PropertyProblem::Unknown { nearest }),
            });
        };
        Ok(&mut *self.properties[index])
    }

    /// Puts prepared property values in place.
    pub(crate) fn apply(&mut self, leaving: &mut Leaving<'_>) {
        for property in &mut self.properties {
            if property.apply()
                && let Ok(value) = property.get()
            {
                leaving.emit(&Event::Property {
                    component: leaving.name,
                    property: &property.declaration().name,
                    value: &value,
                });
            }
        }
    }

    /// All properties by name, with their present values.
    pub(crate) fn values(&self) -> Vec<(String, Datum)> {
        self.properties
            .iter()
            .filter_map(|property| {
                Some((property.declaration().name.clone(), property.get().ok()?))
            })
            .collect()
    }
}
