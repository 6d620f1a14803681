//! A component's runtime state: what its handles stand for, and what its cycle has done so far.

use std::sync::Arc;
use std::time::Duration;

use asmotion_component::{
    AnyProperty, CallId, CycleAction, CycleHost, Declaration, Fault, Interface, InterfaceParts,
    Losses, OperationSlot, PropertyError, PropertyHost, PropertyProblem, Reply, RequestId,
    WaitingRequest, WorkPlace, suggestion_among,
};
use asmotion_datum::{Datum, DatumError, Sample};
use asmotion_port::{AnyInput, AnyOutput, PortEffects};

use crate::cause::CycleCause;
use crate::descriptor::ComponentStatus;
use crate::effects::ComponentEffects;
use crate::event::Event;
use crate::service::{OutgoingCalls, ProvidedService, RequiredReference};

/// Everything that belongs to a component besides its own code.
pub(crate) struct ComponentBody {
    /// The interface its handles were declared on.
    pub owner: u32,
    pub declaration: Declaration,
    pub inputs: Vec<Box<dyn AnyInput>>,
    pub outputs: Vec<Box<dyn AnyOutput>>,
    /// The topic each output publishes to.
    pub topics: Vec<Option<String>>,
    pub properties: Vec<Box<dyn AnyProperty>>,
    pub services: Vec<ProvidedService>,
    pub references: Vec<RequiredReference>,
    pub provided: Vec<OperationSlot>,
    pub required: Vec<OperationSlot>,
    pub caller: OutgoingCalls,
    /// What the present cycle follows from.
    pub cause: Arc<CycleCause>,
    /// What the present cycle has done, in order; it happens when the cycle is committed.
    pub journal: Vec<CycleAction>,
    /// Where its background work runs.
    pub work_place: WorkPlace,
    /// How long the present cycle takes in simulated time.
    pub lasts: Duration,
}

impl ComponentBody {
    pub(crate) fn new(interface: Interface, component: usize) -> Self {
        let InterfaceParts {
            owner,
            declaration,
            inputs,
            outputs,
            properties,
            provided,
            handlers,
            required,
        } = interface.into_parts();
        let cause = Arc::new(CycleCause::new());
        Self {
            owner,
            topics: declaration.outputs.iter().map(|_| None).collect(),
            services: (declaration.services.iter().cloned().zip(handlers))
                .map(|(declaration, handlers)| ProvidedService::new(declaration, handlers))
                .collect(),
            references: (declaration.references.iter().cloned())
                .map(|declaration| RequiredReference {
                    declaration,
                    wirings: Vec::new(),
                })
                .collect(),
            declaration,
            inputs,
            outputs,
            properties,
            provided,
            required,
            caller: OutgoingCalls::new(component, Arc::clone(&cause)),
            cause,
            journal: Vec::new(),
            work_place: WorkPlace::default(),
            lasts: Duration::ZERO,
        }
    }

    /// What came since the last cycle becomes visible to the next one.
    pub(crate) fn freeze(&mut self, effects: &mut ComponentEffects<'_>) {
        self.cause.freeze();
        self.lasts = Duration::ZERO;
        for (input, declared) in self.inputs.iter_mut().zip(&self.declaration.inputs) {
            let unreadable = input.freeze(effects.now);
            if unreadable > 0 {
                effects.emit(&Event::Dropped {
                    component: effects.name,
                    port: &declared.name,
                    to: "what it takes",
                    total: unreadable,
                    reason: None,
                });
            }
        }
        for service in &mut self.services {
            service.freeze(effects.now);
        }
        self.caller.settle(&self.references, effects);
        self.caller.freeze();
    }

    /// Everything the cycle has done happens, in its order. A mandatory connection that failed is the fault; what
    /// else the cycle did has happened by then.
    pub(crate) fn commit(
        &mut self,
        effects: &mut ComponentEffects<'_>,
        mut set_period: impl FnMut(Duration),
    ) -> Result<(), Fault> {
        let mut result = Ok(());
        let mut journal = std::mem::take(&mut self.journal);
        for action in journal.drain(..) {
            match action {
                CycleAction::Write(port) => result = result.and(self.flush(port, effects)),
                CycleAction::Call {
                    slot,
                    call,
                    argument,
                    one_way,
                } => {
                    let references = &self.references;
                    (self.caller).call(references, slot, call.0, argument, one_way, effects);
                }
                CycleAction::Cancel(call) => self.caller.cancel(&self.references, call, effects),
                CycleAction::Answer {
                    service,
                    to,
                    result,
                } => {
                    if let Some(service) = self.services.get_mut(service) {
                        service.answer(to, result, effects);
                    }
                }
                CycleAction::Report(kind, what) => effects.emit(&Event::Report {
                    component: effects.name,
                    kind,
                    what: &what,
                }),
                CycleAction::SetPeriod(period) => set_period(period),
                CycleAction::Again => effects.effects.trigger(effects.component),
            }
        }
        // The journal's memory serves the next cycle.
        self.journal = journal;
        result
    }

