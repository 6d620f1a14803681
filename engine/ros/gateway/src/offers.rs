//! Services and actions of ROS that operations of components carry out.

use std::collections::BTreeMap;

use asmotion_bridge::{Conversion, Use};
use asmotion_component::{CallError, CallId, Cycle, Dynamic, In, Interface, Required};
use asmotion_datum::{Datum, Schema};

use crate::calls::{complete, conversion};
use crate::misfits::Misfits;
use crate::operation::{
    CallNumber, MappedOperation, OperationSchemas, OperationServer, ServedEnd, ServedRequest,
};

/// An operation that nodes of ROS can call.
pub(crate) struct OfferedOperation {
    pub(crate) mapped: MappedOperation,
    reference: Required<Dynamic>,
    feedback: Option<Feedback>,
    /// From the request in ROS to the argument.
    request: Conversion,
    /// From the result to the response in ROS.
    response: Conversion,
    response_there: Schema,
    /// Calls that have not ended, with the numbers of their requests.
    calls: BTreeMap<CallId, CallNumber>,
}

struct Feedback {
    port: In<Datum>,
    schema: Schema,
    conversion: Conversion,
    schema_there: Schema,
}

impl OfferedOperation {
    /// Declares the reference.
    pub(crate) fn declare(
        mapped: MappedOperation,
        there: OperationSchemas,
        interface: &mut Interface,
    ) -> Result<Self, String> {
        let of = &mapped.operation;
        let request = conversion(&there.request, &of.request, Use::Fill, &mapped)?;
        let response = conversion(&of.response, &there.response, Use::All, &mapped)?;
        let doc = format!("offered to ROS as `{}`", mapped.ros);
        let reference =
            interface.require_declared(&mapped.port, &mapped.interface, of.clone(), &doc);
        let feedback = match (&mapped.feedback, there.feedback) {
            (Some(feedback), Some(schema_there)) => Some(Feedback {
                conversion: conversion(&feedback.schema, &schema_there, Use::All, &mapped)?,
                port: interface.input_of(
                    &feedback.port,
                    feedback.schema.clone(),
                    &format!("feedback of the action `{}` of ROS", mapped.ros),
                ),
                schema: feedback.schema.clone(),
                schema_there,
            }),
            (Some(_), None) => return Err(format!("`{}` gives no feedback", mapped.kind)),
            (None, _) => None,
        };
        Ok(Self {
            reference,
            feedback,
            request,
            response,
            response_there: there.response,
            mapped,
            calls: BTreeMap::new(),
        })
    }

    /// Returns whether calls have not ended.
    pub(crate) fn is_busy(&self) -> bool {
        !self.calls.is_empty()
    }

    /// Takes requests from ROS, and answers to there.
    pub(crate) fn update(
        &mut self,
        server: &mut dyn OperationServer,
        misfits: &mut Misfits,
        cycle: &mut Cycle<'_>,
    ) {
        self.tell(server, misfits, cycle);
        for reply in cycle.replies(self.reference) {
            let Some(call) = self.calls.remove(&reply.call) else {
                continue;
            };
            let end = match reply.result {
                Ok(result) => self.response(result),
                Err(CallError::Cancelled) => ServedEnd::Cancelled,
                Err(error) => ServedEnd::Failed(error.to_string()),
            };
            self.end(server, call, end, misfits, cycle);
        }
        for request in server.take() {
            match request {
                ServedRequest::Call(call, request) => {
                    let argument = self.request.apply(&request);
                    match self.mapped.operation.request.complete(argument) {
                        Ok(argument) => {
                            let number = cycle.call(self.reference, argument);
                            self.calls.insert(number, call);
                        }
                        Err(error) => {
                            let end = ServedEnd::Failed(error.to_string());
                            self.end(server, call, end, misfits, cycle);
                        }
                    }
                }
                ServedRequest::Cancel(call) => {
                    let mut calls = self.calls.iter();
                    if let Some((number, _)) = calls.find(|(_, of)| **of == call) {
                        cycle.cancel(*number);
                    }
                }
            }
        }
        if let Some(patience) = server.patience() {
            cycle.request_cycle_at(cycle.now() + patience);
        }
    }

    /// Ends all requests, because the bridge stops.
    pub(crate) fn end_all(&mut self, server: &mut dyn OperationServer) {
        for call in std::mem::take(&mut self.calls).into_values() {
            // the connection closes, and the client notices also without these words
            let _ = server.end(call, ServedEnd::Failed("the system stops".to_owned()));
        }
    }

    /// Cancels all calls, because the connection is gone over which their results would go.
    pub(crate) fn lose_all(&mut self, cycle: &mut Cycle<'_>) {
        for number in std::mem::take(&mut self.calls).into_keys() {
            cycle.cancel(number);
        }
    }

    fn tell(&self, server: &mut dyn OperationServer, misfits: &mut Misfits, cycle: &mut Cycle<'_>) {
        let Some(of) = &self.feedback else {
            return;
        };
        for sample in cycle.all(of.port).to_vec() {
            let complete = of.schema.complete(sample);
            let there = complete.map(|sample| of.conversion.apply(&sample));
            let there = there.and_then(|there| of.schema_there.complete(there));
            let there = there.map_err(|error| error.to_string());
            if let Err(reason) = there.and_then(|there| server.tell(&there)) {
                misfits.count((&self.mapped.port, &self.mapped.ros), &reason, cycle);
            }
        }
    }

    fn response(&self, result: Datum) -> ServedEnd {
        let result = complete(result, &self.mapped.operation.response);
        let there = result.map(|result| self.response.apply(&result));
        match there.and_then(|there| self.response_there.complete(there)) {
            Ok(response) => ServedEnd::Done(response),
            Err(error) => ServedEnd::Failed(error.to_string()),
        }
    }

    fn end(
        &self,
        server: &mut dyn OperationServer,
        call: CallNumber,
        end: ServedEnd,
        misfits: &mut Misfits,
        cycle: &mut Cycle<'_>,
    ) {
        if let Err(reason) = server.end(call, end) {
            misfits.count((&self.mapped.port, &self.mapped.ros), &reason, cycle);
        }
    }
}
