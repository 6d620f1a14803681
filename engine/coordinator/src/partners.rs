//! Messages between a specification and services: the meaning of `r_wsend`, `r_wcall` and the like in a running system.
//!
//! An element of the specification with the name of a reference represents the service behind it: a message to the
//! element is a call through that reference. Requests to the component's own services have undef as their sender.
//! (SCA-ASM; T25 to T27 of the TCA paper.)

use crate::convert::{datum_of, value_of};
use crate::cycle_recorder::CycleRecorder;
use crate::misfit::{MisfitCauses, domain_text, shown};
use asmotion_component::{
    CallError, CallId, Cycle, Dynamic, Interface, NOTICE_REPORT, Provided, RequestId, Required,
    ServiceFault,
};
use asmotion_datum::Datum;
use asmotion_lang::Specification;
use asmotion_lang::ir::{DomainId, MessageRole, Program, ValueShape, message_uses};
use asmotion_lang::machine::{CallFault, Machine, MessageId, SentKind, SentMessage};
use asmotion_lang::simulate::{RecordedMessage, fault_name};
use asmotion_lang::value::{Atom, Value};
use serde::{Deserialize, Serialize};

/// Kind of the report that the reply to a call is not of the domain that the specification expects, a [`BadReply`].
pub const BAD_REPLY_REPORT: &str = "asm/BadReply";

/// A reply that is not of the expected domain. For the specification the call has failed.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct BadReply {
    /// Name of the reference.
    pub reference: String,
    /// Name of the operation.
    pub operation: String,
    /// Number of the call at the component.
    pub call: u64,
    /// The expected domain.
    pub expected: String,
    /// The beginning of the reply, as JSON.
    pub found: String,
}

impl BadReply {
    /// Returns the failure of the call.
    pub fn error(&self) -> CallError {
        let detail = format!("expected {}, found {}", self.expected, self.found);
        CallError::Fault(ServiceFault::new("BAD_REPLY", detail))
    }
}

/// Limit on the characters of a reply in a report.
const MAX_FOUND: usize = 100;

fn shortened(text: &str) -> String {
    match text.char_indices().nth(MAX_FOUND) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_owned(),
    }
}

/// The services that a specification exchanges messages with.
#[derive(Default)]
pub(crate) struct MessagePartners {
    pub partner_operations: Vec<PartnerOperation>,
    pub own_operations: Vec<OwnOperation>,
    /// Calls under way, with the messages that made them.
    pub calls: Vec<(CallId, PartnerCall)>,
    /// Open requests: the message, the position of the operation, and the request.
    pub requests: Vec<(MessageId, usize, RequestId)>,
    /// Causes for which requests have been refused, and which have been reported.
    pub causes: MisfitCauses,
}

/// An operation of a partner.
pub(crate) struct PartnerOperation {
    partner: Value,
    /// Name of the reference to the partner.
    pub reference: String,
    pub operation: String,
    handle: Required<Dynamic>,
    /// Expected shape of responses.
    response: ValueShape,
    /// Whether the specification expects replies to messages of this operation; calls always have them.
    expects_replies: bool,
}

/// An operation that the component provides.
pub(crate) struct OwnOperation {
    pub operation: String,
    handle: Provided<Dynamic>,
    argument: ValueShape,
}

/// Names of the only field of a record that is a value.
const VALUE_FIELDS: [&str; 2] = ["data", "code"];

/// A message that was sent as a call.
pub(crate) struct PartnerCall {
    pub message: MessageId,
    pub from: Value,
    /// `true` if the specification waits for the reply, `false` if it receives it as a message.
    pub is_synchronous: bool,
    pub operation_index: usize,
}

impl MessagePartners {
    /// Declares the operations that the specification uses: those it calls through references, and those it receives on
    /// services.
    pub fn declare(
        specification: &Specification,
        references: &[(String, String)],
        services: &[(String, String)],
        interface: &mut Interface,
    ) -> Self {
        let mut partners = Self::default();
        for used in message_uses(&specification.model) {
            let operation = operation_name(used.operation);
            match used.role {
                MessageRole::Ask => {
                    let Some((partner, name)) = element(used.partner, &specification.program)
                    else {
                        continue;
                    };
                    let Some((reference, service)) =
                        references.iter().find(|(known, _)| *known == name)
                    else {
                        continue;
                    };
                    partners.declare_partner_operation(
                        partner,
                        reference,
                        service,
                        operation,
                        specification,
                        interface,
                    );
                }
                MessageRole::Serve => {
                    partners.declare_own_operation(services, operation, specification, interface)
                }
            }
        }
        partners
    }

