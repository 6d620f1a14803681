//! Turns updates of out functions into messages and calls.

use crate::bind_error::BindError;
use crate::binding::{
    Action, Binding, BoundOperation, Case, Effect, PublishWhen, Published, kept_names,
};
use crate::bound_location::{BoundLocation, BoundLocations, KeyField};
use crate::content::{AfterStep, BoundContent, EffectContext, evaluate};
use crate::convert::{datum_of, literal_value};
use crate::frame::InputFrame;
use crate::inputs::{EventTarget, MessageInputs};
use crate::location::LocationName;
use crate::published_value::{PublishedValue, message_of, messages};
use crate::requests::{Requests, WaitingCaller, cancelled_fault, superseded_fault};
use crate::terms::BindingTerms;
use crate::typed_input::TypedInput;
use asmotion_component::{
    CallError, CallId, Cycle, Dynamic, Out, Reply, Required, ServiceFault, prefetch,
};
use asmotion_datum::{Datum, Schema};
use asmotion_lang::Specification;
use asmotion_lang::ir::{FunctionId, Slot, ValueShape};
use asmotion_lang::value::Value;
use std::collections::BTreeMap;
use std::sync::Arc;

/// The handles of a component, by name.
#[derive(Default)]
pub(crate) struct EffectHandles {
    pub inputs: Vec<TypedInput>,
    pub outputs: Vec<(String, Out<Datum>)>,
    pub written: Vec<WrittenPort>,
    pub operations: Vec<(BoundOperation, Required<Dynamic>)>,
}

/// An output port and the type of its messages.
pub(crate) struct WrittenPort {
    pub port: Out<Datum>,
    pub name: String,
    /// Shared by the coordinators of a specification.
    pub schema: Arc<Schema>,
}

/// The bound out functions of a specification, and their calls under way.
pub(crate) struct EffectOutbox {
    outputs: Vec<BoundOutput>,
    /// For each output, the outputs whose values are in its message.
    messages: Vec<Vec<usize>>,
    /// Responses by the names under which they are kept.
    pub kept: BTreeMap<String, Datum>,
    /// The newest messages published on the output ports that the binding refers to, by port.
    pub published: BTreeMap<String, Datum>,
    /// The output ports that the binding refers to.
    recorded: Vec<(String, Out<Datum>)>,
    written: Vec<WrittenPort>,
    pub pending: Vec<PendingOutcome>,
    ports: Vec<TypedInput>,
    operations: Vec<Required<Dynamic>>,
}

/// A location of an out function and the effect of its updates.
pub(crate) struct BoundOutput {
    function: FunctionId,
    arguments: Vec<Value>,
    effect: BoundEffect,
}

impl BoundOutput {
    /// The way in which its value is published, unless its updates have other effects.
    fn published(&self) -> Option<&PublishedValue> {
        match &self.effect {
            BoundEffect::Publish(published) => Some(published),
            BoundEffect::Literals(_) => None,
        }
    }

    /// The slot of the location; `None` before its first update, unless it has an initial value.
    fn slot(&self, after: &AfterStep<'_>) -> Option<Slot> {
        let (state, program) = (after.machine.state(), after.machine.program());
        state.slot(program, self.function, &self.arguments)
    }

    /// Returns whether the step demands a message with its value.
    fn is_due(&self, after: &AfterStep<'_>) -> bool {
        let (Some(published), Some(slot)) = (self.published(), self.slot(after)) else {
            return false;
        };
        match (published.when, after.update(Some(slot))) {
            (PublishWhen::EveryStep, _) | (PublishWhen::OnUpdate, Some(_)) => true,
            (PublishWhen::OnChange, Some((_, has_changed))) => has_changed,
            (PublishWhen::OnUpdate | PublishWhen::OnChange, None) => false,
        }
    }
}

enum BoundEffect {
    Publish(PublishedValue),
    Literals(Vec<(Value, Vec<BoundAction>)>),
}

