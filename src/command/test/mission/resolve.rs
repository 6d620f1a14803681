//! Resolves the names in a mission against the plan of its composite.

use std::collections::BTreeMap;

use asmotion_component::{State, Time};
use asmotion_composite::At;
use asmotion_datum::{Schema, Shape};
use asmotion_diagnostics::{Span, similar};
use asmotion_lang::ir::ValueShape;
use asmotion_lang::machine::Machine;
use asmotion_lang::simulate::{self, AwaitedUpdate};
use asmotion_plan::{Component, Implementation, Plan};

use super::condition::{ConditionResult, ObservedValue, Relation};
use super::operand::{
    Observation, ObservedPlace, ObservedPosition, Operand, SampleOrigin, WrittenPlace, life_cycle,
};
use crate::codes::v032::InvalidRunCondition;
use crate::files::DiskLoader;

/// Prefix of topics.
const TOPIC: &str = "topic:";

/// Paths of a position in messages.
const POSITIONS: [&str; 3] = ["pose.pose.position", "pose.position", "position"];

/// Paths of a velocity in messages.
const VELOCITIES: [&str; 3] = ["twist.twist.linear", "twist.linear", "linear"];

/// The names of a plan, and the operands resolved so far.
pub(super) struct PlanNames<'p> {
    plan: &'p Plan,
    /// Initial states of the specifications, by component.
    machines: BTreeMap<&'p str, Machine>,
    pub operands: Vec<Operand>,
    /// Initial values of the operands.
    pub values: Vec<Option<ObservedValue>>,
}

