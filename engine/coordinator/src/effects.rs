//! Turns updates of out functions into messages and calls.

use crate::bind_error::BindError;
use crate::binding::{Action, Argument, Binding, BoundOperation, Effect, PublishWhen, Published};
use crate::convert::{datum_of, literal_value};
use crate::inputs::MessageInputs;
use crate::requests::{Requests, WaitingCaller, superseded_fault};
use asmotion_component::{
    CallError, CallId, Cycle, Dynamic, In, Out, Reply, Required, ServiceFault,
};
use asmotion_datum::Datum;
use asmotion_lang::Specification;
use asmotion_lang::ir::{FunctionId, ValueShape};
use asmotion_lang::machine::{Machine, Step};
use asmotion_lang::value::Value;
use std::borrow::Cow;
use std::collections::BTreeMap;

/// The handles of a component, by name.
#[derive(Default)]
pub(crate) struct EffectHandles {
    pub inputs: Vec<(String, In<Datum>)>,
    pub outputs: Vec<(String, Out<Datum>)>,
    pub operations: Vec<(BoundOperation, Required<Dynamic>)>,
}

/// The bound out functions of a specification, and their calls under way.
pub(crate) struct EffectOutbox {
    outputs: Vec<BoundOutput>,
    /// Responses by the names under which they are kept.
    pub kept: BTreeMap<String, Datum>,
    pub pending: Vec<PendingOutcome>,
    ports: Vec<(String, In<Datum>)>,
    operations: Vec<Required<Dynamic>>,
}

struct BoundOutput {
    function: FunctionId,
    effect: BoundEffect,
}

enum BoundEffect {
    Publish {
        port: Out<Datum>,
        field: Option<String>,
        when: PublishWhen,
    },
    Literals(Vec<(Value, Vec<BoundAction>)>),
}

enum BoundAction {
    Publish {
        port: Out<Datum>,
        value: Argument,
    },
    Call {
        operation: Required<Dynamic>,
        with: Argument,
        outcome: OutcomeEffect,
    },
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
    /// The out function whose update made the call; a later update of it cancels the call.
    function: FunctionId,
    keep: Option<String>,
    /// Position of the input that takes the event.
    event: Option<usize>,
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
    fn fail(&self, inbox: &mut MessageInputs) {
        if let (Some(input), Some(event)) = (self.event, self.failed.clone()) {
            inbox.push(input, event, self.function);
        }
    }
}

impl EffectOutbox {
    pub fn new(
        binding: &Binding,
        specification: &Specification,
        handles: EffectHandles,
        inbox: &mut MessageInputs,
    ) -> Result<Self, BindError> {
        let mut outs = Vec::new();
        for out in &binding.out {
            let unknown = || BindError::UnknownFunction {
                function: out.function.clone(),
            };
            let function = specification
                .function(&out.function, 0)
                .ok_or_else(unknown)?;
            let effect = match &out.effect {
                Effect::Publish(Published { port, field, when }) => BoundEffect::Publish {
                    port: handles.output(port)?,
                    field: field.clone(),
                    when: *when,
                },
                Effect::Literals(cases) => {
                    let mut bound = Vec::new();
                    for case in cases {
                        let literal =
                            literal(&out.function, &case.literal, function, specification)?;
                        let actions = case.actions.iter();
                        let actions = actions
                            .map(|action| handles.action(action, function, specification, inbox));
                        bound.push((literal, actions.collect::<Result<Vec<_>, _>>()?));
                    }
                    BoundEffect::Literals(bound)
                }
            };
            outs.push(BoundOutput { function, effect });
        }
        for (number, outcome) in outcomes(&mut outs).enumerate() {
            outcome.number = number;
        }
        let operations = handles
            .operations
            .iter()
            .map(|(_, operation)| *operation)
            .collect();
        Ok(Self {
            outputs: outs,
            kept: BTreeMap::new(),
            pending: Vec::new(),
            ports: handles.inputs,
            operations,
        })
    }