    fn declare_partner_operation(
        &mut self,
        partner: Value,
        reference: &str,
        service: &str,
        operation: &str,
        specification: &Specification,
        interface: &mut Interface,
    ) {
        let is_known =
            |asked: &PartnerOperation| asked.partner == partner && asked.operation == operation;
        if self.partner_operations.iter().any(is_known) {
            return;
        }
        let handle =
            interface.require_of(reference, service, operation, "called by the specification");
        let known = specification.program.operation(operation);
        self.partner_operations.push(PartnerOperation {
            partner,
            reference: reference.to_owned(),
            operation: operation.to_owned(),
            handle,
            response: known.gives,
            expects_replies: known.replies,
        });
    }

    fn declare_own_operation(
        &mut self,
        services: &[(String, String)],
        operation: &str,
        specification: &Specification,
        interface: &mut Interface,
    ) {
        if self
            .own_operations
            .iter()
            .any(|served| served.operation == operation)
        {
            return;
        }
        let argument = specification.program.operation(operation).takes;
        for (name, service) in services {
            let handle =
                interface.serve_of(name, service, operation, "served by the specification");
            self.own_operations.push(OwnOperation {
                operation: operation.to_owned(),
                handle,
                argument: argument.clone(),
            });
        }
    }

    /// Position of the operation that is at this position of a predecessor. Several services may provide an operation
    /// of one name; they have the same order in both.
    pub fn own_position(&self, before: &Self, position: usize) -> Option<usize> {
        let operation = &before.own_operations.get(position)?.operation;
        let earlier = before.own_operations.iter().take(position);
        let nth = earlier.filter(|it| it.operation == *operation).count();
        let own = self.own_operations.iter().enumerate();
        let mut own = own.filter(|(_, it)| it.operation == *operation);
        own.nth(nth).map(|(position, _)| position)
    }

    /// The agents that represent services; messages to them leave the specification.
    pub fn agents(&self) -> Vec<Value> {
        let mut agents: Vec<Value> = self
            .partner_operations
            .iter()
            .map(|asked| asked.partner.clone())
            .collect();
        if !self.own_operations.is_empty() {
            agents.push(Value::Undef);
        }
        agents
    }

    /// Delivers the messages of this cycle to the agents. Returns how many did not fit.
    pub fn receive(
        &mut self,
        cycle: &mut Cycle<'_>,
        machine: &mut Machine,
        recorder: &mut Option<CycleRecorder>,
    ) -> u64 {
        let mut misfits = 0;
        for (index, served) in self.own_operations.iter().enumerate() {
            for request in cycle.requests(served.handle) {
                let program = machine.program().clone();
                let Some(data) = served.argument(&request.argument, machine) else {
                    misfits += 1;
                    let cause = served.misfit(&request.argument, &program);
                    if let Some(cause) = self.causes.new_cause(|| cause.clone()) {
                        cycle.report(NOTICE_REPORT, Datum::text(cause));
                    }
                    let fault = ServiceFault::new("MISFIT", cause);
                    cycle.reply(served.handle, request.id, Err(fault));
                    continue;
                };
                if let Some(recorder) = recorder {
                    recorder.note_cause(&*served.operation);
                    let delivered = delivered(
                        &Value::Undef,
                        &Value::Undef,
                        &served.operation,
                        &data,
                        machine,
                    );
                    recorder.note_message(delivered);
                }
                let id = machine.deliver(Value::Undef, Value::Undef, &served.operation, data);
                if request.deadline.is_some() {
                    self.requests.push((id, index, request.id));
                }
            }
            let cancelled = cycle.cancelled(served.handle).to_vec();
            self.requests
                .retain(|(_, of, request)| *of != index || !cancelled.contains(request));
        }
        let mut ended_calls = Vec::new();
        for operation in &self.partner_operations {
            ended_calls.extend(cycle.replies(operation.handle));
        }
        for reply in ended_calls {
            let Some(at) = self.calls.iter().position(|(call, _)| *call == reply.call) else {
                continue;
            };
            let (number, call) = self.calls.swap_remove(at);
            if let Some(found) = self.complete(&call, reply.result, machine, recorder) {
                misfits += 1;
                let bad = self.bad_reply(number, &call, &found, machine.program());
                // a record of texts and numbers has a datum
                if let Ok(bad) = Datum::of(&bad) {
                    cycle.report(BAD_REPLY_REPORT, bad);
                }
            }
        }
        misfits
    }

