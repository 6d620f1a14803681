//! A component's runtime state: the other end of its handles, and the actions recorded by its current cycle.

use std::sync::Arc;
use std::time::Duration;

use asmotion_component::declaration::ReferenceDeclaration;
use asmotion_component::{
    AnyProperty, CallId, CycleAction, CycleHost, Declaration, Fault, Interface, InterfaceParts,
    Losses, NOTICE_REPORT, OperationSlot, PeerStatus, PropertyError, PropertyHost, PropertyProblem,
    Reply, RequestId, WaitingRequest, WorkPlace, suggestion_among,
};
use asmotion_datum::{Datum, DatumError, DatumProblem, Sample};
use asmotion_port::{AnyInput, AnyOutput, PortEffects, TooOld, prefetch};

use crate::added_ports::{AddedPorts, FormerPorts};
use crate::cause::CycleCause;
use crate::descriptor::ComponentStatus;
use crate::effects::{ComponentEffects, Effects};
use crate::event::Event;
use crate::later_cycle::LaterCycle;
use crate::peers::PeerTable;
use crate::service::{
    Admission, OutgoingCalls, ProvidedService, RequiredReference, UnheardRefusal,
};

/// The state that the runtime keeps for a component, apart from the component itself.
pub(crate) struct ComponentBody {
    /// Number of the interface on which the handles were declared; a handle of another interface is refused.
    pub owner: u32,
    /// Shared with the descriptor of the component.
    pub declaration: Arc<Declaration>,
    pub inputs: Vec<Box<dyn AnyInput>>,
    pub outputs: Vec<Box<dyn AnyOutput>>,
    /// The topic that each output publishes to, by position of the output.
    pub topics: Vec<Option<String>>,
    pub properties: Vec<Box<dyn AnyProperty>>,
    pub services: Vec<ProvidedService>,
    pub references: Vec<RequiredReference>,
    pub provided: Vec<OperationSlot>,
    pub required: Vec<OperationSlot>,
    pub caller: OutgoingCalls,
    /// The trace that the current cycle continues.
    pub cause: Arc<CycleCause>,
    /// The actions of the current cycle, in order. Carried out by `commit`, dropped by `discard`.
    pub journal: Vec<CycleAction>,
    /// Number of samples that the component refused in cycles that were committed, since the unit last took it.
    pub refused: u64,
    /// Executor of the component's background work.
    pub work_place: WorkPlace,
    /// Duration of the current cycle in simulated time.
    pub cycle_duration: Duration,
    /// The cycle that the last one has requested for a later time.
    pub later: LaterCycle,
    /// The statuses of the system's components.
    pub peers: PeerTable,
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
        let caller = OutgoingCalls::new(component, Arc::clone(&cause));
        if !declaration.references.is_empty() {
            caller.allocate();
        }
        Self {
            owner,
            topics: declaration.outputs.iter().map(|_| None).collect(),
            services: declaration
                .services
                .iter()
                .cloned()
                .zip(handlers)
                .map(|(declaration, handlers)| ProvidedService::new(declaration, handlers))
                .collect(),
            references: declaration
                .references
                .iter()
                .cloned()
                .map(|declaration| RequiredReference {
                    declaration,
                    wirings: Vec::new(),
                })
                .collect(),
            declaration: Arc::new(declaration),
            inputs,
            outputs,
            properties,
            provided,
            required,
            caller,
            cause,
            journal: Vec::new(),
            refused: 0,
            work_place: WorkPlace::default(),
            cycle_duration: Duration::ZERO,
            later: LaterCycle::default(),
            peers: PeerTable::default(),
        }
    }

    /// Prefetches the lists of ports, services and properties, and what the body shares with others.
    pub(crate) fn prefetch_lists(&self) {
        prefetch(&*self.inputs);
        prefetch(&*self.outputs);
        prefetch(&*self.topics);
        prefetch(&*self.services);
        prefetch(&*self.properties);
        prefetch(&*self.journal);
        prefetch(&*self.declaration);
        prefetch(&*self.cause);
    }

    /// Prefetches the ports, with `depth` 1 their lists, and with `depth` 2 the queues of their connections.
    pub(crate) fn prefetch_ports(&self, depth: usize) {
        match depth {
            0 => {
                for input in &self.inputs {
                    prefetch(&**input);
                }
                for output in &self.outputs {
                    prefetch(&**output);
                }
                prefetch(&*self.declaration.inputs);
                prefetch(&*self.declaration.outputs);
                for topic in self.topics.iter().flatten() {
                    prefetch(topic.as_str());
                }
            }
            1 => {
                self.inputs.iter().for_each(|it| it.prefetch_lists());
                self.outputs.iter().for_each(|it| it.prefetch_lists());
            }
            _ => {
                self.inputs.iter().for_each(|it| it.prefetch_queues());
                self.outputs.iter().for_each(|it| it.prefetch_queues());
            }
        }
    }

    /// Adds ports after the present ones, and references or operations of references after theirs.
    pub(crate) fn add_ports(&mut self, added: AddedPorts) {
        let AddedPorts {
            inputs,
            outputs,
            declared_inputs,
            declared_outputs,
            references,
        } = added;
        self.topics.extend(outputs.iter().map(|_| None));
        self.inputs.extend(inputs);
        self.outputs.extend(outputs);
        let declaration = Arc::make_mut(&mut self.declaration);
        declaration.inputs.extend(declared_inputs);
        declaration.outputs.extend(declared_outputs);
        if !references.is_empty() {
            self.declare_references(references);
        }
    }

    /// Removes the ports and references that have been added since.
    pub(crate) fn restore_ports(&mut self, former: FormerPorts) {
        self.inputs.truncate(former.inputs);
        self.outputs.truncate(former.outputs);
        self.topics.truncate(former.outputs);
        former.restore(Arc::make_mut(&mut self.declaration));
        self.declare_references(former.references);
    }

    /// Replaces the declarations of the references. Those in the same position keep their wires.
    fn declare_references(&mut self, declared: Vec<ReferenceDeclaration>) {
        if self.references.is_empty() && !declared.is_empty() {
            self.caller.allocate();
        }
        let wired = std::mem::take(&mut self.references).into_iter();
        let wired = wired.map(|reference| reference.wirings);
        let wired = wired.chain(std::iter::repeat_with(Vec::new));
        let references = declared.iter().cloned().zip(wired);
        self.references = references
            .map(|(declaration, wirings)| RequiredReference {
                declaration,
                wirings,
            })
            .collect();
        Arc::make_mut(&mut self.declaration).references = declared;
    }

    /// Freezes the inputs, replies and requests that have arrived since the last cycle, for the next one to read. Returns the
    /// number of samples refused for their values.
    pub(crate) fn freeze(&mut self, effects: &mut ComponentEffects<'_>) -> u64 {
        let mut implausible = 0;
        self.cause.begin_cycle();
        self.cycle_duration = Duration::ZERO;
        self.later.forget();
        for (input, declared) in self.inputs.iter_mut().zip(&self.declaration.inputs) {
            let refusals = input.freeze(effects.now);
            if refusals.unreadable > 0 {
                effects.emit(&Event::Dropped {
                    component: effects.name,
                    port: &declared.name,
                    to: "what it takes",
                    total: refusals.unreadable,
                    reason: None,
                });
            }
            if let Some(discarded) = refusals.too_old {
                report_too_old(&declared.name, discarded, effects);
            }
            implausible += refusals.implausible;
            for cause in &refusals.new_causes {
                report_refusal(&declared.name, cause, effects);
            }
        }
        for service in &mut self.services {
            service.freeze(effects.now);
        }
        self.caller.process_replies(&self.references, effects);
        self.caller.freeze();
        implausible
    }

    /// Discards the commands that arrived while the component did not run, and reports them.
    pub(crate) fn discard_commands(&mut self, effects: &mut ComponentEffects<'_>) {
        let ports = self.inputs.iter_mut().zip(&self.declaration.inputs);
        for (input, declared) in ports.filter(|(_, declared)| declared.command) {
            if input.discard() > 0 {
                let total = input.opener().losses().total();
                report_discarded(&declared.name, total, effects);
            }
        }
    }

    /// Whether samples or requests have been frozen that no cycle has read.
    pub(crate) fn has_new_inputs(&self) -> bool {
        let mut inputs = self.inputs.iter();
        inputs.any(|input| !input.expiries().is_empty())
            || self.services.iter().any(ProvidedService::is_asked)
    }

    /// Remembers the cause of a sample that the component refused, and reports it if it is new.
    fn refuse(&mut self, port: usize, cause: &str, effects: &mut ComponentEffects<'_>) {
        let declared = self.declaration.inputs.get(port);
        let (Some(input), Some(declared)) = (self.inputs.get_mut(port), declared) else {
            return;
        };
        self.refused += 1;
        if input.refuse(cause) {
            report_refusal(&declared.name, cause, effects);
        }
    }

    /// Carries out the actions of the cycle in order. If a mandatory connection could not take a sample, returns a
    /// fault; all other actions of the cycle have been carried out by then.
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
                    self.caller
                        .call(references, slot, call.0, argument, one_way, effects);
                }
                CycleAction::Cancel(call) => self.caller.cancel(&self.references, call, effects),
                CycleAction::Answer {
                    service,
                    to,
                    result,
                } => {
                    let service = self.services.get_mut(service);
                    let unheard = service.and_then(|it| it.answer(to, result, effects));
                    if let Some(refusal) = unheard {
                        self.refused += 1;
                        if refusal.is_new {
                            report_unheard(&refusal, effects);
                        }
                    }
                }
                CycleAction::Report(kind, data) => report(kind, &data, effects),
                CycleAction::Refuse(port, cause) => self.refuse(port, &cause, effects),
                CycleAction::SetPeriod(period) => set_period(period),
                CycleAction::CycleAgain => effects.effects.trigger(effects.component),
                CycleAction::CycleAt(at) => self.later.request(at),
            }
        }
        self.trigger_later(effects);
        // reuse the allocation in the next cycle
        self.journal = journal;
        result
    }

    /// Triggers the component if the cycle that it has requested is due; else asks the executor to wake it.
    pub(crate) fn trigger_later(&mut self, effects: &mut ComponentEffects<'_>) {
        if self.later.take_due(effects.now) {
            effects.effects.trigger(effects.component);
        }
        if let Some(at) = self.later.plan() {
            effects.effects.wake_at(effects.component, at);
        }
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
        output
            .flush(now, &mut effects)
            .map_err(|undelivered| Fault::NotDelivered {
                port: port.to_owned(),
                to: undelivered.to,
            })
    }

    /// Adds the safe samples of the outputs to the cycle.
    pub(crate) fn write_safe_samples(&mut self) {
        for (index, output) in self.outputs.iter_mut().enumerate() {
            if output.write_safe() {
                self.journal.push(CycleAction::Write(index));
            }
        }
    }

    /// Drops the actions and outputs of a cycle that failed, except its reports.
    pub(crate) fn discard(&mut self, effects: &mut ComponentEffects<'_>) {
        for action in self.journal.drain(..) {
            if let CycleAction::Report(kind, data) = action {
                report(kind, &data, effects);
            }
        }
        for output in &mut self.outputs {
            output.discard();
        }
    }

    /// Changes the requests that the services take.
    pub(crate) fn admit(&mut self, admission: Admission, effects: &mut ComponentEffects<'_>) {
        for service in &mut self.services {
            service.admit(admission, effects);
        }
    }

    /// Cancels the component's own calls.
    pub(crate) fn abandon_calls(&mut self, effects: &mut ComponentEffects<'_>) {
        self.caller.abandon(&self.references, effects);
    }

    /// Whether a stopped component answers any operation.
    pub(crate) fn serves_while_stopped(&self) -> bool {
        let mut operations = self
            .services
            .iter()
            .flat_map(|it| &it.declaration.operations);
        operations.any(|it| it.while_stopped)
    }

    /// Freezes the requests that have arrived at a stopped component. Returns whether there are any to answer.
    pub(crate) fn freeze_requests(&mut self, effects: &mut ComponentEffects<'_>) -> bool {
        self.cause.begin_cycle();
        let mut any = false;
        for service in &mut self.services {
            service.freeze(effects.now);
            any |= service.refuse_unmarked(effects);
        }
        any
    }

    /// Returns an error if the actions recorded by a stopped component include a sample or a call.
    pub(crate) fn refuse_commands(&self) -> Result<(), Fault> {
        let command = self.journal.iter().find_map(|action| match action {
            CycleAction::Write(port) => self.declaration.outputs.get(*port).map(|it| &it.name),
            CycleAction::Call { slot, .. } => self
                .declaration
                .references
                .get(slot.port)
                .map(|it| &it.name),
            CycleAction::Cancel(_)
            | CycleAction::Answer { .. }
            | CycleAction::Report(..)
            | CycleAction::SetPeriod(_)
            | CycleAction::CycleAgain
            | CycleAction::CycleAt(_)
            | CycleAction::Refuse(..) => None,
        });
        match command {
            None => Ok(()),
            Some(end) => Err(Fault::new(format!("used `{end}` while it was stopped"))),
        }
    }

    /// Checks property values without setting them.
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

    /// Checks and stages property values, all or none; [`apply`](Self::apply) puts them into effect.
    pub(crate) fn prepare(
        &mut self,
        component: &str,
        values: &[(String, Datum)],
    ) -> Result<(), PropertyError> {
        self.check(component, values)?;
        for (name, value) in values {
            self.property(component, name)?.stage(value);
        }
        Ok(())
    }

    /// Removes a service from a reference and ends the calls under way to it.
    pub(crate) fn unwire(
        &mut self,
        reference: usize,
        service: &str,
        effects: &mut ComponentEffects<'_>,
    ) {
        let wirings = self
            .references
            .get(reference)
            .map_or(&[][..], |it| &it.wirings);
        let removed = wirings.iter().find(|wiring| wiring.to == service);
        if let Some(alternative) = removed.map(|wiring| wiring.wire.alternative) {
            let references = &self.references;
            let caller = &mut self.caller;
            caller.disconnect(references, reference, alternative, effects);
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

    /// Puts staged property values into effect and reports each change.
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

    /// All properties by name, with their current values.
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

/// A component's body during a cycle, together with the status that other threads read.
pub(crate) struct CycleBody<'a> {
    pub body: &'a mut ComponentBody,
    pub status: &'a ComponentStatus,
    /// Knows the observers of the cycle's reports.
    pub observers: &'a dyn Effects,
}

impl PropertyHost for CycleBody<'_> {
    fn owner(&self) -> u32 {
        self.body.owner
    }

    fn property(&self, index: usize) -> Option<&dyn AnyProperty> {
        PropertyHost::property(self.body, index)
    }
}

