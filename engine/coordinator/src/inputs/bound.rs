//! A bound monitored function: which messages its locations take, and their values in a step.

use super::arrived::ArrivedMessages;
use crate::bind_error::BindError;
use crate::binding::{Argument, Constant, Monitored, Receive, Source};
use crate::bound_location::BoundLocations;
use crate::content::{BoundContent, has_values};
use crate::convert::value_of;
use crate::event_queue::{Arrival, EventQueue};
use crate::misfit::{MisfitCauses, domain_text, shown};
use crate::requests::Requests;
use crate::terms::BindingTerms;
use crate::typed_input::TypedInput;
use asmotion_component::{BufferKind, Cycle, Flow, In, Time};
use asmotion_datum::{Datum, DatumError};
use asmotion_lang::ir::{AddedTerm, Program, ValueShape};
use asmotion_lang::value::Value;
use std::borrow::Cow;
use std::time::Duration;

/// The binding of a monitored function: the messages, and the locations that take their values.
pub(crate) struct BoundInput {
    pub located: BoundLocations,
    pub(super) from: MessageOrigin,
    pub(super) receive: Receive,
    pub(super) field: Option<String>,
    pub(super) is: Vec<String>,
    pub(super) none: Value,
    pub(super) stale: Option<(Duration, Value)>,
    pub matching: Option<MessageCondition>,
    /// Number of messages lost on the way to the port, as of the current cycle and as of the last step.
    pub lost: LostMessages,
    /// In the order of [`BoundLocations::all`].
    pub locations: Vec<InputLocation>,
    /// A message whose key selects no element has been reported.
    pub reported_key: bool,
    /// A message that waited too long has been reported.
    pub reported_expiry: bool,
    /// Causes for which messages have been refused, and which have been reported.
    pub causes: MisfitCauses,
}

/// The values that fields of messages must have.
pub(crate) struct MessageCondition {
    pub(super) content: BoundContent,
    /// The values in this cycle; `None` while one of them is unknown.
    pub expected: Option<Datum>,
    /// A refused message has been reported.
    pub reported: bool,
}

/// Numbers of lost messages since the start of the system.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct LostMessages {
    pub(super) now: u64,
    pub before: u64,
}

/// A location and the messages for it.
pub(crate) struct InputLocation {
    pub arguments: Vec<Value>,
    /// Position in the frame.
    pub(super) position: usize,
    /// Time of the newest message; of a timer, the time of its start.
    pub newest: Option<Time>,
    /// A message has arrived since the start of the process; for observers, not part of the frozen state.
    pub has_received: bool,
    pub last: Option<Value>,
    pub waiting: EventQueue,
}

/// Origin of an input's messages.
#[derive(Clone, Copy)]
pub(super) enum MessageOrigin {
    /// Outcomes of calls only.
    Calls,
    Port(In<Datum>),
    /// Requests for the operation at this position.
    Requests(usize),
    /// No messages: the value is the number of messages lost on the way to a port.
    Losses(In<Datum>),
    /// No messages: the value is true once the term has held for this long.
    Timer(AddedTerm, Duration),
}

/// Result of taking a message into the locations of an input.
enum Taken {
    Yes,
    /// The queue was full: it or an older message, this one, was dropped.
    Dropped(Arrival),
    /// Its value does not fit the codomain.
    Misfit,
    /// Its key selects no element.
    UnknownKey,
    /// It does not have the expected values.
    Refused,
}

/// Messages that an input has not taken, or has dropped for others.
#[derive(Default)]
pub(super) struct Unused {
    pub dropped: Vec<Arrival>,
    /// Number of messages that do not fit.
    pub misfits: u64,
}

impl BoundInput {
    pub(super) fn new(
        monitored: &Monitored,
        located: BoundLocations,
        from: MessageOrigin,
        program: &Program,
    ) -> Result<Self, BindError> {
        let shape = &located.codomain;
        if let (Source::Losses(_), false) = (&monitored.from, LostMessages::fits(shape)) {
            return Err(BindError::NoCount {
                function: monitored.location.to_string(),
            });
        }
        let constant = |constant: Option<&Constant>| match constant {
            None => Ok(Value::Undef),
            Some(it) => value_of(&it.datum, shape, program).ok_or_else(|| BindError::NotAValue {
                function: monitored.location.to_string(),
                value: if it.secret {
                    format!("{it:?}")
                } else {
                    it.datum.to_string()
                },
            }),
        };
        let none = constant(match &monitored.from {
            Source::Value(value) => Some(value),
            Source::Port(_) | Source::Request(_) | Source::Losses(_) | Source::Timer { .. } => {
                monitored.none.as_ref()
            }
        })?;
        let stale = match monitored.stale_ms {
            Some(age) => Some((
                Duration::from_millis(age),
                constant(monitored.on_stale.as_ref())?,
            )),
            None => None,
        };
        Ok(Self {
            located,
            from,
            receive: monitored.receive,
            field: monitored.field.clone().or_else(|| monitored.map.clone()),
            is: monitored.is.clone(),
            none,
            stale,
            matching: None,
            lost: LostMessages::default(),
            locations: Vec::new(),
            reported_key: false,
            reported_expiry: false,
            causes: MisfitCauses::default(),
        })
    }