    fn bad_reply(
        &self,
        number: CallId,
        call: &PartnerCall,
        found: &Datum,
        program: &Program,
    ) -> BadReply {
        let called = &self.partner_operations[call.operation_index];
        let name = |domain: DomainId| {
            let name = program.symbols.domains.get(domain.0 as usize);
            name.map_or_else(String::new, ToString::to_string)
        };
        let found = asmotion_datum::json::encode(found);
        BadReply {
            reference: called.reference.clone(),
            operation: called.operation.clone(),
            call: number.0,
            expected: called.response.domain_text(&name),
            found: shortened(&found.unwrap_or_else(|error| error.to_string())),
        }
    }

    /// Delivers the outcome of a call. Returns a response that does not fit; for the specification the call has failed.
    fn complete(
        &self,
        call: &PartnerCall,
        result: Result<Datum, CallError>,
        machine: &mut Machine,
        recorder: &mut Option<CycleRecorder>,
    ) -> Option<Datum> {
        let operation = &self.partner_operations[call.operation_index];
        let outcome = match &result {
            Ok(answer) => {
                let (shape, machine) = (&operation.response, &*machine);
                let data = content(answer, shape, machine.program());
                let data = data.filter(|it| machine.contains(shape, it));
                data.ok_or(CallFault::Failed)
            }
            Err(CallError::Timeout) => Err(CallFault::Timeout),
            Err(CallError::Unavailable | CallError::Stopped) => Err(CallFault::Unavailable),
            Err(CallError::Fault(_)) => Err(CallFault::Failed),
            Err(CallError::Cancelled) => Err(CallFault::Cancelled),
        };
        let misfit = result.ok().filter(|_| outcome.is_err());
        if let Some(recorder) = recorder {
            recorder.note_cause(format!("{}.{}", operation.reference, operation.operation));
            recorder.note_message(ended(call, operation, &outcome, machine));
        }
        match outcome {
            _ if call.is_synchronous => machine.end_call(call.message, outcome),
            Ok(data) => {
                machine.deliver(
                    operation.partner.clone(),
                    call.from.clone(),
                    &operation.operation,
                    data,
                );
            }
            Err(_) => machine.set_unsent(call.from.clone(), &operation.operation),
        }
        misfit
    }

    /// The operations of the calls under way, as `partner.operation`.
    pub fn pending_calls(&self) -> impl Iterator<Item = String> {
        let calls = self.calls.iter();
        calls.filter_map(|(_, call)| {
            let called = self.partner_operations.get(call.operation_index)?;
            Some(format!("{}.{}", called.reference, called.operation))
        })
    }

    /// Ends all calls as cancelled, because the component stops.
    pub fn stop(&mut self, machine: &mut Machine, recorder: &mut Option<CycleRecorder>) {
        for (_, call) in std::mem::take(&mut self.calls) {
            self.complete(&call, Err(CallError::Cancelled), machine, recorder);
        }
        // their callers are notified when the runtime closes the services
        self.requests.clear();
    }

    /// Sends the last step's messages to partners.
    pub fn send(&mut self, machine: &Machine, cycle: &mut Cycle<'_>) {
        for sent in machine.last_step().sent().iter().filter(|sent| sent.leaves) {
            match &sent.kind {
                SentKind::Message { data } => self.call(sent, data, false, machine, cycle),
                SentKind::Call { data, .. } => self.call(sent, data, true, machine, cycle),
                SentKind::Reply { data, to } => {
                    let mut requests = self.requests.iter();
                    let known = requests.position(|(message, ..)| Some(*message) == *to);
                    if let Some(known) = known {
                        let (_, served, request) = self.requests.remove(known);
                        let answer = datum_of(data, &machine.naming());
                        cycle.reply(self.own_operations[served].handle, request, Ok(answer));
                    }
                }
                SentKind::Cancel { call } => {
                    let mut calls = self.calls.iter();
                    if let Some(at) = calls.position(|(_, known)| known.message == *call) {
                        let (call, _) = self.calls.swap_remove(at);
                        cycle.cancel(call);
                    }
                }
            }
        }
    }

    fn call(
        &mut self,
        sent: &SentMessage,
        data: &Value,
        waits: bool,
        machine: &Machine,
        cycle: &mut Cycle<'_>,
    ) {
        let Value::Text(operation) = &sent.operation else {
            return;
        };
        let operation = operation_name(operation);
        let mut asked = self.partner_operations.iter();
        let Some(index) =
            asked.position(|asked| asked.partner == sent.to && asked.operation == operation)
        else {
            return;
        };
        let argument = datum_of(data, &machine.naming());
        let asked = &self.partner_operations[index];
        if !waits && !asked.expects_replies {
            cycle.call_one_way(asked.handle, argument);
            return;
        }
        let call = cycle.call(asked.handle, argument);
        let partner_call = PartnerCall {
            message: sent.id,
            from: sent.from.clone(),
            is_synchronous: waits,
            operation_index: index,
        };
        self.calls.push((call, partner_call));
    }
}