#[expect(
    clippy::large_enum_variant,
    reason = "a coordinator has a handful of them, made once at its start"
)]
enum BoundAction {
    Publish {
        port: Out<Datum>,
        value: BoundContent,
    },
    Call {
        operation: Required<Dynamic>,
        with: BoundContent,
        outcome: OutcomeEffect,
    },
    /// Cancels the call under way, as every action does.
    Cancel,
}

impl AfterStep<'_> {
    /// The new value of a location, and whether it changed; `None` without an update.
    fn update(&self, slot: Option<Slot>) -> Option<(Value, bool)> {
        let step = self.machine.last_step();
        let mut updates = step.updates().iter().zip(step.before());
        let (update, before) = updates.find(|(update, _)| Some(update.slot) == slot)?;
        Some((update.value.clone(), update.value != *before))
    }
}

/// A call that has not ended.
pub(crate) struct PendingOutcome {
    pub call: CallId,
    pub outcome: OutcomeEffect,
    /// The request that the outcome answers, if any.
    pub caller: Option<WaitingCaller>,
}

/// The effects of the end of a call.
#[derive(Clone)]
pub(crate) struct OutcomeEffect {
    /// Position of the call among all calls of the binding.
    pub number: usize,
    operation: BoundOperation,
    /// Position of the out location whose update made the call; a later update of it to a value with actions cancels the call.
    output: usize,
    keep: Option<String>,
    /// The location that takes the event.
    event: Option<EventTarget>,
    ok: Option<Value>,
    failed: Option<Value>,
    /// Fault codes and their literals.
    faults: Vec<(String, Value)>,
    timeout: Option<Value>,
    unavailable: Option<Value>,
    /// Name of the service whose caller gets the outcome.
    reply: Option<String>,
}

impl OutcomeEffect {
    pub fn operation(&self) -> &BoundOperation {
        &self.operation
    }

    fn fail(&self, inbox: &mut MessageInputs) {
        if let (Some(input), Some(event)) = (self.event, self.failed.clone()) {
            inbox.push(input, event, self.output);
        }
    }
}

/// Resolves the bindings of out functions.
pub(crate) struct OutputResolver<'r> {
    pub specification: &'r Specification,
    pub handles: &'r EffectHandles,
    pub terms: &'r BindingTerms,
    pub inbox: &'r mut MessageInputs,
    pub frame: &'r mut InputFrame,
}