/// Reports the refusal of a request whose caller does not wait for a reply.
fn report_unheard(refusal: &UnheardRefusal, effects: &mut ComponentEffects<'_>) {
    let UnheardRefusal {
        operation, fault, ..
    } = refusal;
    let text = format!("a one-way call of `{operation}` is refused: {fault}");
    effects.emit(&Event::Report {
        component: effects.name,
        kind: NOTICE_REPORT,
        data: &Datum::text(text),
    });
}

/// Passes a report of the component on to the observers.
fn report(kind: &str, data: &Datum, effects: &mut ComponentEffects<'_>) {
    effects.emit(&Event::Report {
        component: effects.name,
        kind,
        data,
    });
}

/// Reports samples that an input port discarded because of their age.
fn report_too_old(port: &str, discarded: TooOld, effects: &mut ComponentEffects<'_>) {
    let TooOld { total, age, limit } = discarded;
    let reason = format!("{age:.1?} old; the limit of its connection is {limit:?}");
    report_input_loss(port, total, reason, effects);
}

/// Reports commands that arrived before the component started.
fn report_discarded(port: &str, total: u64, effects: &mut ComponentEffects<'_>) {
    let reason = "arrived before the component started".to_owned();
    report_input_loss(port, total, reason, effects);
}

/// Reports samples that an input port discarded.
fn report_input_loss(port: &str, total: u64, reason: String, effects: &mut ComponentEffects<'_>) {
    let (component, reason) = (
        effects.name,
        DatumError::new(DatumProblem::Mismatch(reason)),
    );
    effects.emit(&Event::Dropped {
        component,
        port,
        to: component,
        total,
        reason: Some(&reason),
    });
}