    /// Returns whether only the newest message of a cycle counts. With a key, each message is for a location of its
    /// own; with a condition, the newest one may be refused.
    fn takes_newest(&self) -> bool {
        let of_state = match self.receive {
            Receive::Last => true,
            Receive::Edge => self.is.is_empty(),
            Receive::All => false,
        };
        of_state && self.located.key.is_empty() && self.matching.is_none()
    }

    /// Removes the messages that have waited for longer than their connection allows, which it returns, and the current values if
    /// the policy of the connection forgets stale data.
    pub(super) fn discard_stale(&mut self, port: In<Datum>, cycle: &Cycle<'_>) -> Vec<Arrival> {
        let forgets = cycle.is_stale(port) && matches!(cycle.read(port), Flow::NoData);
        let mut removed = Vec::new();
        for location in &mut self.locations {
            location.waiting.remove_expired(cycle.now(), &mut removed);
            if forgets {
                location.last = None;
            }
        }
        removed
    }

    /// Takes the messages of a cycle. Adds notices about those that do not fit, and returns the numbers of lost ones. A message of
    /// another type than its port is counted for the first function that the port is bound to, and added to `mistyped`.
    pub(super) fn take_all(
        &mut self,
        arrived: &ArrivedMessages<'_>,
        (requests, program): (&Requests, &Program),
        mistyped: &mut Vec<(In<Datum>, usize)>,
        notices: &mut Vec<String>,
    ) -> Unused {
        let mut lost = Unused::default();
        let only_newest = self.takes_newest();
        for (position, message) in arrived.each(only_newest) {
            let expiry = arrived.expiries.get(position).copied().flatten();
            let message = match arrived.fitting(message) {
                Ok(message) => message,
                Err((typed, error)) => {
                    let key = (typed.port, position);
                    if !mistyped.contains(&key) {
                        mistyped.push(key);
                        lost.misfits += 1;
                        notices.extend(self.mistyped(typed, &error, message));
                    }
                    continue;
                }
            };
            let (message, at) = (&*message, arrived.now);
            let arrival = Arrival { at, position };
            match self.take(message, arrival, arrived.queue, expiry, program) {
                Taken::Yes => {}
                Taken::Dropped(dropped) => lost.dropped.push(dropped),
                Taken::Refused => {
                    lost.misfits += 1;
                    notices.extend(self.refused(message, program));
                }
                Taken::Misfit => {
                    lost.misfits += 1;
                    let typed = arrived.typed.map(|it| &*it.name);
                    notices.extend(self.misfit(typed, message, requests, program));
                    continue;
                }
                Taken::UnknownKey => {
                    lost.misfits += 1;
                    if !std::mem::replace(&mut self.reported_key, true) {
                        notices.push(self.unknown_key(message, program));
                    }
                }
            }
            if only_newest {
                break;
            }
        }
        lost
    }

    fn take(
        &mut self,
        message: &Datum,
        arrival: Arrival,
        queue: BufferKind,
        expiry: Option<Time>,
        program: &Program,
    ) -> Taken {
        let condition = self.matching.as_ref();
        if condition.is_some_and(|condition| !condition.accepts(message)) {
            return Taken::Refused;
        }
        let Some(position) = self.selected(message, program) else {
            return Taken::UnknownKey;
        };
        if let Some(location) = self.locations.get_mut(position) {
            location.has_received = true;
        }
        let value = match self.receive {
            Receive::Edge if self.is.is_empty() => Some(Value::Bool(true)),
            Receive::Edge => {
                let truth = Value::Bool(true);
                if self.value(message, program).as_ref() != Some(&truth) {
                    return Taken::Yes;
                }
                Some(truth)
            }
            Receive::Last | Receive::All => self.value(message, program),
        };
        let (Some(value), Some(location)) = (value, self.locations.get_mut(position)) else {
            return Taken::Misfit;
        };
        match self.receive {
            Receive::Edge => location.last = Some(value),
            Receive::Last => {
                location.newest = Some(arrival.at);
                location.last = Some(value);
            }
            Receive::All => {
                let waiting = &mut location.waiting;
                if let Some(dropped) = waiting.push_message(value, arrival, expiry, queue) {
                    return Taken::Dropped(dropped);
                }
            }
        }
        Taken::Yes
    }

