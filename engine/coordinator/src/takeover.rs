//! Replacement of a running coordinator by one with another version of its specification or its bindings.
//!
//! The machine continues with the locations whose functions have the same name and signature in both versions. Inputs
//! keep their messages if their binding is the same; the others begin without one, and the dropped messages are listed. Calls
//! and requests under way are continued.

use crate::binding::{Monitored, Source};
use crate::coordinator::Coordinator;
use crate::cycle_recorder::{RecordedMachine, replacement};
use crate::event_queue::{EventSource, WaitingEvent};
use crate::inputs::{BoundInput, InputLocation};
use crate::partners::{MessagePartners, PartnerCall};
use crate::requests::WaitingCaller;
use asmotion_component::{Fault, Time};
use asmotion_lang::ir::{FunctionId, FunctionKind, Program};
use asmotion_lang::machine::{BackEnd, Correspondence, StepFault, TransferError};
use asmotion_lang::simulate;
use asmotion_lang::value::Value;
use std::collections::BTreeSet;

impl Coordinator {
    /// Continues in the state of another coordinator. Returns notes about the functions that do not keep their values, and about
    /// dropped messages.
    ///
    /// # Errors
    /// The state does not fit the specification, an invariant does not hold in it, or a call under way is not part of
    /// the binding.
    pub(crate) fn continue_from(
        &mut self,
        predecessor: &Self,
        now: Time,
    ) -> Result<Vec<String>, Fault> {
        let elements = self.machine.adopt_elements(&predecessor.machine);
        let dropped = self.keep_inputs(predecessor, &elements)?;
        self.keep_calls(predecessor, &elements)?;
        self.inbox.observe(now, &mut self.frame);
        let recorder = predecessor.recorder.as_ref().map(|recorder| {
            let origin = replacement(&self.machine, &self.frame, now);
            let agents = predecessor.partners.agents();
            let before = RecordedMachine {
                specification: &predecessor.prepared.specification,
                machine: &predecessor.machine,
                agents: &agents,
                watch: &predecessor.watcher.watch,
            };
            recorder.after(before, origin)
        });
        let (machine, frame) = (&mut self.machine, &mut self.frame);
        machine
            .continue_from(&predecessor.machine, &elements, frame, now.nanos())
            .map_err(|error| self.unfit_state(predecessor, &error))?;
        let checked = self.machine.check_invariants(&mut self.frame, now.nanos());
        checked.map_err(|fault| self.unfit_invariant(&fault))?;
        self.chooser = predecessor.chooser.clone();
        self.reported = predecessor.reported;
        self.recorder = recorder;
        self.last_write = predecessor.last_write.for_successor(&predecessor.machine);
        let unwatched = self.watcher.continue_from(&predecessor.watcher);
        if self.machine.steps() > 0 {
            self.update_timers(now)?;
        }
        // without native code, closures compute the same steps
        let _ = self.machine.set_back_end(BackEnd::Native);
        let mut notes = self.notes(predecessor, &elements);
        notes.extend(dropped);
        notes.extend(unwatched.into_iter().map(|property| {
            format!("`{property}` is not watched any more: the new version has no such property")
        }));
        Ok(notes)
    }

    fn unfit_state(&self, predecessor: &Self, error: &TransferError) -> Fault {
        match error {
            TransferError::Value {
                function,
                arguments,
                value,
            } => {
                let machine = &predecessor.machine;
                let location = simulate::applied(machine, *function, arguments);
                let naming = machine.naming();
                let value = value.show(&naming);
                Fault::new(format!(
                    "`{location}` is {value}, which does not exist in the new version"
                ))
            }
            TransferError::Message => Fault::new(
                "a message on its way names an element that does not exist in the new version",
            ),
            TransferError::Fault(fault) => self.explained(fault),
        }
    }

    /// Explains an invariant that does not hold in the state. No step has broken it.
    fn unfit_invariant(&self, fault: &StepFault) -> Fault {
        let mut finding = self.prepared.specification.explain_in(fault, &self.machine);
        let (step, when) = (fault.step, format!(" in step {}", fault.step));
        if let Some(broken) = finding.message.strip_suffix(&when) {
            finding.message =
                format!("{broken} in the state after step {step}, in which the new version begins");
            finding.helps =
                vec!["reconfigure in a state in which it holds, or change it".to_owned()];
        }
        self.rendered(&finding)
    }

