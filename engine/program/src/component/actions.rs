//! A cycle as a request, and its reply as actions.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use asmotion_component::{
    CallError, CallId, Cycle, LOG_REPORT, RequestId, ServiceFault, Setup, Time, unreadable,
};
use asmotion_datum::Datum;

use super::ProgramComponent;
use crate::error::ProgramError;
use crate::reply::{count_of, fault, fitting, list_of, pair, text_of, value_of};
use crate::request::ProgramRequest;

/// Requests and calls that have begun and not ended, and the state of the inputs that the program knows.
#[derive(Debug, Default)]
pub(super) struct OpenExchanges {
    /// Taken requests by the number that the program sees: operation, number at the provider, and deadline.
    pub requests: BTreeMap<u64, OpenRequest>,
    /// Number of requests so far.
    pub last_request: u64,
    /// Calls under way by the program's number.
    pub calls: BTreeMap<u64, OpenCall>,
    /// Losses that the program knows, by position of the input.
    pub lost: Vec<u64>,
    /// Property values that the program knows.
    pub properties: Vec<Datum>,
}

/// A request that the program has not answered.
#[derive(Debug, Clone)]
pub(super) struct OpenRequest {
    /// Position of the operation.
    pub operation: usize,
    pub id: RequestId,
    pub deadline: Option<Time>,
}

/// A call of the program that has not ended.
#[derive(Debug, Clone)]
pub(super) struct OpenCall {
    /// Position of the operation.
    pub operation: usize,
    pub id: CallId,
}

/// Limits the lines of a program's output that are reported: `RATE` in a second of the engine's time, and up to `BURST` at
/// once.
#[derive(Debug)]
pub(super) struct LineBudget {
    left: f64,
    at: Time,
}

/// Lines in a second.
const RATE: f64 = 20.0;
/// Lines at once.
const BURST: f64 = 100.0;

impl Default for LineBudget {
    fn default() -> Self {
        Self {
            left: BURST,
            at: Time::ZERO,
        }
    }
}

impl LineBudget {
    /// The number of lines that may be reported now.
    fn lines(&mut self, now: Time) -> usize {
        self.left = (self.left + RATE * now.since(self.at).as_secs_f64()).min(BURST);
        self.at = now;
        self.left as usize
    }
}

/// A number as data.
pub(super) fn number(number: u64) -> Datum {
    Datum::Int(i64::try_from(number).unwrap_or(i64::MAX))
}

impl ProgramComponent {
    /// The values of all properties by name, which the program knows from now on.
    pub(super) fn configured_properties(&mut self, setup: &Setup<'_>) -> Vec<(String, Datum)> {
        let declared = &self.declaration.declaration.properties;
        let properties = self.handles.properties.iter().zip(declared);
        let values: Vec<(String, Datum)> = properties
            .map(|((name, handle), declared)| {
                let value = setup.property(*handle);
                // the value has been checked
                let complete = declared.schema.complete(value.clone());
                (name.clone(), complete.unwrap_or(value))
            })
            .collect();
        self.open.properties = values.iter().map(|(_, value)| value.clone()).collect();
        self.open.lost = vec![0; self.handles.inputs.len()];
        values
    }

    /// The request of a cycle.
    pub(super) fn cycle_request(
        &mut self,
        cycle: &mut Cycle<'_>,
        kind: &'static str,
    ) -> ProgramRequest {
        let mut inputs = Vec::new();
        let mut stale = Vec::new();
        let mut lost = Vec::new();
        let declared = &self.declaration.declaration.inputs;
        let inputs_of = self.handles.inputs.iter().zip(declared);
        for (index, ((name, port), declared)) in inputs_of.enumerate() {
            let arrived = cycle.all(*port);
            let samples = arrived
                .iter()
                .filter_map(|it| declared.schema.complete(it.clone()).ok());
            let samples: Vec<Datum> = samples.collect();
            // written by a program or over a bus, and of another shape
            let misfits = arrived.len() - samples.len();
            cycle.count_lost(*port, misfits as u64);
            if !samples.is_empty() {
                let mut input = vec![("samples", Datum::List(samples))];
                let written_at = cycle.written_at(*port);
                input.extend(written_at.map(|at| ("written_at", Datum::Int(at.nanos()))));
                inputs.push((name.clone(), Datum::record(input)));
            }
            if cycle.is_stale(*port) {
                stale.push(Datum::text(name));
            }
            let count = cycle.lost(*port);
            if self.open.lost.get(index) != Some(&count) {
                lost.push((name.clone(), number(count)));
                if let Some(known) = self.open.lost.get_mut(index) {
                    *known = count;
                }
            }
        }
        let properties = self.changed_properties(cycle);
        let replies = self.ended_calls(cycle);
        self.timed(cycle, kind)
            .put_some("inputs", Datum::record(inputs))
            .put_some("stale", Datum::List(stale))
            .put_some("lost", Datum::record(lost))
            .put_some("properties", Datum::record(properties))
            .put_some("replies", Datum::List(replies))
    }