    /// Iterates over the locations that messages are bound to and none has arrived for.
    pub fn silent(&self) -> impl Iterator<Item = &InputLocation> {
        let is_bound = match self.from {
            MessageOrigin::Calls | MessageOrigin::Timer(..) | MessageOrigin::Losses(_) => false,
            MessageOrigin::Port(_) | MessageOrigin::Requests(_) => true,
        };
        let locations = self.locations.iter();
        locations.filter(move |location| is_bound && !location.has_received)
    }

    /// Forgets the newest messages: the port has none, as before the first one. Returns whether there were any.
    pub(super) fn forget(&mut self) -> bool {
        if self.receive != Receive::Last {
            return false;
        }
        let mut had_message = false;
        for location in &mut self.locations {
            had_message |= location.last.take().is_some();
            location.newest = None;
        }
        had_message
    }

    /// Returns whether a location holds the value of its newest message.
    pub fn remembers(&self, location: &InputLocation) -> bool {
        self.receive == Receive::Last && location.last.is_some()
    }

    /// Number of messages for a location that no step has read yet.
    pub fn unread(&self, location: &InputLocation) -> u64 {
        match self.receive {
            Receive::Last => 0,
            Receive::Edge => u64::from(location.last.is_some()),
            Receive::All => {
                let waiting = location.waiting.iter();
                waiting.filter(|event| event.is_message()).count() as u64
            }
        }
    }

    /// Returns whether a timer runs for a location.
    pub fn is_timed(&self, location: &InputLocation) -> bool {
        matches!(self.from, MessageOrigin::Timer(..)) && location.newest.is_some()
    }

    /// Describes that the newest messages are gone.
    pub(super) fn without_connection(&self, program: &Program) -> String {
        let name = self.name(program);
        format!(
            "`{name}` is without a message: the connection of its last one does not exist any more"
        )
    }

    pub fn name<'p>(&self, program: &'p Program) -> &'p str {
        let symbols = &program.symbols.functions;
        let name = symbols.get(self.located.function.0 as usize);
        name.map_or("", |name| &**name)
    }

    /// Position of the location that the key of a message selects.
    pub(super) fn selected(&self, message: &Datum, program: &Program) -> Option<usize> {
        let selected = self.located.key.iter();
        let selected = selected
            .map(|field| value_of(&*message.get(&field.path)?, &field.shape, program))
            .collect::<Option<Vec<_>>>()?;
        self.located.position(&selected)
    }

    /// Describes the first message that is refused.
    fn refused(&mut self, message: &Datum, program: &Program) -> Option<String> {
        let condition = self.matching.as_mut()?;
        if std::mem::replace(&mut condition.reported, true) {
            return None;
        }
        let expected = condition.expected.as_ref();
        let expected = expected.map_or_else(|| "nothing yet".to_owned(), |it| format!("{it}"));
        let name = self.name(program);
        Some(format!(
            "a message for `{name}` is refused: expected {expected}, found {message}; such messages are counted as misfits"
        ))
    }

    /// Describes a message that is not of the type of its port.
    fn mistyped(
        &mut self,
        port: &TypedInput,
        error: &DatumError,
        message: &Datum,
    ) -> Option<String> {
        let TypedInput { name, schema, .. } = port;
        self.causes.new_cause(|| {
            let found = shown(message);
            format!("`{name}` (`{schema}`) refuses a message: {error}; found {found}")
        })
    }

    /// Describes a message whose value is not one of the function.
    fn misfit(
        &mut self,
        port: Option<&str>,
        message: &Datum,
        requests: &Requests,
        program: &Program,
    ) -> Option<String> {
        let (field, function) = (self.field.as_deref(), self.name(program).to_owned());
        let domain = domain_text(&self.located.codomain, program);
        let from = match (port, self.from) {
            (Some(port), _) => format!("`{port}` refuses a message"),
            (None, MessageOrigin::Requests(position)) => {
                let operation = requests.served.get(position).map(|it| &it.operation);
                let operation = operation.map_or_else(String::new, ToString::to_string);
                format!("`{operation}` refuses a request")
            }
            (None, _) => return None,
        };
        let part = field.map_or(Some(Cow::Borrowed(message)), |field| message.get(field));
        let field = field.map_or_else(String::new, |field| format!(" in `{field}`"));
        self.causes.new_cause(|| {
            let found = part.map_or_else(|| "nothing".to_owned(), |part| shown(&part));
            format!("{from}: `{function}` is of the domain {domain}, found {found}{field}")
        })
    }

    /// Describes the first messages that waited too long.
    pub(super) fn expired(&mut self, count: usize, program: &Program) -> Option<String> {
        if count == 0 || std::mem::replace(&mut self.reported_expiry, true) {
            return None;
        }
        let functions = &program.symbols.functions;
        let function = functions.get(self.located.function.0 as usize);
        Some(format!(
            "messages for `{}` waited for a step for longer than the `max_age_ms` of their connection allows; such messages are \
             discarded and counted as lost",
            function.map_or("", |name| &**name),
        ))
    }

    /// Describes a message whose key selects no element.
    fn unknown_key(&self, message: &Datum, program: &Program) -> String {
        let fields = self.located.key.iter().map(|field| {
            let found = message.get(&field.path);
            let found = found.map_or_else(|| "nothing".to_owned(), |it| shown(&it));
            format!("`{}` is {found}", field.path)
        });
        format!(
            "a message for `{}` selects no location: {}; such messages are counted as misfits",
            self.name(program),
            fields.collect::<Vec<_>>().join(", ")
        )
    }

    pub(super) fn value(&self, message: &Datum, program: &Program) -> Option<Value> {
        let part = match &self.field {
            Some(field) => message.get(field)?,
            None => Cow::Borrowed(message),
        };
        if self.is.is_empty() {
            return value_of(&part, &self.located.codomain, program);
        }
        let text = part.as_text()?;
        Some(Value::Bool(self.is.iter().any(|known| known == text)))
    }
}