impl OutputResolver<'_> {
    /// Returns the bound locations, in the order of the binding.
    pub fn outputs(&mut self, binding: &Binding) -> Result<Vec<BoundOutput>, BindError> {
        let mut outputs = Vec::new();
        for out in &binding.out {
            let key: &[_] = match &out.effect {
                Effect::Publish(published) => &published.key,
                Effect::Literals(_) => &[],
            };
            let located = BoundLocations::resolve(&out.location, key, self.specification)?;
            for location in located.all() {
                let effect = match &out.effect {
                    Effect::Publish(published) => {
                        let elements = key_elements(&located, &location, self.specification);
                        self.handles.publication(published, elements)?
                    }
                    Effect::Literals(cases) => {
                        let mut bound = Vec::new();
                        for case in cases {
                            bound.push(self.case(out, case, &located, outputs.len())?);
                        }
                        BoundEffect::Literals(bound)
                    }
                };
                outputs.push(BoundOutput {
                    function: located.function,
                    arguments: location.arguments,
                    effect,
                });
            }
        }
        for (number, outcome) in outcomes(&mut outputs).enumerate() {
            outcome.number = number;
        }
        Ok(outputs)
    }

    /// Resolves the actions of a literal of the out location at position `output`.
    fn case(
        &mut self,
        out: &crate::binding::Out,
        case: &Case,
        located: &BoundLocations,
        output: usize,
    ) -> Result<(Value, Vec<BoundAction>), BindError> {
        let literal = literal(&out.location, &case.literal, located, self.specification)?;
        let actions = case.actions.iter();
        let actions = actions.filter(|action| **action != Action::Cancel(false));
        let actions = actions.map(|action| self.action(action, output));
        Ok((literal, actions.collect::<Result<_, _>>()?))
    }

    /// Resolves an action of the out location at position `output`.
    fn action(&mut self, action: &Action, output: usize) -> Result<BoundAction, BindError> {
        let (specification, handles) = (self.specification, self.handles);
        let inbox = &mut *self.inbox;
        match action {
            Action::Publish { port, value } => Ok(BoundAction::Publish {
                port: handles.output(port)?,
                value: BoundContent::resolve(value, self.terms)?,
            }),
            Action::Cancel(_) => Ok(BoundAction::Cancel),
            Action::Call(call) => {
                let mut operations = handles.operations.iter();
                let found = operations.find(|(known, _)| *known == call.operation);
                let Some((_, operation)) = found else {
                    return Err(BindError::UnknownOperation(call.operation.clone()));
                };
                let event = match &call.event {
                    Some(event) => {
                        let name = LocationName::from(event.as_str());
                        Some(inbox.event(&name, specification, self.frame)?)
                    }
                    None => None,
                };
                let literal = |name: &Option<String>| match (event, name) {
                    (Some(event), Some(name)) => inbox
                        .literal(event, name, &specification.program)
                        .map(Some)
                        .ok_or_else(|| BindError::NotAValue {
                            function: call.event.clone().unwrap_or_default(),
                            value: name.clone(),
                        }),
                    _ => Ok(None),
                };
                let mut faults = Vec::new();
                for (code, name) in &call.faults {
                    let literal = literal(&Some(name.clone()))?;
                    faults.extend(literal.map(|literal| (code.clone(), literal)));
                }
                let outcome = OutcomeEffect {
                    // assigned once all calls are known
                    number: 0,
                    operation: call.operation.clone(),
                    output,
                    keep: call.keep.clone(),
                    event,
                    ok: literal(&call.ok)?,
                    failed: literal(&call.failed)?,
                    faults,
                    timeout: literal(&call.timeout)?,
                    unavailable: literal(&call.unavailable)?,
                    reply: call.reply.clone(),
                };
                Ok(BoundAction::Call {
                    operation: *operation,
                    with: BoundContent::resolve(&call.with, self.terms)?,
                    outcome,
                })
            }
        }
    }
}

impl EffectOutbox {
    pub fn new(outputs: Vec<BoundOutput>, handles: EffectHandles, binding: &Binding) -> Self {
        let operations = handles.operations.iter();
        let names = kept_names(binding);
        let recorded = handles.outputs.into_iter();
        let recorded = recorded.filter(|(port, _)| names.contains(port.as_str()));
        let published: Vec<Option<&PublishedValue>> =
            outputs.iter().map(BoundOutput::published).collect();
        let messages = messages(&published);
        Self {
            outputs,
            messages,
            kept: BTreeMap::new(),
            published: BTreeMap::new(),
            recorded: recorded.collect(),
            written: handles.written,
            pending: Vec::new(),
            operations: operations.map(|(_, operation)| *operation).collect(),
            ports: handles.inputs,
        }
    }

    /// Handles the calls that have ended: keeps responses, and turns outcomes into events. Returns the operations of these calls.
    pub fn receive(
        &mut self,
        cycle: &mut Cycle<'_>,
        inbox: &mut MessageInputs,
    ) -> Vec<BoundOperation> {
        let mut ended = Vec::new();
        for operation in &self.operations {
            for Reply { call, result } in cycle.replies(*operation) {
                let mut pending = self.pending.iter();
                let Some(index) = pending.position(|pending| pending.call == call) else {
                    continue;
                };
                let PendingOutcome {
                    outcome, caller, ..
                } = self.pending.remove(index);
                if let Some(caller) = caller {
                    cycle.reply(caller.handle, caller.request, forwarded_result(&result));
                }
                let event = match result {
                    Ok(reply) => {
                        if let Some(name) = outcome.keep {
                            self.kept.insert(name, reply);
                        }
                        outcome.ok
                    }
                    Err(CallError::Timeout) => outcome.timeout.or(outcome.failed),
                    Err(CallError::Unavailable | CallError::Stopped) => {
                        outcome.unavailable.or(outcome.failed)
                    }
                    Err(CallError::Fault(fault)) => {
                        let mut faults = outcome.faults.into_iter();
                        let known = faults.find(|(code, _)| *code == fault.code);
                        known.map(|(_, literal)| literal).or(outcome.failed)
                    }
                    Err(CallError::Cancelled) => None,
                };
                if let (Some(input), Some(event)) = (outcome.event, event) {
                    inbox.push(input, event, outcome.output);
                }
                ended.push(outcome.operation);
            }
        }
        ended
    }

