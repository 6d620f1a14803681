//! Freezing and thawing of the state of a coordinator: the machine, inputs, pending calls and pending requests.

use crate::coordinator::Coordinator;
use crate::effects::PendingOutcome;
use crate::event_queue::{EventQueue, EventSource, WaitingEvent};
use crate::inputs::{BoundInput, InputLocation};
use crate::misfit::MisfitCauses;
use crate::partners::PartnerCall;
use crate::recorded::MachineOrigin;
use crate::requests::WaitingCaller;
use asmotion_component::{
    CallId, CannotFreeze, FrozenState, Losses, RequestId, ThawError, ThawProblem, Time,
};
use asmotion_datum::Datum;
use asmotion_lang::machine::{ForeignSnapshot, Machine, MessageId, Snapshot, pack_value};
use asmotion_lang::simulate::Seeded;
use asmotion_lang::value::Value;
use asmotion_verify::MonitorsState;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Component type named in frozen states.
const COMPONENT: &str = "asm::Coordinator";

/// Version of the layout of [`FrozenCoordinator`] and of the machine encoding.
const VERSION: u32 = 6;

/// A value in the compact encoding of the machine.
type PackedValue = serde_bytes::ByteBuf;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct FrozenCoordinator {
    /// Name of the specification, for error messages.
    specification: String,
    fingerprint: String,
    #[serde(with = "serde_bytes")]
    machine: Vec<u8>,
    chooser: Seeded,
    inputs: Vec<FrozenInput>,
    losses: Losses,
    dropped_elsewhere: u64,
    reported: Losses,
    /// Kept replies by the name given in the binding.
    kept: BTreeMap<String, Datum>,
    /// Newest published messages by the port that the binding refers to.
    published: BTreeMap<String, Datum>,
    outcomes: Vec<FrozenOutcome>,
    heard: Vec<FrozenRequests>,
    calls: Vec<FrozenCall>,
    /// Requests not yet answered by the machine: message, operation, request.
    requests: Vec<(u64, usize, RequestId)>,
    monitors: MonitorsState,
    /// Causes for which requests have been refused, and which have been reported.
    #[serde(default)]
    refused_requests: MisfitCauses,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct FrozenInput {
    locations: Vec<FrozenLocation>,
    /// A message whose key selects no element has been reported.
    reported_key: bool,
    /// A message that waited too long has been reported.
    reported_expiry: bool,
    /// Values that messages must have, as a list of at most one element.
    expected: Vec<Datum>,
    /// A message with other values has been reported.
    reported_refusal: bool,
    /// Number of messages lost on the way to the port before the last step.
    lost: u64,
    /// Causes for which messages have been refused, and which have been reported.
    #[serde(default)]
    causes: MisfitCauses,
}

/// An input location.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct FrozenLocation {
    newest: Option<Time>,
    last: Option<PackedValue>,
    /// Events not yet read, each with the last time at which it may be used.
    waiting: Vec<(EventSource, PackedValue, Option<Time>)>,
}

/// A pending call of the binding.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct FrozenOutcome {
    call: CallId,
    /// Position of the call in the binding.
    number: usize,
    /// Operation and request to be answered with the outcome.
    caller: Option<(usize, RequestId)>,
}

/// Requests to an operation bound to a monitored function.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct FrozenRequests {
    /// Last request, as a list of at most one element. `Option<Datum>` would not distinguish an absent request from
    /// null.
    last: Vec<Datum>,
    open: Vec<RequestId>,
}

/// A pending call to a partner.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct FrozenCall {
    call: CallId,
    message: u64,
    from: PackedValue,
    waits: bool,
    /// Position of the operation.
    asked: usize,
}

fn packed(value: &Value) -> PackedValue {
    PackedValue::from(pack_value(value))
}

fn foreign_state(what: impl Into<String>) -> ThawProblem {
    ThawProblem::Foreign(what.into())
}

fn foreign_program(_: ForeignSnapshot) -> ThawProblem {
    foreign_state("its machine ran another specification")
}

impl FrozenInput {
    fn of(input: &BoundInput) -> Self {
        Self {
            locations: input.locations.iter().map(FrozenLocation::of).collect(),
            reported_key: input.reported_key,
            reported_expiry: input.reported_expiry,
            expected: input
                .matching
                .as_ref()
                .and_then(|it| it.expected.clone())
                .into_iter()
                .collect(),
            reported_refusal: input.matching.as_ref().is_some_and(|it| it.reported),
            lost: input.lost.before,
            causes: input.causes.clone(),
        }
    }
}