    /// Keeps the messages of inputs whose bindings are the same in both versions. Returns notes about the others.
    fn keep_inputs(
        &mut self,
        predecessor: &Self,
        elements: &Correspondence,
    ) -> Result<Vec<String>, Fault> {
        let has_same_outputs = self.has_same_outputs(predecessor, elements);
        if predecessor.inbox.waiting_outcomes() > 0 && !has_same_outputs {
            return Err(Fault::new(
                "the outcome of a call waits for the next step, and the bindings of out functions differ: try again",
            ));
        }
        let (mut notes, mut kept) = (Vec::new(), BTreeSet::new());
        self.inbox.losses = predecessor.inbox.losses;
        self.inbox.dropped_elsewhere = predecessor.inbox.dropped_elsewhere;
        let (new, old) = (
            &self.prepared.binding.monitored,
            &predecessor.prepared.binding.monitored,
        );
        for (position, input) in self.inbox.inputs.iter_mut().enumerate() {
            let binding = new.get(position);
            let mut known = predecessor.inbox.inputs.iter().enumerate();
            let found = known.find(|(known, before)| {
                continues(old.get(*known), binding)
                    && elements.function(before.located.function) == Some(input.located.function)
                    && (binding.is_some() || has_same_location(input, before, elements))
            });
            match found {
                Some((known, before)) => {
                    kept.insert(known);
                    let unknown = keep_input(input, before, elements);
                    self.inbox.losses.misfits += unknown;
                    notes.extend(unknown_elements(before, unknown, predecessor));
                }
                // losses from before count for the predecessor
                None => input.lost.before = u64::MAX,
            }
        }
        for (position, before) in predecessor.inbox.inputs.iter().enumerate() {
            if !kept.contains(&position) {
                notes.extend(self.drop_messages(before, predecessor, elements));
            }
        }
        if self.inbox.waiting_outcomes() < predecessor.inbox.waiting_outcomes() {
            return Err(Fault::new(
                "the outcome of a call waits for the next step, and the location that takes it differs: try again",
            ));
        }
        Ok(notes)
    }

    /// Drops the messages of an input whose binding differs, and keeps its outcomes of calls. Returns notes about the messages.
    fn drop_messages(
        &mut self,
        before: &BoundInput,
        predecessor: &Self,
        elements: &Correspondence,
    ) -> Vec<String> {
        let function = elements.function(before.located.function);
        let reason = match function {
            Some(_) => "its binding differs",
            None => "the new version does not read it",
        };
        let mut notes = Vec::new();
        for location in &before.locations {
            let (machine, function_before) = (&predecessor.machine, before.located.function);
            let name = simulate::applied(machine, function_before, &location.arguments);
            if function.is_some() && before.remembers(location) {
                notes.push(format!("the last message of `{name}` is dropped: {reason}"));
            }
            if before.is_timed(location) {
                let begins = match function {
                    Some(function) if self.inbox.has_timer(function) => "begins anew",
                    Some(_) | None => "ends",
                };
                notes.push(format!("the timer of `{name}` {begins}: {reason}"));
            }
            let unread = before.unread(location);
            if unread > 0 {
                let (messages, are) = match unread {
                    1 => ("message", "is"),
                    _ => ("messages", "are"),
                };
                notes.push(format!(
                    "{unread} unread {messages} of `{name}` {are} dropped: {reason}"
                ));
                self.inbox.losses.dropped += unread;
                self.inbox.dropped_elsewhere += unread;
            }
            if let Some(function) = function {
                self.keep_outcomes(function, location, elements);
            }
        }
        notes
    }