    /// The operations of the calls under way.
    pub fn pending_calls(&self) -> impl Iterator<Item = &BoundOperation> {
        self.pending
            .iter()
            .map(|pending| &pending.outcome.operation)
    }

    /// Continues a call of a predecessor.
    pub fn add_pending(
        &mut self,
        call: CallId,
        outcome: OutcomeEffect,
        caller: Option<WaitingCaller>,
    ) {
        self.pending.push(PendingOutcome {
            call,
            outcome,
            caller,
        });
    }

    /// The bound locations, in the order of the binding.
    pub fn locations(&self) -> impl Iterator<Item = (FunctionId, &[Value])> {
        let outputs = self.outputs.iter();
        outputs.map(|output| (output.function, output.arguments.as_slice()))
    }

    /// Ends all calls as failed, because the component stops.
    pub fn stop(&mut self, inbox: &mut MessageInputs) {
        for pending in std::mem::take(&mut self.pending) {
            pending.outcome.fail(inbox);
        }
    }

    /// Carries out the effects of a step's updates. An action that needs a message which has not arrived yet is skipped
    /// and reported; if it is a call, it ends as failed.
    pub fn send(
        &mut self,
        after: &mut AfterStep<'_>,
        cycle: &mut Cycle<'_>,
        inbox: &mut MessageInputs,
        requests: &mut Requests,
    ) {
        for (position, out) in self.outputs.iter().enumerate() {
            match &out.effect {
                BoundEffect::Publish(published) => {
                    let members = self.messages.get(position).into_iter().flatten();
                    let mut members = members.filter_map(|it| self.outputs.get(*it));
                    if members.clone().any(|it| it.is_due(after)) {
                        let (message, has_undef) = message_with(published, &mut members, after);
                        // undef is null in a field of any type: a reader takes it as no value
                        let written = if has_undef { &[][..] } else { &self.written };
                        let record = (&*self.recorded, &mut self.published);
                        publish(published.port, message, written, record, cycle);
                    }
                }
                BoundEffect::Literals(cases) => {
                    let Some((value, _)) = after.update(out.slot(after)) else {
                        continue;
                    };
                    let Some(actions) = actions_of(cases, &value) else {
                        continue;
                    };
                    cancel_calls(&mut self.pending, position, actions, cycle);
                    inbox.remove_outcomes(position);
                    for action in actions {
                        match action {
                            BoundAction::Cancel => {}
                            BoundAction::Publish { port, value } => {
                                match evaluate(value, &self.context(requests), after, cycle) {
                                    Ok(message) => {
                                        let record = (&*self.recorded, &mut self.published);
                                        publish(*port, message, &self.written, record, cycle);
                                    }
                                    Err(missing) => report_unsent(&missing, cycle),
                                }
                            }
                            BoundAction::Call {
                                operation,
                                with,
                                outcome,
                            } => match evaluate(with, &self.context(requests), after, cycle) {
                                Ok(argument) => {
                                    let service = outcome.reply.as_ref();
                                    let caller =
                                        service.and_then(|name| requests.take_newest(name, cycle));
                                    self.pending.push(PendingOutcome {
                                        call: cycle.call(*operation, argument),
                                        outcome: outcome.clone(),
                                        caller,
                                    });
                                }
                                Err(missing) => {
                                    report_unsent(&missing, cycle);
                                    outcome.fail(inbox);
                                }
                            },
                        }
                    }
                }
            }
        }
    }
}

/// The actions of an update to a value; `None` if it has none.
fn actions_of<'c>(
    cases: &'c [(Value, Vec<BoundAction>)],
    value: &Value,
) -> Option<&'c [BoundAction]> {
    let (_, actions) = cases.iter().find(|(literal, _)| literal == value)?;
    (!actions.is_empty()).then_some(actions.as_slice())
}