impl<'p> PlanNames<'p> {
    pub(super) fn new(plan: &'p Plan) -> Self {
        let machine = |component: &'p Component| {
            let Implementation::Asm { file, .. } = &component.implementation else {
                return None;
            };
            let specification = asmotion_lang::open(file, &DiskLoader).ok()?;
            Some((&*component.name, specification.machine().ok()?))
        };
        Self {
            plan,
            machines: plan.components.iter().filter_map(machine).collect(),
            operands: Vec::new(),
            values: Vec::new(),
        }
    }

    /// The component of this name.
    pub(super) fn component(&self, name: &At<String>) -> ConditionResult<&'p Component> {
        let known = self.plan.components.iter().map(|it| &it.name);
        let found = self.plan.component(name);
        found.ok_or_else(|| unknown("component", name, known))
    }

    /// Message type of a topic or an input port that is written from outside.
    pub(super) fn written(&self, to: &At<String>) -> ConditionResult<String> {
        if to.starts_with(TOPIC) {
            let (_, kind, field) = self.message(to)?;
            return match field.as_str() {
                "" => Ok(kind),
                _ => Err(invalid(
                    "write a whole message to a topic".to_owned(),
                    field.span,
                )),
            };
        }
        let (component, port) = self.split(to)?;
        let known = component.inputs.iter().map(|it| &it.name);
        let input = component.inputs.iter().find(|it| it.name == *port);
        let input = input
            .ok_or_else(|| unknown(&format!("input of `{}`", component.name), &port, known))?;
        Ok(input.kind.clone())
    }

    /// Resolves a location, or a field of a port or topic.
    pub(super) fn name(&mut self, name: &At<String>) -> ConditionResult<usize> {
        if name.starts_with(TOPIC) || self.location_of(name)?.is_none() {
            let (origin, kind, path) = self.message(name)?;
            let path = self.field(&kind, &path)?;
            return Ok(self.add(name, Observation::Field { origin, path }, None));
        }
        let (component, location) = self.split(name)?;
        let location = location.map(|location| applied(&location));
        let machine = &self.machines[&*component.name];
        let state = simulate::state(machine);
        let value = state
            .into_iter()
            .find(|(known, _)| *known == location.value);
        let value = value.map(|(_, value)| ObservedValue::of_location(&value));
        let observation = Observation::Location {
            component: component.name.clone(),
            location: location.value,
        };
        Ok(self.add(name, observation, value))
    }

    /// Resolves the speed of a port or topic.
    pub(super) fn speed(&mut self, name: &At<String>) -> ConditionResult<usize> {
        let (origin, kind, path) = self.message(name)?;
        let has = |path: &&&str| self.shape(&kind, &format!("{path}.x")).is_some();
        if path.is_empty()
            && let Some(path) = VELOCITIES.iter().find(has)
        {
            let path = (*path).to_owned();
            let observation = Observation::Velocity { origin, path };
            return Ok(self.add_call("speed", name, observation));
        }
        let of = self.position(name)?;
        let at = Time::ZERO;
        Ok(self.add_call("speed", name, Observation::Movement { of, at }))
    }

    /// Resolves the distance between two places.
    pub(super) fn distance(
        &mut self,
        from: WrittenPlace,
        to: WrittenPlace,
    ) -> ConditionResult<usize> {
        let text = |place: &WrittenPlace| match place {
            WrittenPlace::Moving(name) => name.value.clone(),
            WrittenPlace::Fixed([x, y]) => format!("[{x}, {y}]"),
        };
        let name = format!("distance({}, {})", text(&from), text(&to));
        let place = |place| match place {
            WrittenPlace::Moving(name) => self.position(&name).map(ObservedPlace::Moving),
            WrittenPlace::Fixed(at) => Ok(ObservedPlace::Fixed(at)),
        };
        let observation = Observation::Distance(place(from)?, place(to)?);
        Ok(self.push(name, observation, None))
    }

    /// Resolves the life cycle of a component.
    pub(super) fn state(&mut self, name: &At<String>) -> ConditionResult<usize> {
        let component = self.component(name)?.name.clone();
        let observation = Observation::LifeCycle { component };
        Ok(self.add_call("state", name, observation))
    }

    /// Resolves the number of violations of properties in a component.
    pub(super) fn violations(&mut self, name: &At<String>) -> ConditionResult<usize> {
        let component = self.component(name)?.name.clone();
        if !self.machines.contains_key(&*component) {
            let reason = format!("`{component}` runs no specification, so no property is watched");
            return Err(invalid(reason, name.span));
        }
        let observation = Observation::Violations {
            component,
            count: 0,
        };
        Ok(self.add_call("violations", name, observation))
    }

    /// Checks that an operand can be compared with a value.
    pub(super) fn check(
        &self,
        operand: usize,
        relation: Relation,
        with: &ObservedValue,
        name: &At<String>,
    ) -> ConditionResult<()> {
        let at = name.span;
        if relation.is_order() && !matches!(with, ObservedValue::Number(_)) {
            return Err(invalid(format!("`{with}` has no order"), at));
        }
        match &self.operands[operand].observation {
            Observation::Location {
                component,
                location,
            } => {
                let machine = &self.machines[&**component];
                let value = match with {
                    ObservedValue::Text(text) if is_text(machine, location) => {
                        serde_json::Value::from(text.as_str()).to_string()
                    }
                    ObservedValue::Text(_) | ObservedValue::Number(_) | ObservedValue::Truth(_) => {
                        with.to_string()
                    }
                };
                let fits = AwaitedUpdate::of(machine, location, &value);
                fits.map(drop)
                    .map_err(|reason| invalid(reason.to_string(), at))
            }
            Observation::Field { origin, path } => {
                let kind = self.kind(origin);
                match self.shape(&kind, path).map(wanted) {
                    Some(Some(wanted)) if wanted != with.kind() => {
                        let name = &name.value;
                        let found = with.kind();
                        let reason = format!("`{name}` is {wanted}, and `{with}` is {found}");
                        Err(invalid(reason, at))
                    }
                    _ => Ok(()),
                }
            }
            Observation::LifeCycle { .. } => {
                let states = State::ALL.map(|state| state.to_string());
                let word = At::new(with.to_string(), at);
                if State::ALL.iter().any(|state| life_cycle(*state) == *with) {
                    return Ok(());
                }
                Err(unknown("state", &word, &states))
            }
            Observation::Velocity { .. }
            | Observation::Movement { .. }
            | Observation::Violations { .. }
            | Observation::Distance(..) => match with {
                ObservedValue::Number(_) => Ok(()),
                ObservedValue::Truth(_) | ObservedValue::Text(_) => {
                    let name = &name.value;
                    let reason = format!("`{name}` is a number: compare it with one");
                    Err(invalid(reason, at))
                }
            },
        }
    }

    /// Whether a name is a location; `None` if it is a port or a field of one.
    fn location_of(&self, name: &At<String>) -> ConditionResult<Option<String>> {
        let (component, rest) = self.split(name)?;
        let Some(machine) = self.machines.get(&*component.name) else {
            return Ok(None);
        };
        let function = rest.split('(').next().unwrap_or_default();
        let symbols = &machine.program().symbols;
        let is_function = symbols.functions.iter().any(|known| **known == *function);
        if is_function {
            return Ok(Some(rest.value));
        }
        let port = rest.split('.').next().unwrap_or_default();
        if component.outputs.iter().any(|known| known.name == port) {
            return Ok(None);
        }
        let own = machine.program().functions.iter().zip(&symbols.functions);
        let own = own
            .filter(|(function, _)| function.own)
            .map(|(_, name)| name.to_string());
        let outputs = component.outputs.iter().map(|it| it.name.clone());
        let known: Vec<String> = own.chain(outputs).collect();
        let what = format!("location or output of `{}`", component.name);
        Err(unknown(&what, &rest, &known))
    }

    /// Splits a name into its component and the rest.
    fn split(&self, name: &At<String>) -> ConditionResult<(&'p Component, At<String>)> {
        let (component, rest) = name.split_once('.').unwrap_or((name, ""));
        let (start, middle) = (name.span.start as usize, component.len());
        let span = |from: usize, to: usize| Span::new(name.span.file, start + from, start + to);
        let rest = At::new(
            rest.to_owned(),
            span((middle + 1).min(name.len()), name.len()),
        );
        let written = At::new(component.to_owned(), span(0, middle));
        if rest.is_empty() && self.plan.component(&written).is_some() {
            let reason = format!("`{component}` is a component");
            let help = format!(
                "name one of its outputs or locations, as in `{component}.name`, or its life cycle: `state({component})`"
            );
            return Err(invalid_with(reason, written.span, help));
        }
        Ok((self.component(&written)?, rest))
    }

    /// Resolves a port or topic: its origin, message type, and the field named.
    fn message(&self, name: &At<String>) -> ConditionResult<(SampleOrigin, String, At<String>)> {
        let field = |from: usize| {
            let start = name.span.start as usize + from.min(name.len());
            let text = name.get(from..).unwrap_or_default().to_owned();
            At::new(
                text,
                Span::new(name.span.file, start, name.span.end as usize),
            )
        };
        if let Some(rest) = name.strip_prefix(TOPIC) {
            let names = |topic: &&asmotion_plan::Topic| {
                let after = rest.strip_prefix(&*topic.name);
                after.is_some_and(|after| after.is_empty() || after.starts_with('.'))
            };
            let topics = self.plan.topics.iter().filter(names);
            let Some(topic) = topics.max_by_key(|topic| topic.name.len()) else {
                let known = self.plan.topics.iter().map(|it| &it.name);
                let first = rest.split('.').next().unwrap_or_default();
                let written = At::new(first.to_owned(), field(TOPIC.len()).span);
                return Err(unknown("topic", &written, known));
            };
            let path = field(TOPIC.len() + topic.name.len() + 1);
            let kind = topic.kind.clone().unwrap_or_default();
            return Ok((SampleOrigin::Topic(topic.name.clone()), kind, path));
        }
        let (component, rest) = self.split(name)?;
        let port = rest.split('.').next().unwrap_or_default();
        let written = At::new(port.to_owned(), rest.span);
        let Some(output) = component.outputs.iter().find(|it| it.name == port) else {
            return Err(self.no_output(component, &written));
        };
        let path = field(component.name.len() + 1 + port.len() + 1);
        let origin = SampleOrigin::Output {
            component: component.name.clone(),
            port: output.name.clone(),
        };
        Ok((origin, output.kind.clone(), path))
    }

    fn no_output(&self, component: &Component, port: &At<String>) -> Box<InvalidRunCondition> {
        if !component.inputs.iter().any(|it| it.name == **port) {
            let known = component.outputs.iter().map(|it| &it.name);
            let what = format!("output of `{}`", component.name);
            return unknown(&what, port, known);
        }
        let is_here = |end: &asmotion_plan::Terminal| {
            end.to_string() == format!("{}.{}", component.name, **port)
        };
        let mut connections = self.plan.connections.iter();
        let writer = connections.find(|it| is_here(&it.to)).map(|it| &it.from);
        let help = match writer {
            Some(writer) => format!("observe the output that writes it: `{writer}`"),
            None => "observe an output or a topic".to_owned(),
        };
        let reason = format!("`{}` is an input", **port);
        invalid_with(reason, port.span, help)
    }

    /// Checks the path of a field; the only field of a message if it is empty.
    fn field(&self, kind: &str, path: &At<String>) -> ConditionResult<String> {
        let Some(schema) = self.plan.types.get(kind) else {
            return Ok(path.value.clone());
        };
        let path = match (&schema.shape, path.value.as_str()) {
            (Shape::Record(fields), "") if fields.len() == 1 => {
                At::new(fields[0].name.to_string(), path.span)
            }
            _ => path.clone(),
        };
        let mut here = schema;
        for part in path.split('.').filter(|part| !part.is_empty()) {
            here = here.part(part).ok_or_else(|| {
                let part = At::new(part.to_owned(), path.span);
                let known = fields(here);
                unknown(&format!("field of `{kind}`"), &part, &known)
            })?;
        }
        if wanted(&here.shape).is_none() && !matches!(here.shape, Shape::Any | Shape::Option(_)) {
            let known = fields(here).join("`, `");
            let reason = format!("`{kind}` has several fields; name one: `{known}`");
            return Err(invalid(reason, path.span));
        }
        Ok(path.value)
    }

    /// Resolves the position in the messages of a port or topic.
    fn position(&self, name: &At<String>) -> ConditionResult<ObservedPosition> {
        let (origin, kind, path) = self.message(name)?;
        let prefix = match path.value.as_str() {
            "" => String::new(),
            path => format!("{path}."),
        };
        let paths = POSITIONS.iter().map(|path| format!("{prefix}{path}"));
        let mut paths = paths.chain((!path.is_empty()).then(|| path.value.clone()));
        let has = |path: &String| self.shape(&kind, &format!("{path}.x")).is_some();
        let Some(path) = paths.find(has) else {
            let reason = format!(
                "`{}` has no position: its messages are `{kind}`",
                name.value
            );
            return Err(invalid(reason, name.span));
        };
        Ok(ObservedPosition {
            origin,
            path,
            newest: None,
        })
    }

    /// Message type of an origin.
    fn kind(&self, origin: &SampleOrigin) -> String {
        match origin {
            SampleOrigin::Topic(name) => {
                let mut topics = self.plan.topics.iter();
                let topic = topics.find(|topic| topic.name == *name);
                topic.and_then(|it| it.kind.clone()).unwrap_or_default()
            }
            SampleOrigin::Output { component, port } => {
                let outputs = self.plan.component(component).map(|it| &it.outputs);
                let mut outputs = outputs.into_iter().flatten();
                let output = outputs.find(|it| it.name == *port);
                output.map(|it| it.kind.clone()).unwrap_or_default()
            }
        }
    }

    fn shape(&self, kind: &str, path: &str) -> Option<&'p Shape> {
        let schema = self.plan.types.get(kind)?.part_at(path);
        schema.map(|it| &it.shape)
    }

    fn add_call(&mut self, function: &str, name: &At<String>, it: Observation) -> usize {
        self.push(format!("{function}({})", name.value), it, None)
    }

    fn add(
        &mut self,
        name: &At<String>,
        observation: Observation,
        value: Option<ObservedValue>,
    ) -> usize {
        self.push(name.value.clone(), observation, value)
    }

    /// Adds an operand, unless it is known.
    fn push(
        &mut self,
        name: String,
        observation: Observation,
        value: Option<ObservedValue>,
    ) -> usize {
        if let Some(known) = self.operands.iter().position(|it| it.name == name) {
            return known;
        }
        self.operands.push(Operand { name, observation });
        self.values.push(value);
        self.operands.len() - 1
    }
}