    /// Handles the calls that have ended: keeps responses, and turns outcomes into events.
    pub fn receive(&mut self, cycle: &mut Cycle<'_>, inbox: &mut MessageInputs) {
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
                    Err(CallError::Unavailable) => outcome.unavailable.or(outcome.failed),
                    Err(CallError::Fault(fault)) => {
                        let mut faults = outcome.faults.into_iter();
                        let known = faults.find(|(code, _)| *code == fault.code);
                        known.map(|(_, literal)| literal).or(outcome.failed)
                    }
                    Err(CallError::Cancelled) => None,
                };
                if let (Some(input), Some(event)) = (outcome.event, event) {
                    inbox.push(input, event, outcome.function);
                }
            }
        }
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
        machine: &Machine,
        step: &Step<'_>,
        cycle: &mut Cycle<'_>,
        inbox: &mut MessageInputs,
        requests: &mut Requests,
    ) {
        for out in &self.outputs {
            let slot = machine.state().slot(machine.program(), out.function, &[]);
            let update = step
                .updates()
                .iter()
                .zip(step.before())
                .find(|(update, _)| Some(update.slot) == slot);
            match &out.effect {
                BoundEffect::Publish { port, field, when } => {
                    let is_due = match (when, &update) {
                        (PublishWhen::EveryStep, _) | (PublishWhen::OnUpdate, Some(_)) => true,
                        (PublishWhen::OnChange, Some((update, before))) => update.value != **before,
                        (PublishWhen::OnUpdate | PublishWhen::OnChange, None) => false,
                    };
                    if let (true, Some(slot)) = (is_due, slot) {
                        let value = datum_of(machine.state().get(slot), &machine.naming());
                        let message = match field {
                            Some(field) => Datum::record([(field.clone(), value)]),
                            None => value,
                        };
                        cycle.write(*port, message);
                    }
                }
                BoundEffect::Literals(cases) => {
                    let Some((update, _)) = update else { continue };
                    let is_answered =
                        |pending: &mut PendingOutcome| pending.outcome.function == out.function;
                    for pending in self.pending.extract_if(.., is_answered) {
                        cycle.cancel(pending.call);
                        if let Some(caller) = pending.caller {
                            cycle.reply(caller.handle, caller.request, Err(superseded_fault()));
                        }
                    }
                    inbox.remove_outcomes(out.function);
                    let case = cases.iter().find(|(literal, _)| *literal == update.value);
                    for action in case.into_iter().flat_map(|(_, actions)| actions) {
                        match action {
                            BoundAction::Publish { port, value } => {
                                match evaluate(value, &self.context(requests), cycle) {
                                    Ok(message) => cycle.write(*port, message),
                                    Err(missing) => report_unsent(&missing, cycle),
                                }
                            }
                            BoundAction::Call {
                                operation,
                                with,
                                outcome,
                            } => match evaluate(with, &self.context(requests), cycle) {
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

/// Iterates over the outcome effects of the calls in a binding.
fn outcomes(outputs: &mut [BoundOutput]) -> impl Iterator<Item = &mut OutcomeEffect> {
    let cases = outputs.iter_mut().flat_map(|out| match &mut out.effect {
        BoundEffect::Literals(cases) => cases.as_mut_slice(),
        BoundEffect::Publish { .. } => &mut [],
    });
    cases
        .flat_map(|(_, actions)| actions)
        .filter_map(|action| match action {
            BoundAction::Call { outcome, .. } => Some(outcome),
            BoundAction::Publish { .. } => None,
        })
}

impl EffectOutbox {
    /// Returns the outcome effect of the call at this position.
    pub fn outcome(&mut self, number: usize) -> Option<OutcomeEffect> {
        outcomes(&mut self.outputs).nth(number).cloned()
    }

    fn context<'k>(&'k self, requests: &'k Requests) -> EffectContext<'k> {
        EffectContext {
            kept: &self.kept,
            ports: &self.ports,
            requests,
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

    fn action(
        &self,
        action: &Action,
        function: FunctionId,
        specification: &Specification,
        inbox: &mut MessageInputs,
    ) -> Result<BoundAction, BindError> {
        match action {
            Action::Publish { port, value } => Ok(BoundAction::Publish {
                port: self.output(port)?,
                value: value.clone(),
            }),
            Action::Call(call) => {
                let mut operations = self.operations.iter();
                let found = operations.find(|(known, _)| *known == call.operation);
                let Some((_, operation)) = found else {
                    return Err(BindError::UnknownOperation(call.operation.clone()));
                };
                let event = match &call.event {
                    Some(event) => Some(inbox.event(event, specification)?),
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
                    function,
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
                    with: call.with.clone(),
                    outcome,
                })
            }
        }
    }
}

fn literal(
    name: &str,
    literal: &str,
    function: FunctionId,
    specification: &Specification,
) -> Result<Value, BindError> {
    let program = &specification.program;
    let value = match program
        .functions
        .get(function.0 as usize)
        .map(|function| &function.codomain)
    {
        Some(ValueShape::Domain(domain)) => literal_value(literal, *domain, program),
        Some(ValueShape::Bool) => literal.parse().ok().map(Value::Bool),
        Some(ValueShape::Int | ValueShape::Natural) => literal.parse().ok().map(Value::Int),
        Some(ValueShape::Text) => Some(Value::text(literal)),
        _ => None,
    };
    value.ok_or_else(|| BindError::NotAValue {
        function: name.to_owned(),
        value: literal.to_owned(),
    })
}

/// Kind of the report that an action was skipped, with the name of the missing message.
pub const UNSENT_REPORT: &str = "asm/Unsent";

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
    };
    Err(ServiceFault::new(fault.0, fault.1.to_string()))
}

/// The sources of message contents.
struct EffectContext<'k> {
    /// Responses by the names under which they are kept.
    kept: &'k BTreeMap<String, Datum>,
    ports: &'k [(String, In<Datum>)],
    requests: &'k Requests,
}

impl EffectContext<'_> {
    /// The kept response, the newest message or the newest request with this name.
    fn datum<'k>(&'k self, name: &str, cycle: &'k Cycle<'_>) -> Option<&'k Datum> {
        let received = || {
            let (_, port) = self.ports.iter().find(|(port, _)| port == name)?;
            cycle.read(*port).any()
        };
        let kept = self.kept.get(name).or_else(received);
        kept.or_else(|| self.requests.last(name))
    }
}

/// Builds a message or request.
///
/// # Errors
/// The name of a response, port or service without data yet. Zeros in their place would look like real data.
fn evaluate(
    argument: &Argument,
    context: &EffectContext<'_>,
    cycle: &Cycle<'_>,
) -> Result<Datum, String> {
    match argument {
        Argument::Value(value) => Ok(value.datum.clone()),
        Argument::Record(fields) => {
            let compose_field = |(name, field): &(String, Argument)| {
                Ok((name.clone(), evaluate(field, context, cycle)?))
            };
            let fields = fields
                .iter()
                .map(compose_field)
                .collect::<Result<Vec<_>, String>>()?;
            Ok(Datum::record(fields))
        }
        Argument::Kept { name, path } => {
            let datum = context.datum(name, cycle);
            let part = match path {
                Some(path) => datum.and_then(|whole| whole.get(path)),
                None => datum.map(Cow::Borrowed),
            };
            part.map(Cow::into_owned).ok_or_else(|| match path {
                Some(path) => format!("{name}.{path}"),
                None => name.clone(),
            })
        }
    }
}