impl FrozenLocation {
    fn of(location: &InputLocation) -> Self {
        let waiting = location.waiting.iter();
        Self {
            newest: location.newest,
            last: location.last.as_ref().map(packed),
            waiting: waiting
                .map(|event| (event.source, packed(&event.value), event.expiry))
                .collect(),
        }
    }
}

/// Decoded state of an input, before it is assigned.
struct ThawedInput {
    locations: Vec<ThawedLocation>,
    reported_key: bool,
    reported_expiry: bool,
    expected: Option<Datum>,
    reported_refusal: bool,
    lost: u64,
    causes: MisfitCauses,
}

/// Decoded state of an input location.
struct ThawedLocation {
    newest: Option<Time>,
    last: Option<Value>,
    waiting: EventQueue,
}

impl ThawedInput {
    fn read(frozen: &FrozenInput, machine: &Machine) -> Result<Self, ForeignSnapshot> {
        let locations = frozen.locations.iter();
        let locations = locations.map(|location| ThawedLocation::read(location, machine));
        Ok(Self {
            locations: locations.collect::<Result<_, _>>()?,
            reported_key: frozen.reported_key,
            reported_expiry: frozen.reported_expiry,
            expected: frozen.expected.first().cloned(),
            reported_refusal: frozen.reported_refusal,
            lost: frozen.lost,
            causes: frozen.causes.clone(),
        })
    }

    fn fits(&self, input: &BoundInput) -> bool {
        self.locations.len() == input.locations.len()
    }

    fn assign(self, input: &mut BoundInput) {
        input.reported_key = self.reported_key;
        input.reported_expiry = self.reported_expiry;
        input.lost.before = self.lost;
        input.causes = self.causes;
        if let Some(condition) = &mut input.matching {
            condition.expected = self.expected;
            condition.reported = self.reported_refusal;
        }
        for (location, thawed) in input.locations.iter_mut().zip(self.locations) {
            location.newest = thawed.newest;
            location.last = thawed.last;
            location.waiting = thawed.waiting;
        }
    }
}

impl ThawedLocation {
    fn read(frozen: &FrozenLocation, machine: &Machine) -> Result<Self, ForeignSnapshot> {
        let value = |packed: &PackedValue| machine.unpack_value(packed);
        let waiting = frozen.waiting.iter();
        let waiting = waiting.map(|(source, event, expiry)| {
            Ok(WaitingEvent {
                source: *source,
                value: value(event)?,
                expiry: *expiry,
            })
        });
        Ok(Self {
            newest: frozen.newest,
            last: frozen.last.as_ref().map(value).transpose()?,
            waiting: waiting.collect::<Result<_, _>>()?,
        })
    }
}

impl Coordinator {
    /// Returns the state of the machine and of the pending work. Values read in the current cycle are not included,
    /// since the next cycle reads them again.
    pub(crate) fn frozen(&self) -> Result<FrozenState, CannotFreeze> {
        let outcomes = self.outbox.pending.iter().map(|pending| FrozenOutcome {
            call: pending.call,
            number: pending.outcome.number,
            caller: pending.caller.map(|caller| (caller.served, caller.request)),
        });
        let heard = self.requests.served.iter().map(|served| FrozenRequests {
            last: served.last.iter().cloned().collect(),
            open: served.open.clone(),
        });
        let calls = self.partners.calls.iter().map(|(call, made)| FrozenCall {
            call: *call,
            message: made.message.0,
            from: packed(&made.from),
            waits: made.is_synchronous,
            asked: made.operation_index,
        });
        let requests = self.partners.requests.iter();
        let state = FrozenCoordinator {
            specification: self.prepared.specification.model.name.to_string(),
            fingerprint: self.prepared.fingerprint.clone(),
            machine: self.machine.snapshot().to_bytes(),
            chooser: self.chooser.clone(),
            inputs: self.inbox.inputs.iter().map(FrozenInput::of).collect(),
            losses: self.inbox.losses,
            dropped_elsewhere: self.inbox.dropped_elsewhere,
            reported: self.reported,
            kept: self.outbox.kept.clone(),
            published: self.outbox.published.clone(),
            outcomes: outcomes.collect(),
            heard: heard.collect(),
            calls: calls.collect(),
            requests: requests
                .map(|(message, served, request)| (message.0, *served, *request))
                .collect(),
            monitors: self.watcher.monitors.state(),
            refused_requests: self.partners.causes.clone(),
        };
        FrozenState::of(COMPONENT, VERSION, &state)
    }

