//! Operations of the bridge that services and actions of ROS carry out.

use std::collections::BTreeMap;
use std::time::Duration;

use asmotion_bridge::{Conversion, Use};
use asmotion_component::{
    Cycle, Dynamic, Interface, Out, Provided, Request, RequestId, ServiceFault, Time,
};
use asmotion_datum::{Datum, DatumError, Schema, Shape};

use crate::misfits::Misfits;
use crate::operation::{
    BAD_ARGUMENT, BAD_REPLY, CallProgress, LOST, MappedFeedback, MappedOperation, OperationCaller,
    OperationSchemas,
};

/// Time for a one-way request to a service, whose caller gives none.
const ONE_WAY: Duration = Duration::from_secs(10);

/// An operation that ROS carries out.
pub(crate) struct CalledOperation {
    pub(crate) mapped: MappedOperation,
    served: Provided<Dynamic>,
    cancel: Option<Provided<Dynamic>>,
    feedback: Option<Feedback>,
    /// Of goals that end without success.
    failures: Option<Feedback>,
    /// From the argument to the request in ROS.
    request: Conversion,
    request_there: Schema,
    /// From the response in ROS to the result.
    response: Conversion,
    /// Calls that have not ended, with the times at which their callers stop waiting.
    open: BTreeMap<RequestId, Option<Time>>,
}

struct Feedback {
    port: Out<Datum>,
    conversion: Conversion,
    schema: Schema,
}

/// The conversion, or the reason that there is none.
pub(crate) fn conversion(
    from: &Schema,
    to: &Schema,
    usage: Use,
    of: &MappedOperation,
) -> Result<Conversion, String> {
    let found = Conversion::between(from, to, usage);
    found.ok_or_else(|| {
        let operation = format!("{}.{}", of.port, of.operation.name);
        format!(
            "`{operation}` and `{}` of ROS: `{from}` does not become `{to}`",
            of.kind
        )
    })
}

/// The complete datum of a schema. Fields may be left out, and a specification may write a record as a tuple of its fields.
pub(crate) fn complete(datum: Datum, schema: &Schema) -> Result<Datum, DatumError> {
    let datum = match (datum, &schema.shape) {
        (Datum::List(values), Shape::Record(fields)) if values.len() == fields.len() => {
            let names = fields.iter().map(|field| field.name.clone());
            Datum::record(names.zip(values))
        }
        (datum, _) => datum,
    };
    schema.complete(datum)
}

impl CalledOperation {
    /// Declares the operation.
    pub(crate) fn declare(
        mapped: MappedOperation,
        there: OperationSchemas,
        interface: &mut Interface,
    ) -> Result<Self, String> {
        let of = &mapped.operation;
        let request = conversion(&of.request, &there.request, Use::All, &mapped)?;
        let response = conversion(&there.response, &of.response, Use::Fill, &mapped)?;
        let doc = format!("`{}` of ROS", mapped.ros);
        let (service, name) = (&mapped.port, &mapped.interface);
        let served = interface.serve_declared(service, name, of.clone(), &doc);
        let cancel = mapped.cancel.clone();
        let cancel = cancel.map(|cancel| interface.serve_declared(service, name, cancel, &doc));
        let output = |to: &MappedFeedback, from: &Schema, what: &str, interface: &mut Interface| {
            Ok::<_, String>(Feedback {
                conversion: conversion(from, &to.schema, Use::Fill, &mapped)?,
                port: interface.output_of(
                    &to.port,
                    to.schema.clone(),
                    &format!("{what} of `{}` of ROS", mapped.ros),
                ),
                schema: to.schema.clone(),
            })
        };
        let feedback = match (&mapped.feedback, &there.feedback) {
            (Some(to), Some(schema)) => Some(output(to, schema, "feedback", interface)?),
            (Some(_), None) => return Err(format!("`{}` gives no feedback", mapped.kind)),
            (None, _) => None,
        };
        let failures = match &mapped.result {
            Some(to) => Some(output(
                to,
                &there.response,
                "results of failed goals",
                interface,
            )?),
            None => None,
        };
        Ok(Self {
            served,
            cancel,
            feedback,
            failures,
            request,
            request_there: there.request,
            response,
            mapped,
            open: BTreeMap::new(),
        })
    }

    /// Returns whether calls have not ended.
    pub(crate) fn is_busy(&self) -> bool {
        !self.open.is_empty()
    }

