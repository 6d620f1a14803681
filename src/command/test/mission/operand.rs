//! Operands of conditions, with their present values.

use asmotion_component::{State, Time};
use asmotion_composite::At;
use asmotion_coordinator::{STEP_REPORT, StepRecord, VIOLATION_REPORT};
use asmotion_datum::{Datum, Sample};
use asmotion_runtime::Event;

use super::condition::ObservedValue;

/// A place in a condition, as written.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum WrittenPlace {
    /// A port or topic whose messages contain a position.
    Moving(At<String>),
    /// x and y in m.
    Fixed([f64; 2]),
}

/// Origin of messages.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum SampleOrigin {
    /// Output port of a component.
    Output { component: String, port: String },
    /// Topic.
    Topic(String),
}

/// The position in messages of an origin.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ObservedPosition {
    pub origin: SampleOrigin,
    /// Path of the record with `x` and `y` in the message.
    pub path: String,
    /// Newest position.
    pub newest: Option<[f64; 2]>,
}

/// A place whose distance to another is observed.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum ObservedPlace {
    Moving(ObservedPosition),
    Fixed([f64; 2]),
}

/// Origin of the value of an operand.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Observation {
    /// A location of a specification.
    Location { component: String, location: String },
    /// A field of the newest message.
    Field { origin: SampleOrigin, path: String },
    /// Speed in the plane, from a velocity in the messages.
    Velocity { origin: SampleOrigin, path: String },
    /// Speed in the plane, from consecutive positions.
    Movement {
        of: ObservedPosition,
        /// Time of the newest position.
        at: Time,
    },
    /// Distance in the plane.
    Distance(ObservedPlace, ObservedPlace),
    /// State of the life cycle of a component.
    LifeCycle { component: String },
    /// Number of violations of properties that a component has reported.
    Violations { component: String, count: u32 },
}

/// An operand of conditions.
#[derive(Clone, Debug)]
pub(super) struct Operand {
    /// The operand as written in conditions.
    pub name: String,
    pub observation: Observation,
}

impl SampleOrigin {
    /// The message that an event brings from this origin.
    fn message<'e>(&self, event: &Event<'e>) -> Option<&'e dyn Sample> {
        match (event, self) {
            (
                Event::Published {
                    component: writer,
                    port: output,
                    sample,
                    ..
                },
                Self::Output { component, port },
            ) => (*writer == component && *output == port).then_some(*sample),
            (Event::Published { topic, sample, .. }, Self::Topic(name)) => {
                (*topic == Some(name)).then_some(*sample)
            }
            (Event::Injected { target, sample, .. }, Self::Topic(name)) => {
                (*target == name).then_some(*sample)
            }
            _ => None,
        }
    }

    fn datum(&self, event: &Event<'_>) -> Option<Datum> {
        self.message(event)?.to_datum().ok()
    }
}

impl ObservedPosition {
    /// Takes the position of an event. Returns whether there is a new one.
    fn update(&mut self, event: &Event<'_>) -> bool {
        let datum = self.origin.datum(event);
        let position = datum.and_then(|datum| vector(&datum, &self.path));
        self.newest = position.or(self.newest);
        position.is_some()
    }
}

impl ObservedPlace {
    fn update(&mut self, event: &Event<'_>) -> bool {
        match self {
            Self::Moving(position) => position.update(event),
            Self::Fixed(_) => false,
        }
    }

    fn position(&self) -> Option<[f64; 2]> {
        match self {
            Self::Moving(position) => position.newest,
            Self::Fixed(position) => Some(*position),
        }
    }
}

/// The components `x` and `y` of a record in a message.
fn vector(datum: &Datum, path: &str) -> Option<[f64; 2]> {
    let component = |name: &str| datum.get(&format!("{path}.{name}"))?.as_float();
    Some([component("x")?, component("y")?])
}

fn length([x, y]: [f64; 2]) -> f64 {
    x.hypot(y)
}

fn difference(from: [f64; 2], to: [f64; 2]) -> [f64; 2] {
    [to[0] - from[0], to[1] - from[1]]
}

impl Observation {
    /// The new value that an event gives the operand; `None` if it does not concern it.
    pub(super) fn update(&mut self, now: Time, event: &Event<'_>) -> Option<ObservedValue> {
        match self {
            Self::Location {
                component,
                location,
            } => updated(component, location, event),
            Self::Field { origin, path } => {
                let datum = origin.datum(event)?;
                ObservedValue::of_datum(&*datum.get(path)?)
            }
            Self::Velocity { origin, path } => {
                let velocity = vector(&origin.datum(event)?, path)?;
                Some(ObservedValue::Number(length(velocity)))
            }
            Self::Movement { of, at } => {
                let (before, since) = (of.newest, *at);
                if !of.update(event) {
                    return None;
                }
                *at = now;
                let moved = difference(before?, of.newest?);
                let seconds = now.since(since).as_secs_f64();
                (seconds > 0.0).then(|| ObservedValue::Number(length(moved) / seconds))
            }
            Self::Distance(from, to) => {
                let (first, second) = (from.update(event), to.update(event));
                if !first && !second {
                    return None;
                }
                let between = difference(from.position()?, to.position()?);
                Some(ObservedValue::Number(length(between)))
            }
            Self::Violations { component, count } => {
                if let Event::Report {
                    component: of,
                    kind: VIOLATION_REPORT,
                    ..
                } = event
                {
                    *count += u32::from(of == component);
                    return (of == component).then(|| ObservedValue::Number(f64::from(*count)));
                }
                // the number is known as soon as the component is there
                let is_there =
                    matches!(event, Event::LifeCycle { component: of, .. } if of == component);
                is_there.then(|| ObservedValue::Number(f64::from(*count)))
            }
            Self::LifeCycle { component } => {
                if let Event::LifeCycle {
                    component: of, to, ..
                } = event
                {
                    (*of == component).then(|| life_cycle(*to))
                } else {
                    None
                }
            }
        }
    }
}

/// The state of a component as a value of conditions.
pub(super) fn life_cycle(state: State) -> ObservedValue {
    ObservedValue::Text(state.to_string())
}

/// The value that a step gives a location.
fn updated(component: &str, location: &str, event: &Event<'_>) -> Option<ObservedValue> {
    let Event::Report {
        component: of,
        kind,
        data,
    } = event
    else {
        return None;
    };
    if *of != component || *kind != STEP_REPORT {
        return None;
    }
    let step: StepRecord = data.to().ok()?;
    let mut updates = step.updates.iter();
    let update = updates.find(|update| update.location == location)?;
    Some(ObservedValue::of_location(&update.after))
}