    /// Keeps the outcomes of calls that wait for a location: they do not depend on the binding of its messages.
    fn keep_outcomes(
        &mut self,
        function: FunctionId,
        before: &InputLocation,
        elements: &Correspondence,
    ) {
        let arguments = before.arguments.iter().map(|it| elements.value(it));
        let Some(arguments) = arguments.collect::<Option<Vec<_>>>() else {
            return;
        };
        let inputs = self.inbox.inputs.iter_mut();
        let same = inputs.filter(|input| input.located.function == function);
        let mut locations = same.flat_map(|input| &mut input.locations);
        let Some(location) = locations.find(|it| it.arguments == arguments) else {
            return;
        };
        for event in before.waiting.iter() {
            let value = elements.value(&event.value);
            if let (EventSource::Outcome(output), Some(value)) = (event.source, value) {
                location.waiting.push_outcome(output, value);
            }
        }
    }

    /// Returns whether both versions bind the same out locations to the same effects.
    fn has_same_outputs(&self, predecessor: &Self, elements: &Correspondence) -> bool {
        let before = predecessor.outbox.locations().map(|(function, arguments)| {
            let arguments = arguments.iter().map(|it| elements.value(it));
            Some((
                elements.function(function)?,
                arguments.collect::<Option<Vec<Value>>>()?,
            ))
        });
        let after = self.outbox.locations();
        self.prepared.binding.out == predecessor.prepared.binding.out
            && before.eq(after.map(|(function, arguments)| Some((function, arguments.to_vec()))))
    }

    /// Continues the calls and requests under way.
    fn keep_calls(&mut self, predecessor: &Self, elements: &Correspondence) -> Result<(), Fault> {
        let has_same_outputs = self.has_same_outputs(predecessor, elements);
        for served in &predecessor.requests.served {
            let mut known = self.requests.served.iter_mut();
            match known.find(|it| it.operation == served.operation) {
                Some(known) => {
                    known.last.clone_from(&served.last);
                    known.open.clone_from(&served.open);
                }
                None if served.open.is_empty() => {}
                None => return Err(call_under_way(&served.operation.to_string())),
            }
        }
        for pending in &predecessor.outbox.pending {
            let refused = || call_under_way(&pending.outcome.operation().to_string());
            let caller = match pending.caller {
                None => None,
                Some(caller) => Some(self.caller(predecessor, caller).ok_or_else(refused)?),
            };
            let outcome = self.outbox.outcome(pending.outcome.number);
            let outcome = outcome.filter(|_| has_same_outputs).ok_or_else(refused)?;
            self.outbox.add_pending(pending.call, outcome, caller);
        }
        self.outbox.kept.clone_from(&predecessor.outbox.kept);
        self.outbox
            .published
            .clone_from(&predecessor.outbox.published);
        keep_partners(&mut self.partners, &predecessor.partners, elements)
    }

    fn caller(&self, predecessor: &Self, caller: WaitingCaller) -> Option<WaitingCaller> {
        let operation = &predecessor.requests.served.get(caller.served)?.operation;
        let served = self.requests.position(operation)?;
        Some(WaitingCaller {
            handle: self.requests.served.get(served)?.handle,
            served,
            request: caller.request,
        })
    }

    /// The functions that do not keep their values.
    fn notes(&self, predecessor: &Self, elements: &Correspondence) -> Vec<String> {
        let (before, after) = (predecessor.machine.program(), self.machine.program());
        let kept = (0..).zip(&before.functions);
        let kept = kept.filter_map(|(index, _)| elements.function(FunctionId(index)));
        let kept: BTreeSet<_> = kept.collect();
        let new = written(after).filter(|(id, _)| !kept.contains(id));
        let new = new.map(|(_, name)| format!("`{name}` begins with its initial value"));
        let dropped = written(before).filter(|(id, _)| elements.function(*id).is_none());
        let dropped = dropped.map(|(_, name)| format!("the value of `{name}` is dropped"));
        if self.machine.steps() == 0 {
            return Vec::new();
        }
        new.chain(dropped).collect()
    }
}

/// Iterates over the specification's own functions that rules update, with their names.
fn written(program: &Program) -> impl Iterator<Item = (FunctionId, &str)> {
    let all = (0..).zip(program.functions.iter().zip(&program.symbols.functions));
    let written = all.filter(|(_, (function, _))| {
        function.own
            && matches!(
                function.kind,
                FunctionKind::Controlled | FunctionKind::Out | FunctionKind::Shared
            )
    });
    written.map(|(index, (_, name))| (FunctionId(index), &**name))
}