    /// Restores a state; on error the coordinator is unchanged.
    pub(crate) fn thawed(&mut self, state: &FrozenState) -> Result<(), ThawError> {
        let frozen = state.read(COMPONENT, VERSION)?;
        self.restore(frozen).map_err(|problem| ThawError {
            component: COMPONENT.to_owned(),
            problem,
        })
    }

    fn restore(&mut self, frozen: FrozenCoordinator) -> Result<(), ThawProblem> {
        if frozen.fingerprint != self.prepared.fingerprint {
            let (was, is) = (
                &frozen.specification,
                &self.prepared.specification.model.name,
            );
            return Err(foreign_state(format!(
                "it ran `{was}` with another text or binding than this coordinator of `{is}`"
            )));
        }
        let snapshot = Snapshot::from_bytes(&frozen.machine).map_err(foreign_program)?;
        let mut machine = self.machine.clone();
        machine.restore(&snapshot).map_err(foreign_program)?;
        let inputs = frozen.inputs.iter();
        let inputs = inputs.map(|input| ThawedInput::read(input, &machine));
        let inputs: Vec<_> = inputs.collect::<Result<_, _>>().map_err(foreign_program)?;
        let outcomes = self.outcomes(&frozen.outcomes)?;
        let calls = self.calls(&frozen.calls, &machine)?;
        let served = self.partners.own_operations.len();
        let mut known = inputs.iter().zip(&self.inbox.inputs);
        let fits = inputs.len() == self.inbox.inputs.len()
            && known.all(|(thawed, input)| thawed.fits(input))
            && frozen.heard.len() == self.requests.served.len()
            && frozen.heard.iter().all(|heard| heard.last.len() <= 1)
            && frozen.requests.iter().all(|(_, of, _)| *of < served);
        if !fits {
            return Err(foreign_state("it has other inputs or operations"));
        }
        if !self.watcher.monitors.restore(&frozen.monitors) {
            return Err(foreign_state("it watches other properties"));
        }
        self.last_write = self.last_write.for_successor(&self.machine);
        self.control.clear();
        for (input, thawed) in self.inbox.inputs.iter_mut().zip(inputs) {
            thawed.assign(input);
        }
        for (served, heard) in self.requests.served.iter_mut().zip(frozen.heard) {
            served.last = heard.last.into_iter().next();
            served.open = heard.open;
        }
        let requests = frozen.requests.into_iter();
        let message = |(message, served, request)| (MessageId(message), served, request);
        self.partners.requests = requests.map(message).collect();
        self.partners.calls = calls;
        self.partners.causes = frozen.refused_requests;
        self.outbox.pending = outcomes;
        self.outbox.kept = frozen.kept;
        self.outbox.published = frozen.published;
        self.inbox.losses = frozen.losses;
        self.inbox.dropped_elsewhere = frozen.dropped_elsewhere;
        self.reported = frozen.reported;
        self.chooser = frozen.chooser;
        self.machine = machine;
        self.frame.clear();
        if let Some(recorder) = &mut self.recorder {
            recorder.begin(MachineOrigin::Frozen);
        }
        Ok(())
    }

    fn outcomes(&mut self, frozen: &[FrozenOutcome]) -> Result<Vec<PendingOutcome>, ThawProblem> {
        let thaw = |frozen: &FrozenOutcome| {
            let caller = match frozen.caller {
                None => None,
                Some((served, request)) => Some(WaitingCaller {
                    handle: self.requests.served.get(served)?.handle,
                    served,
                    request,
                }),
            };
            Some(PendingOutcome {
                call: frozen.call,
                outcome: self.outbox.outcome(frozen.number)?,
                caller,
            })
        };
        let outcomes: Option<Vec<_>> = frozen.iter().map(thaw).collect();
        outcomes.ok_or_else(|| foreign_state("a call is under way that the binding does not make"))
    }

    fn calls(
        &self,
        frozen: &[FrozenCall],
        machine: &Machine,
    ) -> Result<Vec<(CallId, PartnerCall)>, ThawProblem> {
        let thaw = |frozen: &FrozenCall| {
            if frozen.asked >= self.partners.partner_operations.len() {
                return Err(foreign_state("a call is under way to an unknown partner"));
            }
            let made = PartnerCall {
                message: MessageId(frozen.message),
                from: machine
                    .unpack_value(&frozen.from)
                    .map_err(foreign_program)?,
                is_synchronous: frozen.waits,
                operation_index: frozen.asked,
            };
            Ok((frozen.call, made))
        };
        frozen.iter().map(thaw).collect()
    }
}