/// Cancels the calls that earlier updates of the out location at position `output` made, because its actions have been chosen.
fn cancel_calls(
    calls: &mut Vec<PendingOutcome>,
    output: usize,
    actions: &[BoundAction],
    cycle: &mut Cycle<'_>,
) {
    let is_of_output = |pending: &mut PendingOutcome| pending.outcome.output == output;
    for pending in calls.extract_if(.., is_of_output) {
        cycle.cancel(pending.call);
        if let Some(caller) = pending.caller {
            let fault = match actions {
                [BoundAction::Cancel] => cancelled_fault(),
                _ => superseded_fault(),
            };
            cycle.reply(caller.handle, caller.request, Err(fault));
        }
    }
}

/// Iterates over the outcome effects of the calls in a binding.
fn outcomes(outputs: &mut [BoundOutput]) -> impl Iterator<Item = &mut OutcomeEffect> {
    let cases = outputs.iter_mut().flat_map(|out| match &mut out.effect {
        BoundEffect::Literals(cases) => cases.as_mut_slice(),
        BoundEffect::Publish(_) => &mut [],
    });
    cases
        .flat_map(|(_, actions)| actions)
        .filter_map(|action| match action {
            BoundAction::Call { outcome, .. } => Some(outcome),
            BoundAction::Publish { .. } | BoundAction::Cancel => None,
        })
}

impl EffectOutbox {
    /// Returns the outcome effect of the call at this position.
    pub fn outcome(&mut self, number: usize) -> Option<OutcomeEffect> {
        outcomes(&mut self.outputs).nth(number).cloned()
    }

    /// Prefetches the lists of outputs and ports.
    pub fn prefetch(&self) {
        prefetch(&*self.outputs);
        prefetch(&*self.messages);
        prefetch(&*self.written);
        prefetch(&*self.ports);
        prefetch(&*self.operations);
    }

    /// Prefetches what the outputs point to.
    pub fn prefetch_each(&self) {
        self.messages.iter().for_each(|it| prefetch(&**it));
        for output in &self.outputs {
            match &output.effect {
                BoundEffect::Publish(published) => {
                    prefetch(published.field.as_deref().unwrap_or_default());
                }
                BoundEffect::Literals(cases) => prefetch(&**cases),
            }
        }
    }

    /// The input ports.
    pub fn ports(&self) -> &[TypedInput] {
        &self.ports
    }

    /// The sources of message contents.
    pub fn context<'k>(&'k self, requests: &'k Requests) -> EffectContext<'k> {
        EffectContext {
            kept: &self.kept,
            ports: &self.ports,
            requests,
            published: &self.published,
        }
    }
}

impl EffectHandles {
    fn output(&self, name: &str) -> Result<Out<Datum>, BindError> {
        let found = self.outputs.iter().find(|(port, _)| port == name);
        found
            .map(|(_, port)| *port)
            .ok_or_else(|| BindError::UnknownPort {
                port: name.to_owned(),
            })
    }

    /// The publication of the value of a location; `elements` are those of its key.
    fn publication(
        &self,
        published: &Published,
        elements: Vec<Datum>,
    ) -> Result<BoundEffect, BindError> {
        let paths = published.key.iter().map(|(_, path)| path.clone());
        Ok(BoundEffect::Publish(PublishedValue {
            port: self.output(&published.port)?,
            field: published.field.clone(),
            key: paths.zip(elements).collect(),
            when: published.when,
        }))
    }
}

/// The elements of a location's key as data, in the order of the key's fields.
fn key_elements(
    located: &BoundLocations,
    location: &BoundLocation,
    specification: &Specification,
) -> Vec<Datum> {
    let datum = |(element, field): (&Value, &KeyField)| {
        if let Value::Bool(truth) = element {
            return Datum::Bool(*truth);
        }
        if let Value::Int(number) = element {
            return Datum::Int(*number);
        }
        let known = specification.program.named_elements(&field.shape);
        let mut known = known.into_iter().flatten();
        let found = known.find(|(_, value)| value == element);
        Datum::text(found.map(|(name, _)| name).unwrap_or_default())
    };
    let selected = location.elements.iter().zip(&located.key);
    selected.map(datum).collect()
}

