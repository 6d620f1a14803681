//! The state of a coordinator as data: the machine, and everything that is under way around it.

use crate::binding::Binding;
use crate::coordinator::Coordinator;
use crate::effects::PendingOutcome;
use crate::inputs::BoundInput;
use crate::partners::PartnerCall;
use crate::requests::WaitingCaller;
use asmotion_component::{
    CallId, CannotFreeze, FrozenState, Losses, RequestId, ThawError, ThawProblem, Time, frozen,
};
use asmotion_datum::Datum;
use asmotion_lang::Specification;
use asmotion_lang::diagnostics::FileId;

use asmotion_lang::ir::FunctionId;
use asmotion_lang::machine::{ForeignSnapshot, Machine, MessageId, Snapshot, pack_value};
use asmotion_lang::simulate::Seeded;
use asmotion_lang::value::Value;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, VecDeque};

/// The type that frozen states name.
const COMPONENT: &str = "asm::Coordinator";

/// The layout of [`FrozenCoordinator`], and of the encoding of the machine.
const VERSION: u32 = 1;

/// A packed value.
type PackedValue = serde_bytes::ByteBuf;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct FrozenCoordinator {
    /// Name of the specification, for people.
    specification: String,
    fingerprint: String,
    #[serde(with = "serde_bytes")]
    machine: Vec<u8>,
    chooser: Seeded,
    inputs: Vec<FrozenInput>,
    losses: Losses,
    reported: Losses,
    /// Replies, by the names under which the binding keeps them.
    kept: BTreeMap<String, Datum>,
    outcomes: Vec<FrozenOutcome>,
    heard: Vec<FrozenRequests>,
    calls: Vec<FrozenCall>,
    /// Requests that the machine has not answered: the message, the operation, the request.
    requests: Vec<(u64, usize, RequestId)>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct FrozenInput {
    newest: Option<Time>,
    last: Option<PackedValue>,
    /// Each with the function whose call it answers.
    waiting: Vec<(Option<u32>, PackedValue)>,
}

/// A call of the binding, under way.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct FrozenOutcome {
    call: CallId,
    /// Number of the call in the binding.
    number: usize,
    /// Operation and request that it answers for.
    caller: Option<(usize, RequestId)>,
}

/// What was asked of an operation that a monitored function is bound to.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct FrozenRequests {
    /// What was asked last: a list of one, or none. (An option of a datum that is null would read as absent.)
    last: Vec<Datum>,
    open: Vec<RequestId>,
}

/// A call of a partner, under way.
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

/// Tells apart what a frozen coordinator can belong to: all texts of the specification, and the binding.
pub(crate) fn fingerprint(specification: &Specification, binding: &Binding) -> String {
    let binding = format!("{binding:?}");
    let sources = &specification.sources;
    let files = (0..).map(FileId);
    let files = files.take_while(|file| !sources.path(*file).is_empty());
    let texts = files.map(|file| sources.text(file));
    frozen::fingerprint(texts.chain([binding.as_str()]))
}

fn packed(value: &Value) -> PackedValue {
    PackedValue::from(pack_value(value))
}

fn foreign(what: impl Into<String>) -> ThawProblem {
    ThawProblem::Foreign(what.into())
}

fn another_program(_: ForeignSnapshot) -> ThawProblem {
    foreign("its machine ran another specification")
}

impl FrozenInput {
    fn of(input: &BoundInput) -> Self {
        let waiting = input.waiting.iter();
        Self {
            newest: input.newest,
            last: input.last.as_ref().map(packed),
            waiting: waiting
                .map(|(answers, value)| (answers.map(|function| function.0), packed(value)))
                .collect(),
        }
    }
}

/// What was read of an input, on its way there.
struct ThawedInput {
    newest: Option<Time>,
    last: Option<Value>,
    waiting: VecDeque<(Option<FunctionId>, Value)>,
}

impl ThawedInput {
    fn read(frozen: &FrozenInput, machine: &Machine) -> Result<Self, ForeignSnapshot> {
        let value = |packed: &PackedValue| machine.unpack_value(packed);
        let waiting = frozen.waiting.iter();
        let waiting = waiting.map(|(answers, event)| Ok((answers.map(FunctionId), value(event)?)));
        Ok(Self {
            newest: frozen.newest,
            last: frozen.last.as_ref().map(value).transpose()?,
            waiting: waiting.collect::<Result<_, _>>()?,
        })
    }
}

