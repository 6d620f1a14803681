//! The state of a program between two cycles.

use asmotion_component::{
    CallId, CannotFreeze, FreezeProblem, FrozenState, RequestId, ThawError, ThawProblem, Time,
};
use asmotion_datum::{Datum, field};
use serde::{Deserialize, Serialize};

use super::ProgramComponent;
use super::actions::{LineBudget, OpenCall, OpenExchanges, OpenRequest};
use crate::error::ProgramError;
use crate::reply::{expect, is, value_of};
use crate::request::ProgramRequest;

/// Version of the layout.
const VERSION: u32 = 1;

/// The state of a program, and of the exchanges that have not ended.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct FrozenProgram {
    /// The bytes that the program has returned.
    #[serde(with = "field")]
    state: Datum,
    requests: Vec<(u64, usize, RequestId, Option<Time>)>,
    last_request: u64,
    calls: Vec<(u64, usize, CallId)>,
    lost: Vec<u64>,
}

impl ProgramComponent {
    fn kind(&self) -> String {
        format!("program {}", self.command.line())
    }

    pub(super) fn frozen(&self) -> Result<FrozenState, CannotFreeze> {
        let cannot = |reason| CannotFreeze {
            component: self.kind(),
            reason,
        };
        let refused = |error: ProgramError| cannot(FreezeProblem::Refused(error.to_string()));
        let session = self.session().map_err(refused)?;
        let reply = session.exchange(ProgramRequest::of("freeze"), "freeze");
        let reply = reply.map_err(refused)?;
        if is(&reply, "unsupported") {
            let reason = crate::reply::text_of(&reply, "text");
            let reason = reason.unwrap_or_else(|| "the program does not support it".to_owned());
            return Err(cannot(FreezeProblem::Refused(reason)));
        }
        expect(&reply, "frozen", "freeze").map_err(refused)?;
        let open = &self.open;
        let requests = open.requests.iter();
        let calls = open.calls.iter();
        let frozen = FrozenProgram {
            state: value_of(&reply, "state").cloned().unwrap_or_default(),
            requests: requests
                .map(|(key, it)| (*key, it.operation, it.id, it.deadline))
                .collect(),
            last_request: open.last_request,
            calls: calls.map(|(key, it)| (*key, it.operation, it.id)).collect(),
            lost: open.lost.clone(),
        };
        FrozenState::of(&self.kind(), VERSION, &frozen)
    }

    pub(super) fn thawed(&mut self, state: &FrozenState) -> Result<(), ThawError> {
        let kind = self.kind();
        let frozen: FrozenProgram = state.read(&kind, VERSION)?;
        let error = |problem| ThawError {
            component: kind.clone(),
            problem,
        };
        let foreign = |reason: ProgramError| error(ThawProblem::Foreign(reason.to_string()));
        let session = self.session().map_err(foreign)?;
        let request = ProgramRequest::of("thaw").put("state", frozen.state);
        let reply = session.exchange(request, "thaw").map_err(foreign)?;
        if is(&reply, "unsupported") {
            return Err(error(ThawProblem::NotImplemented));
        }
        expect(&reply, "ok", "thaw").map_err(foreign)?;
        // printed before the frozen state
        session.take_lines(0);
        let requests = frozen.requests.into_iter();
        let calls = frozen.calls.into_iter();
        self.open = OpenExchanges {
            requests: requests
                .map(|(key, operation, id, deadline)| {
                    let request = OpenRequest {
                        operation,
                        id,
                        deadline,
                    };
                    (key, request)
                })
                .collect(),
            last_request: frozen.last_request,
            calls: calls
                .map(|(key, operation, id)| (key, OpenCall { operation, id }))
                .collect(),
            lost: frozen.lost,
            // those that the program was configured with
            properties: std::mem::take(&mut self.open.properties),
        };
        self.budget = LineBudget::default();
        Ok(())
    }
}