    /// The request that a stopped component answers.
    pub(super) fn serve_request(&mut self, cycle: &mut Cycle<'_>) -> ProgramRequest {
        self.timed(cycle, "serve")
    }

    /// The keys of all requests with requests of services.
    fn timed(&mut self, cycle: &mut Cycle<'_>, kind: &'static str) -> ProgramRequest {
        let cancelled = self.cancelled(cycle);
        let requests = self.new_requests(cycle);
        ProgramRequest::of(kind)
            .put("now", cycle.now().nanos())
            .put("number", number(cycle.number()))
            .put_some("requests", Datum::List(requests))
            .put_some("cancelled", Datum::List(cancelled))
    }

    fn changed_properties(&mut self, cycle: &Cycle<'_>) -> Vec<(String, Datum)> {
        let mut changed = Vec::new();
        let declared = &self.declaration.declaration.properties;
        let handles = self.handles.properties.iter().zip(declared);
        for (((name, handle), declared), known) in handles.zip(&mut self.open.properties) {
            let value = cycle.property(*handle);
            let value = declared.schema.complete(value.clone()).unwrap_or(value);
            if value != *known {
                known.clone_from(&value);
                changed.push((name.clone(), value));
            }
        }
        changed
    }

    fn new_requests(&mut self, cycle: &mut Cycle<'_>) -> Vec<Datum> {
        let mut requests = Vec::new();
        for (position, served) in self.handles.services.iter().enumerate() {
            for request in cycle.requests(served.handle) {
                let argument = match served.operation.request.complete(request.argument) {
                    Ok(argument) => argument,
                    Err(error) => {
                        let fault = unreadable("BAD_ARGUMENT", &error);
                        cycle.reply(served.handle, request.id, Err(fault));
                        continue;
                    }
                };
                self.open.last_request += 1;
                let id = self.open.last_request;
                let mut entries = vec![
                    ("id", number(id)),
                    ("service", Datum::text(&served.port)),
                    ("operation", Datum::text(&served.operation.name)),
                    ("argument", argument),
                    ("caller", Datum::text(&*request.caller)),
                ];
                if let Some(deadline) = request.deadline {
                    entries.push(("deadline", Datum::Int(deadline.nanos())));
                    let open = OpenRequest {
                        operation: position,
                        id: request.id,
                        deadline: request.deadline,
                    };
                    self.open.requests.insert(id, open);
                }
                requests.push(Datum::record(entries));
            }
        }
        requests
    }

    /// The requests whose callers no longer wait. They are forgotten, like those whose deadline has passed.
    fn cancelled(&mut self, cycle: &Cycle<'_>) -> Vec<Datum> {
        let mut cancelled = BTreeSet::new();
        for (id, open) in &self.open.requests {
            let Some(served) = self.handles.services.get(open.operation) else {
                continue;
            };
            let is_late = open.deadline.is_some_and(|deadline| deadline < cycle.now());
            if is_late || cycle.cancelled(served.handle).contains(&open.id) {
                cancelled.insert(*id);
            }
        }
        self.open.requests.retain(|id, _| !cancelled.contains(id));
        cancelled.into_iter().map(number).collect()
    }