/// The record of a message that arrives for an agent.
fn delivered(
    from: &Value,
    to: &Value,
    operation: &str,
    data: &Value,
    machine: &Machine,
) -> RecordedMessage {
    let naming = machine.naming();
    let show = |value: &Value| value.show(&naming).to_string();
    RecordedMessage::Delivered {
        from: show(from),
        to: show(to),
        operation: operation.to_owned(),
        data: show(data),
    }
}

/// The record of the end of a call, as [`MessagePartners::complete`] passes it to the machine.
fn ended(
    call: &PartnerCall,
    operation: &PartnerOperation,
    outcome: &Result<Value, CallFault>,
    machine: &Machine,
) -> RecordedMessage {
    let show = |value: &Value| value.show(&machine.naming()).to_string();
    let name = operation.operation.clone();
    match outcome {
        Ok(data) if call.is_synchronous => RecordedMessage::Replied {
            call: call.message.0,
            operation: name,
            data: show(data),
        },
        Err(fault) if call.is_synchronous => RecordedMessage::Failed {
            call: call.message.0,
            fault: fault_name(*fault).to_owned(),
        },
        Ok(data) => delivered(&operation.partner, &call.from, &name, data, machine),
        Err(_) => RecordedMessage::Unsent {
            from: show(&call.from),
            operation: name,
        },
    }
}

fn operation_name(spelt: &str) -> &str {
    asmotion_lang::stdlib::operation(spelt)
}

/// The value and name of an element that a term denotes.
fn element(term: &asmotion_lang::hir::Term, program: &Program) -> Option<(Value, String)> {
    let asmotion_lang::hir::TermKind::Value(Value::Atom(atom)) = &*term.kind else {
        return None;
    };
    let Atom(index) = *atom;
    let name = program.symbols.atoms.get(index as usize)?;
    Some((Value::Atom(*atom), name.to_string()))
}

impl OwnOperation {
    fn argument(&self, datum: &Datum, machine: &Machine) -> Option<Value> {
        let shape = &self.argument;
        let data = request_content(&self.operation, datum, shape, machine.program());
        data.filter(|it| machine.contains(shape, it))
    }

    fn misfit(&self, found: &Datum, program: &Program) -> String {
        let (operation, found) = (&self.operation, shown(found));
        let domain = domain_text(&self.argument, program);
        format!("`{operation}` takes a value of the domain {domain}, found {found}")
    }
}

/// The content of a request. A record with one field stands for that field only if the field has the name of the operation or
/// that of a value: a misspelt name is not taken for another one.
fn request_content(
    operation: &str,
    datum: &Datum,
    shape: &ValueShape,
    program: &Program,
) -> Option<Value> {
    if let Datum::Record(fields) = datum
        && let [(name, _)] = fields.as_slice()
        && !matches!(shape, ValueShape::Map(..) | ValueShape::Any)
        && name != operation
        && !VALUE_FIELDS.contains(&&**name)
    {
        return None;
    }
    content(datum, shape, program)
}

/// The content of a message. An empty message is `true`, to distinguish it from no message, unless it has to have a value.
fn content(datum: &Datum, shape: &ValueShape, program: &Program) -> Option<Value> {
    let is_nothing = *datum == Datum::Null;
    let is_empty = matches!(datum, Datum::Record(fields) if fields.is_empty());
    if (is_empty || is_nothing) && matches!(shape, ValueShape::Any | ValueShape::Bool) {
        return Some(Value::Bool(true));
    }
    if is_nothing {
        return None;
    }
    value_of(datum, shape, program)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;

    #[test]
    fn a_request_with_a_misspelt_field_has_no_content() {
        let mut files = asmotion_lang::MemoryFiles::new();
        files.add("a.asm", "asm a\nsignature:\ndefinitions:\n");
        let program = asmotion_lang::open("a.asm", &files).unwrap().program;
        let content = |datum: Datum| request_content("job", &datum, &ValueShape::Int, &program);
        let field = |name: &'static str, value| Datum::record([(name, value)]);
        let seven = || Some(Value::Int(7));
        assert_eq!(content(Datum::Int(7)), seven());
        assert_eq!(content(field("job", Datum::Int(7))), seven());
        assert_eq!(content(field("data", Datum::Int(7))), seven());
        assert_eq!(content(field("bogus", Datum::Int(7))), None);
        let nested = field("request", field("bogus", Datum::Int(7)));
        assert_eq!(content(nested), None);
        assert_eq!(content(field("job", Datum::text("x"))), None);
    }
}