/// Reports why an input port, or its component, refused a sample.
fn report_refusal(port: &str, cause: &str, effects: &mut ComponentEffects<'_>) {
    let text = format!("`{port}` refuses a message: {cause}");
    effects.emit(&Event::Report {
        component: effects.name,
        kind: NOTICE_REPORT,
        data: &Datum::text(text),
    });
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
        let waiting = service.take(operation.operation);
        let mut requests = Vec::with_capacity(waiting.len());
        for (id, request) in waiting {
            self.body.cause.continue_trace(request.trace);
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
        self.body.caller.next_id()
    }

    fn take_replies(&mut self, operation: OperationSlot) -> Vec<Reply<Arc<dyn Sample>>> {
        let replies = self.body.caller.take(operation);
        let cause = &self.body.cause;
        let replies = replies.into_iter().map(|ended| {
            cause.continue_trace(ended.cause);
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
        let reply = self.body.caller.take_reply(operation, call)?;
        self.body.cause.continue_trace(reply.cause);
        let result = reply.result;
        Some(Reply { call, result })
    }

    fn is_under_way(&self, call: CallId) -> bool {
        let made = |action: &CycleAction| matches!(action, CycleAction::Call { call: made, .. } if *made == call);
        self.body.caller.is_under_way(call) || self.body.journal.iter().any(made)
    }

    fn count_lost(&mut self, index: usize, count: u64) {
        if let Some(input) = self.body.inputs.get(index) {
            input.opener().losses().add(count);
        }
    }

    fn set_losses(&mut self, losses: Losses) {
        self.status.set_losses(losses);
    }

    fn set_waiting(&mut self, count: u64) {
        self.status.set_waiting(count);
    }

    fn peer(&self, component: &str) -> Option<PeerStatus> {
        self.body.peers.find(component)
    }

    fn set_reachable(&mut self, is_reachable: bool) {
        self.status.set_reachable(is_reachable);
    }

    fn work_place(&self) -> &WorkPlace {
        &self.body.work_place
    }

    fn set_duration(&mut self, duration: Duration) {
        self.body.cycle_duration = duration;
    }

    fn is_interrupted(&self) -> bool {
        self.status.is_interrupted()
    }

    fn wants_report(&self, kind: &str) -> bool {
        self.observers.wants_report(kind)
    }
}

/// The effects of an output port that sends a sample: numbers it, reports it, triggers the readers.
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