    fn ended_calls(&mut self, cycle: &mut Cycle<'_>) -> Vec<Datum> {
        let mut ended = Vec::new();
        for called in &self.handles.references {
            for reply in cycle.replies(called.handle) {
                let mut calls = self.open.calls.iter();
                let Some(call) = calls.find(|(_, open)| open.id == reply.call) else {
                    continue;
                };
                let call = *call.0;
                self.open.calls.remove(&call);
                let response = &called.operation.response;
                let result = reply.result.and_then(|result| {
                    let complete = response.complete(result);
                    complete.map_err(|error| CallError::Fault(unreadable("BAD_REPLY", &error)))
                });
                ended.push((call, result));
            }
        }
        ended.sort_by_key(|(call, _)| *call);
        let ended = ended.into_iter().map(|(call, result)| {
            let end = match result {
                Ok(result) => ("result", result),
                Err(error) => ("error", error_datum(&error)),
            };
            Datum::record([("call", number(call)), end])
        });
        ended.collect()
    }

    /// Carries out the actions of a reply. Its samples are this old: the program may have waited for the cycle.
    pub(super) fn carry_out(
        &mut self,
        cycle: &mut Cycle<'_>,
        done: &Datum,
        age: Duration,
    ) -> Result<(), ProgramError> {
        for output in list_of(done, "outputs")? {
            let (name, sample) = pair(output, "outputs")?;
            let Some((port, schema)) = self.handles.outputs.get(name) else {
                return Err(undeclared("output", name));
            };
            let sample = fitting(schema, sample, &format!("a sample of output `{name}`"))?;
            cycle.write_aged(*port, sample, age);
        }
        for call in list_of(done, "calls")? {
            self.call(cycle, call)?;
        }
        for call in list_of(done, "cancel")? {
            let call = call.as_int().and_then(|it| u64::try_from(it).ok());
            if let Some(open) = call.and_then(|call| self.open.calls.get(&call)) {
                cycle.cancel(open.id);
            }
        }
        for reply in list_of(done, "replies")? {
            self.reply(cycle, reply)?;
        }
        for report in list_of(done, "reports")? {
            let (kind, value) = pair(report, "reports")?;
            cycle.report(report_kind(kind)?, value.clone());
        }
        self.adjust(cycle, done)
    }

    /// Carries out the actions that concern the cycle itself.
    fn adjust(&self, cycle: &mut Cycle<'_>, done: &Datum) -> Result<(), ProgramError> {
        let wants_cycle = value_of(done, "again").and_then(Datum::as_bool) == Some(true);
        if wants_cycle || self.session()?.take_wake() {
            cycle.request_cycle();
        }
        if let Some(at) = value_of(done, "at").filter(|it| !it.is_null()) {
            let at = at.as_int().ok_or_else(|| {
                ProgramError::protocol("`at` is not an integer, a time in nanoseconds")
            })?;
            cycle.request_cycle_at(Time::from_nanos(at));
        }
        if let Some(period) = count_of(done, "period")? {
            cycle.set_period(Duration::from_nanos(period));
        }
        if let Some(duration) = count_of(done, "duration")? {
            cycle.set_duration(Duration::from_nanos(duration));
        }
        if let Some(error) = value_of(done, "error").filter(|it| !it.is_null()) {
            cycle.error(fault(error).into());
        }
        Ok(())
    }

    fn call(&mut self, cycle: &mut Cycle<'_>, call: &Datum) -> Result<(), ProgramError> {
        let text = |key| text_of(call, key).unwrap_or_default();
        let (reference, operation) = (text("reference"), text("operation"));
        let is_called = |it: &&_| {
            let it: &crate::declaration::DeclaredOperation<_> = it;
            it.port == reference && it.operation.name == operation
        };
        let mut references = self.handles.references.iter();
        let Some(position) = references.position(|it| is_called(&it)) else {
            return Err(undeclared("operation", &format!("{reference}.{operation}")));
        };
        let called = &self.handles.references[position];
        let argument = value_of(call, "argument").cloned().unwrap_or_default();
        let place = format!("the argument of a call of `{reference}.{operation}`");
        let argument = fitting(&called.operation.request, &argument, &place)?;
        if value_of(call, "one_way").and_then(Datum::as_bool) == Some(true) {
            cycle.call_one_way(called.handle, argument);
            return Ok(());
        }
        let Some(key) = count_of(call, "call")? else {
            return Err(ProgramError::protocol("a call has no `call`, its number"));
        };
        if self.open.calls.contains_key(&key) {
            return Err(ProgramError::Protocol(format!(
                "the number {key} of a call is in use"
            )));
        }
        let id = cycle.call(called.handle, argument);
        let operation = position;
        self.open.calls.insert(key, OpenCall { operation, id });
        Ok(())
    }