fn literal(
    name: &LocationName,
    literal: &str,
    located: &BoundLocations,
    specification: &Specification,
) -> Result<Value, BindError> {
    let program = &specification.program;
    let value = match &located.codomain {
        ValueShape::Domain(domain) => literal_value(literal, *domain, program),
        ValueShape::Bool => literal.parse().ok().map(Value::Bool),
        ValueShape::Int | ValueShape::Natural => literal.parse().ok().map(Value::Int),
        ValueShape::Text => Some(Value::text(literal)),
        ValueShape::Real
        | ValueShape::Char
        | ValueShape::Complex
        | ValueShape::Rule
        | ValueShape::Tuple(_)
        | ValueShape::Seq(_)
        | ValueShape::Set(_)
        | ValueShape::Bag(_)
        | ValueShape::Map(..)
        | ValueShape::Any => None,
    };
    value.ok_or_else(|| BindError::NotAValue {
        function: name.to_string(),
        value: literal.to_owned(),
    })
}

/// The output ports that the binding refers to, and the newest messages published on them.
type PublicationRecord<'r> = (&'r [(String, Out<Datum>)], &'r mut BTreeMap<String, Datum>);

/// The message with the values of out locations, and whether one of them is undef.
fn message_with(
    published: &PublishedValue,
    outputs: &mut dyn Iterator<Item = &BoundOutput>,
    after: &AfterStep<'_>,
) -> (Datum, bool) {
    let (state, naming) = (after.machine.state(), after.machine.naming());
    let mut has_undef = false;
    let values = outputs.filter_map(|output| {
        let field = output.published()?.field.as_deref();
        let slot = output.slot(after);
        let value = slot.map_or(Datum::Null, |slot| datum_of(state.get(slot), &naming));
        has_undef |= value.is_null();
        Some((field, value))
    });
    let message = message_of(values, &published.key);
    (message, has_undef)
}

/// Publishes a message, and records it if the binding refers to the port. A message that does not fit the type of the port is
/// reported instead, because a reader of that type could not read it, or would read something else.
fn publish(
    port: Out<Datum>,
    message: Datum,
    written: &[WrittenPort],
    (recorded, published): PublicationRecord<'_>,
    cycle: &mut Cycle<'_>,
) {
    let written = written.iter().find(|it| it.port == port);
    if let Some(written) = written
        && let Err(mismatch) = written.schema.accepts(&message)
    {
        let what = format!("`{}`: {mismatch}", written.name);
        cycle.report(UNFIT_REPORT, Datum::text(what));
        return;
    }
    if let Some((name, _)) = recorded.iter().find(|(_, known)| *known == port) {
        published.insert(name.clone(), message.clone());
    }
    cycle.write(port, message);
}

/// Kind of the report that an action was skipped, with the name of the missing message.
pub const UNSENT_REPORT: &str = "asm/Unsent";

/// Kind of the report that a message was not sent because it does not fit the type of its port, with the port and the
/// mismatch.
pub const UNFIT_REPORT: &str = "asm/Unfit";

fn report_unsent(missing: &str, cycle: &mut Cycle<'_>) {
    cycle.report(UNSENT_REPORT, Datum::text(missing));
}

/// The reply to the caller on whose behalf a call was made.
fn forwarded_result(result: &Result<Datum, CallError>) -> Result<Datum, ServiceFault> {
    let fault = match result {
        Ok(_) => return Ok(Datum::Record(Vec::new())),
        Err(CallError::Fault(fault)) => return Err(fault.clone()),
        Err(CallError::Cancelled) => return Err(superseded_fault()),
        Err(error @ CallError::Timeout) => ("TIMEOUT", error),
        Err(error @ CallError::Unavailable) => ("UNAVAILABLE", error),
        Err(error @ CallError::Stopped) => ("STOPPED", error),
    };
    Err(ServiceFault::new(fault.0, fault.1.to_string()))
}