impl MessageOrigin {
    /// The port that the messages arrive at.
    pub(super) fn port(self) -> Option<In<Datum>> {
        match self {
            Self::Port(port) => Some(port),
            Self::Calls | Self::Requests(_) | Self::Losses(_) | Self::Timer(..) => None,
        }
    }

    /// Returns whether an input with this origin receives the messages of another one as well.
    pub(super) fn shares_messages(self, other: Self) -> bool {
        match (self, other) {
            (Self::Port(one), Self::Port(other)) => one == other,
            (Self::Requests(one), Self::Requests(other)) => one == other,
            _ => false,
        }
    }
}

impl MessageCondition {
    /// Resolves a condition; `None` if every message is accepted.
    pub(super) fn new(
        matching: &[(String, Argument)],
        terms: &BindingTerms,
    ) -> Result<Option<Self>, BindError> {
        if matching.is_empty() {
            return Ok(None);
        }
        let fields = matching.iter();
        let fields =
            fields.map(|(name, value)| Ok((name.clone(), BoundContent::resolve(value, terms)?)));
        Ok(Some(Self {
            content: BoundContent::Record(fields.collect::<Result<_, BindError>>()?),
            expected: None,
            reported: false,
        }))
    }

    pub(super) fn accepts(&self, message: &Datum) -> bool {
        let expected = self.expected.as_ref();
        expected.is_some_and(|expected| has_values(message, expected))
    }
}

impl LostMessages {
    pub(super) fn fits(codomain: &ValueShape) -> bool {
        matches!(
            codomain,
            ValueShape::Bool | ValueShape::Int | ValueShape::Natural
        )
    }

    /// The messages lost since the last step: their number or, for a Boolean function, whether there are any.
    pub(super) fn value(self, codomain: &ValueShape) -> Value {
        let count = self.now.saturating_sub(self.before);
        if *codomain == ValueShape::Bool {
            return Value::Bool(count > 0);
        }
        Value::Int(i64::try_from(count).unwrap_or(i64::MAX))
    }
}

impl InputLocation {
    /// Returns true once the timer that `newest` started has run for `after`.
    pub(super) fn has_elapsed(&self, after: Duration, now: Time) -> Value {
        Value::Bool(self.newest.is_some_and(|since| now.since(since) >= after))
    }

    pub(super) fn current_value(
        &self,
        now: Time,
        stale: &Option<(Duration, Value)>,
        none: &Value,
    ) -> Value {
        if let Some((age, value)) = stale
            && self.newest.is_none_or(|newest| now.since(newest) > *age)
        {
            return value.clone();
        }
        self.last.clone().unwrap_or_else(|| none.clone())
    }
}

pub(super) fn origin(
    source: &Source,
    ports: &[TypedInput],
    requests: &Requests,
    terms: &BindingTerms,
) -> Result<MessageOrigin, BindError> {
    let port = |name: &String| {
        let port = ports.iter().find(|known| known.name == *name);
        let port = port.ok_or_else(|| BindError::UnknownPort { port: name.clone() })?;
        Ok(port.port)
    };
    match source {
        Source::Value(_) => Ok(MessageOrigin::Calls),
        Source::Timer { running, ms } => {
            let after = Duration::from_millis(*ms);
            Ok(MessageOrigin::Timer(terms.get(running)?, after))
        }
        Source::Port(name) => Ok(MessageOrigin::Port(port(name)?)),
        Source::Losses(name) => Ok(MessageOrigin::Losses(port(name)?)),
        Source::Request(operation) => {
            let position = requests.position(operation);
            position
                .map(MessageOrigin::Requests)
                .ok_or_else(|| BindError::UnknownOperation(operation.clone()))
        }
    }
}