    /// Takes requests to ROS, and answers from there.
    pub(crate) fn update(
        &mut self,
        caller: &mut dyn OperationCaller,
        misfits: &mut Misfits,
        cycle: &mut Cycle<'_>,
    ) {
        for request in cycle.cancelled(self.served).to_vec() {
            if self.open.remove(&request).is_some() {
                caller.give_up(request.0);
            }
        }
        // before new requests: an operation that cancels does not meet a goal of the same cycle
        self.serve_cancellations(caller, cycle);
        for request in cycle.requests(self.served) {
            self.begin(request, caller, misfits, cycle);
        }
        for progress in caller.take() {
            match progress {
                CallProgress::Feedback(feedback) => {
                    self.write(self.feedback.as_ref(), &feedback, misfits, cycle);
                }
                CallProgress::Failure(result) => {
                    self.write(self.failures.as_ref(), &result, misfits, cycle);
                }
                CallProgress::Ended { call, result } => {
                    self.end(RequestId(call), result, misfits, cycle);
                }
            }
        }
        let now = cycle.now();
        let deadlines = self.open.values().flatten().copied().min();
        let patience = caller.patience().map(|patience| now + patience);
        if let Some(next) = deadlines.into_iter().chain(patience).min() {
            cycle.request_cycle_at(next);
        }
    }

    /// Cancels all calls; those to services are no longer awaited.
    pub(crate) fn cancel_all(&self, caller: &mut dyn OperationCaller) {
        for request in self.open.keys() {
            caller.cancel(request.0);
        }
    }

    /// Ends all calls with a fault, because the connection is gone.
    pub(crate) fn lose_all(&mut self, misfits: &mut Misfits, cycle: &mut Cycle<'_>) {
        for (request, deadline) in std::mem::take(&mut self.open) {
            let fault = ServiceFault::new(LOST, "the bridge has joined ROS again");
            self.fail(request, deadline, fault, misfits, cycle);
        }
    }

    /// Cancels the goals of all callers. They end as their server says.
    fn serve_cancellations(&mut self, caller: &mut dyn OperationCaller, cycle: &mut Cycle<'_>) {
        let (Some(served), Some(cancel)) = (self.cancel, &self.mapped.cancel) else {
            return;
        };
        for request in cycle.requests(served) {
            self.cancel_all(caller);
            let response = cancel.response.complete(Datum::Record(Vec::new()));
            let response =
                response.map_err(|error| ServiceFault::new(BAD_REPLY, error.to_string()));
            cycle.reply(served, request.id, response);
        }
    }

    fn begin(
        &mut self,
        request: Request<Datum>,
        caller: &mut dyn OperationCaller,
        misfits: &mut Misfits,
        cycle: &mut Cycle<'_>,
    ) {
        let schema = &self.mapped.operation.request;
        let argument = complete(request.argument, schema);
        let there = argument.map(|argument| self.request.apply(&argument));
        match there.and_then(|there| self.request_there.complete(there)) {
            Ok(there) => {
                let deadline = request.deadline;
                let timeout = deadline.map_or(ONE_WAY, |at| at.since(cycle.now()));
                caller.call(request.id.0, &there, timeout);
                self.open.insert(request.id, deadline);
            }
            Err(error) => {
                let fault = ServiceFault::new(BAD_ARGUMENT, error.to_string());
                self.fail(request.id, request.deadline, fault, misfits, cycle);
            }
        }
    }

    fn write(
        &self,
        to: Option<&Feedback>,
        message: &Datum,
        misfits: &mut Misfits,
        cycle: &mut Cycle<'_>,
    ) {
        let Some(to) = to else {
            return;
        };
        match to.schema.complete(to.conversion.apply(message)) {
            Ok(sample) => cycle.write(to.port, sample),
            Err(error) => misfits.count(
                (&self.mapped.port, &self.mapped.ros),
                &error.to_string(),
                cycle,
            ),
        }
    }

    fn end(
        &mut self,
        request: RequestId,
        result: Result<Datum, ServiceFault>,
        misfits: &mut Misfits,
        cycle: &mut Cycle<'_>,
    ) {
        // its caller waits no more
        let Some(deadline) = self.open.remove(&request) else {
            return;
        };
        let schema = &self.mapped.operation.response;
        let result = result.and_then(|response| {
            let result = schema.complete(self.response.apply(&response));
            result.map_err(|error| ServiceFault::new(BAD_REPLY, error.to_string()))
        });
        match result {
            Ok(result) => cycle.reply(self.served, request, Ok(result)),
            Err(fault) => self.fail(request, deadline, fault, misfits, cycle),
        }
    }

    /// Ends a request with a fault. Of a one-way request, whose caller does not wait, it is counted and reported.
    fn fail(
        &self,
        request: RequestId,
        deadline: Option<Time>,
        fault: ServiceFault,
        misfits: &mut Misfits,
        cycle: &mut Cycle<'_>,
    ) {
        if deadline.is_none() {
            let at = (&self.mapped.port, &self.mapped.ros);
            misfits.count(at, &fault.to_string(), cycle);
            return;
        }
        cycle.reply(self.served, request, Err(fault));
    }
}