/// Returns whether two inputs, which take outcomes of calls only, are the same location.
fn has_same_location(input: &BoundInput, before: &BoundInput, elements: &Correspondence) -> bool {
    let (Some(one), Some(other)) = (input.locations.first(), before.locations.first()) else {
        return false;
    };
    let translated = other.arguments.iter().map(|it| elements.value(it));
    translated.eq(one.arguments.iter().cloned().map(Some))
}

/// Returns whether an input with the second binding continues one with the first. A timer continues with another time, because
/// its condition has held for as long as before.
fn continues(before: Option<&Monitored>, after: Option<&Monitored>) -> bool {
    let (Some(before), Some(after)) = (before, after) else {
        return before == after;
    };
    let has_same_condition = matches!(
        (&before.from, &after.from),
        (Source::Timer { running, .. }, Source::Timer { running: other, .. }) if running == other
    );
    before == after || has_same_condition && before.location == after.location
}

/// Describes the waiting messages that name an element which does not exist any more.
fn unknown_elements(before: &BoundInput, count: u64, predecessor: &Coordinator) -> Option<String> {
    let name = before.name(predecessor.machine.program());
    let (messages, are) = match count {
        0 => return None,
        1 => ("message", "is"),
        _ => ("messages", "are"),
    };
    Some(format!(
        "{count} unread {messages} of `{name}` {are} dropped: the new version lacks an element in them"
    ))
}

/// Returns the number of waiting messages that name an element which does not exist any more.
fn keep_input(input: &mut BoundInput, before: &BoundInput, elements: &Correspondence) -> u64 {
    let mut unknown = 0;
    input.lost = before.lost;
    input.reported_key = before.reported_key;
    input.reported_expiry = before.reported_expiry;
    input.causes = before.causes.clone();
    if let (Some(condition), Some(before)) = (&mut input.matching, &before.matching) {
        condition.expected.clone_from(&before.expected);
        condition.reported = before.reported;
    }
    for before in &before.locations {
        let arguments = before.arguments.iter().map(|it| elements.value(it));
        let arguments = arguments.collect::<Option<Vec<_>>>();
        let mut known = input.locations.iter_mut();
        let Some(location) = known.find(|it| Some(&it.arguments) == arguments.as_ref()) else {
            unknown += before.waiting.messages() as u64;
            continue;
        };
        location.newest = before.newest;
        location.has_received = before.has_received;
        location.last = before.last.as_ref().and_then(|it| elements.value(it));
        let waiting = before.waiting.iter();
        let waiting = waiting.filter_map(|event| {
            let value = elements.value(&event.value)?;
            Some(WaitingEvent {
                value,
                ..event.clone()
            })
        });
        location.waiting = waiting.collect();
        unknown += (before.waiting.messages() - location.waiting.messages()) as u64;
    }
    unknown
}

/// Continues the calls to and the requests of partners.
fn keep_partners(
    partners: &mut MessagePartners,
    before: &MessagePartners,
    elements: &Correspondence,
) -> Result<(), Fault> {
    for (call, made) in &before.calls {
        let Some(called) = before.partner_operations.get(made.operation_index) else {
            continue;
        };
        let refused = || call_under_way(&format!("{}.{}", called.reference, called.operation));
        let mut known = partners.partner_operations.iter();
        let index = known
            .position(|it| it.reference == called.reference && it.operation == called.operation);
        let call_made = PartnerCall {
            message: made.message,
            from: elements.value(&made.from).ok_or_else(refused)?,
            is_synchronous: made.is_synchronous,
            operation_index: index.ok_or_else(refused)?,
        };
        partners.calls.push((*call, call_made));
    }
    for (message, served, request) in &before.requests {
        let Some(position) = partners.own_position(before, *served) else {
            let operation = before.own_operations.get(*served);
            let operation = operation.map_or("", |it| &it.operation);
            return Err(call_under_way(operation));
        };
        partners.requests.push((*message, position, *request));
    }
    Ok(())
}

fn call_under_way(operation: &str) -> Fault {
    Fault::new(format!(
        "a call of `{operation}` is under way that the new version does not continue: try again when it has ended"
    ))
}