/// Whether the values of a location are elements of String, which have quotes in the notation of traces.
fn is_text(machine: &Machine, location: &str) -> bool {
    let name = location.split('(').next().unwrap_or_default();
    let program = machine.program();
    let mut functions = program.functions.iter().zip(&program.symbols.functions);
    functions.any(|(function, known)| {
        function.own && **known == *name && function.codomain == ValueShape::Text
    })
}

/// A location in the notation of traces: `doing(ROB1, TASK2)`.
fn applied(location: &str) -> String {
    let Some((function, arguments)) = location.split_once('(') else {
        return location.to_owned();
    };
    let arguments = arguments.trim_end_matches(')').split(',').map(str::trim);
    let arguments: Vec<&str> = arguments.collect();
    format!("{function}({})", arguments.join(", "))
}

/// Names of the fields of a record.
fn fields(schema: &Schema) -> Vec<String> {
    let fields = schema.fields().iter();
    fields.map(|field| field.name.to_string()).collect()
}

/// The type of literals that a field is compared with; `None` if there are none.
fn wanted(shape: &Shape) -> Option<&'static str> {
    if *shape == Shape::Bool {
        Some("a Boolean")
    } else if *shape == Shape::Text {
        Some("a text")
    } else {
        shape.is_number().then_some("a number")
    }
}

fn invalid(reason: String, at: Span) -> Box<InvalidRunCondition> {
    let help = None;
    Box::new(InvalidRunCondition { reason, at, help })
}

fn invalid_with(reason: String, at: Span, help: String) -> Box<InvalidRunCondition> {
    let help = Some(help);
    Box::new(InvalidRunCondition { reason, at, help })
}

/// An unknown name, with a similar one or the known ones.
fn unknown<N: AsRef<str>>(
    what: &str,
    name: &At<String>,
    known: impl IntoIterator<Item = N>,
) -> Box<InvalidRunCondition> {
    let mut all: Vec<String> = Vec::new();
    for name in known {
        let name = name.as_ref();
        if !all.iter().any(|known| known == name) {
            all.push(name.to_owned());
        }
    }
    let known = all;
    let help = match (similar(name, &known), known.as_slice()) {
        (Some(similar), _) => Some(format!("did you mean `{similar}`?")),
        (None, []) => None,
        (None, known) => Some(format!("known here: `{}`", known.join("`, `"))),
    };
    let reason = format!("unknown {what}: `{}`", name.value);
    let at = name.span;
    Box::new(InvalidRunCondition { reason, at, help })
}