    fn flush(&mut self, port: usize, effects: &mut ComponentEffects<'_>) -> Result<(), Fault> {
        let declared = self.declaration.outputs.get(port);
        let (Some(output), Some(declared)) = (self.outputs.get_mut(port), declared) else {
            return Ok(());
        };
        let topic = self.topics.get(port).and_then(Option::as_deref);
        let port = &*declared.name;
        let now = effects.now;
        let mut effects = OutputEffects {
            port,
            topic,
            effects,
        };
        (output.flush(now, &mut effects)).map_err(|undelivered| Fault::NotDelivered {
            port: port.to_owned(),
            to: undelivered.to,
        })
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

    /// The component ends running: its callers get [`CallError::Unavailable`](asmotion_component::CallError), its own calls
    /// are cancelled.
    pub(crate) fn close(&mut self, effects: &mut ComponentEffects<'_>) {
        for service in &mut self.services {
            service.close(effects);
        }
        self.caller.abandon(&self.references, effects);
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
    pub(crate) fn unwire(
        &mut self,
        reference: usize,
        service: &str,
        effects: &mut ComponentEffects<'_>,
    ) {
        let wirings = (self.references.get(reference)).map_or(&[][..], |it| &it.wirings);
        if wirings.first().is_some_and(|first| first.to == service) {
            self.caller.disconnect(&self.references, reference, effects);
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
    pub(crate) fn apply(&mut self, effects: &mut ComponentEffects<'_>) {
        for property in &mut self.properties {
            if property.apply()
                && let Ok(value) = property.get()
            {
                effects.emit(&Event::Property {
                    component: effects.name,
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

impl PropertyHost for ComponentBody {
    fn owner(&self) -> u32 {
        self.owner
    }

    fn property(&self, index: usize) -> Option<&dyn AnyProperty> {
        self.properties.get(index).map(|property| &**property)
    }
}

/// A component's body during a cycle, with what other threads see of the component.
pub(crate) struct CycleBody<'a> {
    pub body: &'a mut ComponentBody,
    pub status: &'a ComponentStatus,
}

impl PropertyHost for CycleBody<'_> {
    fn owner(&self) -> u32 {
        self.body.owner
    }

    fn property(&self, index: usize) -> Option<&dyn AnyProperty> {
        PropertyHost::property(self.body, index)
    }
}

impl CycleHost for CycleBody<'_> {
    fn input(&self, index: usize) -> Option<&dyn AnyInput> {
        self.body.inputs.get(index).map(|input| &**input)
    }

    fn output(&mut self, index: usize) -> Option<&mut dyn AnyOutput> {
        let output = self.body.outputs.get_mut(index)?;
        Some(&mut **output)
    }

    fn provided(&self, index: usize) -> Option<OperationSlot> {
        self.body.provided.get(index).copied()
    }

    fn required(&self, index: usize) -> Option<OperationSlot> {
        self.body.required.get(index).copied()
    }

    fn record(&mut self, action: CycleAction) {
        self.body.journal.push(action);
    }

    fn take_requests(&mut self, operation: OperationSlot) -> Vec<WaitingRequest> {
        let Some(service) = self.body.services.get_mut(operation.port) else {
            return Vec::new();
        };
        let taken = service.take(operation.operation);
        let mut requests = Vec::with_capacity(taken.len());
        for (id, request) in taken {
            self.body.cause.take(request.trace);
            requests.push(WaitingRequest {
                id,
                argument: request.argument,
                caller: request.caller,
                deadline: request.deadline,
            });
        }
        requests
    }

    fn cancelled(&self, service: usize) -> &[RequestId] {
        let service = self.body.services.get(service);
        service.map_or(&[], ProvidedService::cancelled)
    }

    fn next_call(&mut self) -> CallId {
        self.body.caller.number()
    }

    fn take_replies(&mut self, operation: OperationSlot) -> Vec<Reply<Arc<dyn Sample>>> {
        let ended = self.body.caller.take(operation);
        let cause = &self.body.cause;
        let replies = ended.into_iter().map(|ended| {
            cause.take(ended.cause);
            Reply {
                call: CallId(ended.number),
                result: ended.result,
            }
        });
        replies.collect()
    }

    fn take_reply(
        &mut self,
        operation: OperationSlot,
        call: CallId,
    ) -> Option<Reply<Arc<dyn Sample>>> {
        let ended = self.body.caller.take_one(operation, call)?;
        self.body.cause.take(ended.cause);
        let result = ended.result;
        Some(Reply { call, result })
    }

    fn is_under_way(&self, call: CallId) -> bool {
        let made = |action: &CycleAction| matches!(action, CycleAction::Call { call: made, .. } if *made == call);
        self.body.caller.is_under_way(call) || self.body.journal.iter().any(made)
    }

    fn set_losses(&mut self, losses: Losses) {
        self.status.set_losses(losses);
    }

    fn work_place(&self) -> &WorkPlace {
        &self.body.work_place
    }

    fn set_duration(&mut self, duration: Duration) {
        self.body.lasts = duration;
    }

    fn is_interrupted(&self) -> bool {
        self.status.is_interrupted()
    }
}

/// The effects of an output port that sends a sample.
struct OutputEffects<'a, 'e> {
    port: &'a str,
    topic: Option<&'a str>,
    effects: &'a mut ComponentEffects<'e>,
}

impl PortEffects for OutputEffects<'_, '_> {
    fn next_order(&mut self) -> u64 {
        self.effects.effects.next_order()
    }

    fn published(&mut self, sequence: u64, sample: &dyn Sample) {
        self.effects.emit(&Event::Published {
            component: self.effects.name,
            port: self.port,
            topic: self.topic,
            sequence,
            sample,
        });
    }

    fn trigger(&mut self, component: usize) {
        self.effects.effects.trigger(component);
    }

    fn dropped(&mut self, to: &str, total: u64, reason: Option<&DatumError>) {
        self.effects.emit(&Event::Dropped {
            component: self.effects.name,
            port: self.port,
            to,
            total,
            reason,
        });
    }
}