impl Coordinator {
    /// The machine and what is under way around it. What the present cycle has read is no part of it: the next cycle
    /// reads anew.
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
            waits: made.waits,
            asked: made.asked,
        });
        let requests = self.partners.requests.iter();
        let state = FrozenCoordinator {
            specification: self.specification.model.name.to_string(),
            fingerprint: self.fingerprint.clone(),
            machine: self.machine.snapshot().to_bytes(),
            chooser: self.chooser.clone(),
            inputs: self.inbox.inputs.iter().map(FrozenInput::of).collect(),
            losses: self.inbox.losses,
            reported: self.reported,
            kept: self.outbox.kept.clone(),
            outcomes: outcomes.collect(),
            heard: heard.collect(),
            calls: calls.collect(),
            requests: requests
                .map(|(message, served, request)| (message.0, *served, *request))
                .collect(),
        };
        FrozenState::of(COMPONENT, VERSION, &state)
    }

    /// Takes over a state, all or nothing.
    pub(crate) fn thawed(&mut self, state: &FrozenState) -> Result<(), ThawError> {
        let frozen = state.read(COMPONENT, VERSION)?;
        self.take_over(frozen).map_err(|problem| ThawError {
            component: COMPONENT.to_owned(),
            problem,
        })
    }

    fn take_over(&mut self, frozen: FrozenCoordinator) -> Result<(), ThawProblem> {
        if frozen.fingerprint != self.fingerprint {
            let (was, is) = (&frozen.specification, &self.specification.model.name);
            return Err(foreign(format!(
                "it ran another text or binding of `{was}` than this coordinator of `{is}`"
            )));
        }
        let snapshot = Snapshot::from_bytes(&frozen.machine).map_err(another_program)?;
        let mut machine = self.machine.clone();
        machine.restore(&snapshot).map_err(another_program)?;
        let inputs = frozen.inputs.iter();
        let inputs = inputs.map(|input| ThawedInput::read(input, &machine));
        let inputs: Vec<_> = inputs.collect::<Result<_, _>>().map_err(another_program)?;
        let outcomes = self.outcomes(&frozen.outcomes)?;
        let calls = self.calls(&frozen.calls, &machine)?;
        let served = self.partners.served.len();
        let fits = inputs.len() == self.inbox.inputs.len()
            && frozen.heard.len() == self.requests.served.len()
            && frozen.heard.iter().all(|heard| heard.last.len() <= 1)
            && frozen.requests.iter().all(|(_, of, _)| *of < served);
        if !fits {
            return Err(foreign("it has other inputs or operations"));
        }
        for (input, thawed) in self.inbox.inputs.iter_mut().zip(inputs) {
            input.newest = thawed.newest;
            input.last = thawed.last;
            input.waiting = thawed.waiting;
        }
        for (served, heard) in self.requests.served.iter_mut().zip(frozen.heard) {
            served.last = heard.last.into_iter().next();
            served.open = heard.open;
        }
        let requests = frozen.requests.into_iter();
        let message = |(message, served, request)| (MessageId(message), served, request);
        self.partners.requests = requests.map(message).collect();
        self.partners.calls = calls;
        self.outbox.pending = outcomes;
        self.outbox.kept = frozen.kept;
        self.inbox.losses = frozen.losses;
        self.reported = frozen.reported;
        self.chooser = frozen.chooser;
        self.machine = machine;
        self.frame.clear();
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
        outcomes.ok_or_else(|| foreign("a call is under way that the binding does not make"))
    }

    fn calls(
        &self,
        frozen: &[FrozenCall],
        machine: &Machine,
    ) -> Result<Vec<(CallId, PartnerCall)>, ThawProblem> {
        let thaw = |frozen: &FrozenCall| {
            if frozen.asked >= self.partners.asked.len() {
                return Err(foreign("a call is under way to an unknown partner"));
            }
            let made = PartnerCall {
                message: MessageId(frozen.message),
                from: machine
                    .unpack_value(&frozen.from)
                    .map_err(another_program)?,
                waits: frozen.waits,
                asked: frozen.asked,
            };
            Ok((frozen.call, made))
        };
        frozen.iter().map(thaw).collect()
    }
}