    fn reply(&mut self, cycle: &mut Cycle<'_>, reply: &Datum) -> Result<(), ProgramError> {
        let Some(id) = count_of(reply, "id")? else {
            return Err(ProgramError::protocol("a reply has no `id`"));
        };
        let Some(open) = self.open.requests.remove(&id) else {
            // one-way, or its caller no longer waits
            let is_known = id <= self.open.last_request;
            return is_known.then_some(()).ok_or_else(|| {
                ProgramError::Protocol(format!("there is no request with the `id` {id}"))
            });
        };
        let Some(served) = self.handles.services.get(open.operation) else {
            return Ok(());
        };
        let result = match value_of(reply, "fault") {
            Some(fault) => {
                let text = |key| text_of(fault, key).unwrap_or_default();
                Err(ServiceFault::new(text("code"), text("text")))
            }
            None => {
                let result = value_of(reply, "result").cloned().unwrap_or_default();
                let (service, operation) = (&served.port, &served.operation.name);
                let place = format!("the result of `{service}.{operation}`");
                Ok(fitting(&served.operation.response, &result, &place)?)
            }
        };
        cycle.reply(served.handle, open.id, result);
        Ok(())
    }

    /// Reports the lines that the program has printed.
    pub(super) fn report_lines(&mut self, cycle: &mut Cycle<'_>) {
        let Some(session) = &self.session else {
            return;
        };
        let (lines, left_out) = session.take_lines(self.budget.lines(cycle.now()));
        self.budget.left -= lines.len() as f64;
        for line in lines {
            cycle.report(LOG_REPORT, Datum::text(line));
        }
        if left_out > 0 {
            let text = format!("… {left_out} more lines");
            cycle.report(LOG_REPORT, Datum::text(text));
        }
    }
}

fn undeclared(kind: &str, name: &str) -> ProgramError {
    ProgramError::Protocol(format!("the {kind} `{name}` is not declared"))
}

/// The end of a call as data.
fn error_datum(error: &CallError) -> Datum {
    let kind = |kind: &str| vec![("kind", Datum::text(kind))];
    Datum::record(match error {
        CallError::Timeout => kind("timeout"),
        CallError::Unavailable => kind("unavailable"),
        CallError::Stopped => kind("stopped"),
        CallError::Cancelled => kind("cancelled"),
        CallError::Fault(fault) => {
            let mut entries = kind("fault");
            entries.push(("code", Datum::text(&fault.code)));
            entries.push(("text", Datum::text(&fault.detail)));
            entries
        }
    })
}

/// Greatest number of kinds of reports of all programs of a process, which are kept until its end.
const MOST_KINDS: usize = 1000;

/// Longest kind of a report in bytes.
const LONGEST_KIND: usize = 64;

/// The kind of a report with the lifetime that observers expect.
fn report_kind(kind: &str) -> Result<&'static str, ProgramError> {
    static KINDS: Mutex<BTreeSet<&'static str>> = Mutex::new(BTreeSet::new());
    let mut kinds = KINDS.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(known) = kinds.get(kind) {
        return Ok(known);
    }
    if kind.len() > LONGEST_KIND || kinds.len() >= MOST_KINDS {
        return Err(ProgramError::Protocol(format!(
            "a kind of reports is longer than {LONGEST_KIND} bytes, or there are more than {MOST_KINDS} kinds"
        )));
    }
    let kept: &'static str = Box::leak(kind.to_owned().into_boxed_str());
    kinds.insert(kept);
    Ok(kept)
}
