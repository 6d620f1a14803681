//! The flow of input values through a program: what inputs are compared with, and where else their values go.
//!
//! The analysis follows the values of each input through variables, parameters and definitions to the comparisons that they take
//! part in, and determines a superset of the values on the other side. An input whose values go nowhere else needs one value for
//! each region between those that it is compared with: two values of a region give the same steps.

mod rule;
mod term;

use crate::inputs::{InputRanges, MAX_VALUES};
use asmotion_lang::ir::{
    BinderRange, Body, BodyId, FunctionId, FunctionKind, Local, Origin, Program, RoutineId, Term,
    ValueShape,
};
use asmotion_lang::{Machine, Value};
use std::collections::{BTreeMap, BTreeSet};

/// Limit for the values of a term that are listed.
const MAX_LISTED: usize = 1024;

/// Passes over the program after which values that are still increasing count as unknown.
const MAX_PASSES: usize = 64;

/// The use of an input.
#[derive(Clone, Debug, Default)]
pub(crate) struct InputUse {
    /// The values that it is compared with, or more.
    pub compared: BTreeSet<Value>,
    /// The inputs that it is compared with, of the same type.
    pub related: BTreeSet<FunctionId>,
    /// Number of its locations, if it is compared with an input.
    pub locations: usize,
    /// The first place where its value is needed.
    pub escape: Option<Escape>,
    /// The first place where it is read.
    pub read: Origin,
}

/// A place where the value of an input matters, rather than the region in which it lies.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Escape {
    pub at: Origin,
    pub usage: EscapeUse,
}

/// The use that is made of an input's value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum EscapeUse {
    /// It is stored in a location of the function.
    Stored(FunctionId),
    /// Rules update the input.
    Updated,
    /// It is an argument of a library function or an operand of an operator, given by its name.
    Operand(&'static str),
    /// It is an argument of a function with locations.
    Argument(FunctionId),
    /// It is compared with another input whose values cannot be enumerated.
    ComparedWithInput(FunctionId),
    /// It is compared with a value that is not known to be one of few.
    ComparedWithUnknown,
    /// It becomes a part of a tuple or collection, the range of a variable, or the argument of a rule that is a value.
    Other,
    /// It is sent in a message.
    Sent,
}

impl EscapeUse {
    /// Describes the use in words, for the place where it is made.
    pub fn describe(&self, name: &dyn Fn(FunctionId) -> String) -> String {
        match self {
            Self::Stored(function) => format!("its value is stored in `{}` here", name(*function)),
            Self::Updated => "rules update it here".to_owned(),
            Self::Operand(operand) => {
                let sign = match *operand {
                    "plus" => "+",
                    "minus" => "-",
                    "mult" => "*",
                    "div" => "/",
                    other => other,
                };
                format!("`{sign}` computes with its value here")
            }
            Self::Argument(function) => {
                format!("its value is an argument of `{}` here", name(*function))
            }
            Self::ComparedWithInput(other) => format!(
                "it is compared here with `{}`, whose values cannot be enumerated either",
                name(*other)
            ),
            Self::ComparedWithUnknown => {
                "it is compared here with a value that is not known to be one of few".to_owned()
            }
            Self::Other => "more than comparisons depends on its value here".to_owned(),
            Self::Sent => "its value is sent here".to_owned(),
        }
    }
}

/// Analyses the use of inputs without a range. If inputs keep their values from one step to the next, they cannot be compared with
/// each other: a value that an input keeps would have to stay apart from all values that the others get.
pub(crate) fn input_uses(
    machine: &Machine,
    ranges: &InputRanges,
    inputs: &BTreeSet<FunctionId>,
    are_kept: bool,
) -> BTreeMap<FunctionId, InputUse> {
    if inputs.is_empty() {
        return BTreeMap::new();
    }
    let mut analysis = InputFlow {
        machine,
        program: machine.program(),
        ranges,
        inputs,
        are_kept,
        points: BTreeMap::new(),
        reached: BTreeSet::new(),
        frame: Frame::Body(BodyId(0)),
        passes: 0,
        has_changed: true,
        uses: BTreeMap::new(),
    };
    analysis.run();
    analysis.uses
}

/// Code with variables of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Frame {
    Body(BodyId),
    Routine(RoutineId),
}

/// A place through which values flow.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Point {
    /// The locations of a function.
    Function(FunctionId),
    Variable(Frame, Local),
    /// The value of a definition.
    Result(BodyId),
}

/// The values that a term can denote, besides undef.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Denotation {
    /// Values of these inputs.
    inputs: BTreeSet<FunctionId>,
    /// These values; `None` if any value is possible.
    values: Option<BTreeSet<Value>>,
}

impl Denotation {
    /// Undef only.
    fn nothing() -> Self {
        Self::listed([])
    }

    fn any() -> Self {
        Self {
            inputs: BTreeSet::new(),
            values: None,
        }
    }

    fn listed(values: impl IntoIterator<Item = Value>) -> Self {
        let mut listed = BTreeSet::new();
        for value in values {
            listed.insert(value);
            if listed.len() > MAX_LISTED {
                return Self::any();
            }
        }
        Self {
            inputs: BTreeSet::new(),
            values: Some(listed),
        }
    }

    fn of_input(input: FunctionId) -> Self {
        Self {
            inputs: BTreeSet::from([input]),
            ..Self::nothing()
        }
    }

    /// Values of a location after the value is stored in it: that of an input can be any value.
    fn stored(self) -> Self {
        Self {
            values: self.values.filter(|_| self.inputs.is_empty()),
            inputs: BTreeSet::new(),
        }
    }

    fn or(mut self, other: Self) -> Self {
        self.inputs.extend(other.inputs);
        let both = self.values.zip(other.values);
        self.values = both.and_then(|(mut values, others)| {
            values.extend(others);
            (values.len() <= MAX_LISTED).then_some(values)
        });
        self
    }
}

struct InputFlow<'a> {
    machine: &'a Machine,
    program: &'a Program,
    ranges: &'a InputRanges,
    /// The inputs without a range.
    inputs: &'a BTreeSet<FunctionId>,
    /// `true` if inputs can keep their values.
    are_kept: bool,
    points: BTreeMap<Point, Denotation>,
    /// Code that is executed.
    reached: BTreeSet<Frame>,
    /// The code that is being visited.
    frame: Frame,
    passes: usize,
    has_changed: bool,
    uses: BTreeMap<FunctionId, InputUse>,
}

impl InputFlow<'_> {
    /// Visits the code that is executed until nothing new is found. All facts only grow, so the last pass has all of them.
    fn run(&mut self) {
        let program = self.program;
        let routines = program.main.into_iter().chain(program.added_rules.clone());
        for routine in routines {
            self.open(Frame::Routine(routine));
        }
        let conditions = program.added_terms.iter().copied();
        let invariants = program.invariants.iter().map(|it| it.body);
        for body in conditions.chain(invariants) {
            self.open(Frame::Body(body));
        }
        for body in program.functions.iter().filter_map(|it| it.initial) {
            self.open(Frame::Body(body));
        }
        while std::mem::take(&mut self.has_changed) {
            self.passes += 1;
            for frame in self.reached.clone() {
                self.frame = frame;
                match frame {
                    Frame::Routine(id) => {
                        if let Some(routine) = program.routines.get(id.0 as usize) {
                            self.rule(&routine.code);
                        }
                    }
                    Frame::Body(id) => {
                        if let Some(body) = program.bodies.get(id.0 as usize) {
                            let flow = self.term(&body.code);
                            self.join(Point::Result(id), flow);
                        }
                    }
                }
            }
            self.initial_values();
        }
    }

    /// Initial values are stored in the locations of their functions.
    fn initial_values(&mut self) {
        for (index, function) in self.program.functions.iter().enumerate() {
            let Some(body) = function.initial else {
                continue;
            };
            let id = FunctionId(index as u32);
            let origin = self.program.bodies.get(body.0 as usize);
            let origin = origin.map_or(Origin::default(), |body| body.origin);
            let flow = self.at(Point::Result(body));
            self.escape(&flow, origin, &EscapeUse::Stored(id));
            self.join(Point::Function(id), flow.stored());
        }
    }

    /// Marks code as executed, with arguments that are not known.
    fn open(&mut self, frame: Frame) {
        let arguments = match frame {
            Frame::Body(id) => arguments_of(&self.program.bodies, id.0),
            Frame::Routine(id) => arguments_of(&self.program.routines, id.0),
        };
        self.reach(frame);
        for argument in 0..arguments {
            self.join(Point::Variable(frame, argument), Denotation::any());
        }
    }

    fn reach(&mut self, frame: Frame) {
        self.has_changed |= self.reached.insert(frame);
    }

    /// Marks code as executed, with the values of its arguments.
    fn call(&mut self, frame: Frame, arguments: &[Term]) {
        self.reach(frame);
        for (argument, term) in arguments.iter().enumerate() {
            let flow = self.term(term);
            self.join(Point::Variable(frame, argument as Local), flow);
        }
    }

    fn at(&self, point: Point) -> Denotation {
        self.points
            .get(&point)
            .cloned()
            .unwrap_or_else(Denotation::nothing)
    }

    fn join(&mut self, point: Point, flow: Denotation) {
        let known = self.at(point);
        let mut joined = known.clone().or(flow);
        if joined == known {
            return;
        }
        if self.passes > MAX_PASSES {
            joined.values = None;
        }
        self.points.insert(point, joined);
        self.has_changed = true;
    }

    /// A variable that has the values of a range.
    fn bind(&mut self, local: Local, range: &BinderRange) {
        let flow = match range {
            BinderRange::Ints(low, high) => integers(*low, *high),
            BinderRange::Atoms(..) | BinderRange::Bools => Denotation::any(),
            BinderRange::Domain(domain) => self.extent(&ValueShape::Domain(*domain)),
            BinderRange::Elements(term) => self.elements(term),
        };
        self.variable(local, flow);
    }

    fn variable(&mut self, local: Local, flow: Denotation) {
        self.join(Point::Variable(self.frame, local), flow);
    }

    /// The elements of a shape, unless `extend` can add some.
    fn extent(&self, shape: &ValueShape) -> Denotation {
        if let ValueShape::Domain(domain) = shape
            && self
                .program
                .domains
                .get(domain.0 as usize)
                .is_none_or(|it| it.grows)
        {
            return Denotation::any();
        }
        let elements = self.machine.elements(shape, MAX_VALUES);
        elements.map_or_else(Denotation::any, Denotation::listed)
    }

    /// The values of a function's locations.
    fn location(&mut self, function: FunctionId, origin: Origin) -> Denotation {
        if self.inputs.contains(&function) {
            self.uses.entry(function).or_insert_with(|| InputUse {
                read: origin,
                ..InputUse::default()
            });
            return Denotation::of_input(function);
        }
        let Some(declared) = self.program.functions.get(function.0 as usize) else {
            return Denotation::any();
        };
        if declared.mail.is_some() || declared.clock.is_some() {
            return Denotation::any();
        }
        match declared.kind {
            FunctionKind::Monitored | FunctionKind::Shared => match self.ranges.of(function) {
                Ok(values) => Denotation::listed(values.iter().cloned()),
                Err(_) => Denotation::any(),
            },
            FunctionKind::Fixed => Denotation::any(),
            FunctionKind::Controlled | FunctionKind::Out | FunctionKind::Local => {
                let stored = self.at(Point::Function(function));
                // an element, or the initial value, which is not checked
                match self.extent(&declared.codomain) {
                    Denotation { values: None, .. } => stored,
                    elements => elements.or(stored),
                }
            }
        }
    }

    /// A value is stored in a location of a function.
    fn store(&mut self, function: FunctionId, flow: Denotation, origin: Origin) {
        self.escape(&flow, origin, &EscapeUse::Stored(function));
        if self.inputs.contains(&function) {
            let input = Denotation::of_input(function);
            self.escape(&input, origin, &EscapeUse::Updated);
        }
        let declared = self.program.functions.get(function.0 as usize);
        let elements = declared.map(|it| self.extent(&it.codomain));
        // a step that stores another value than an element fails
        if elements.is_none_or(|it| it.values.is_none()) {
            self.join(Point::Function(function), flow.stored());
        }
    }

    /// The value of a term is needed.
    fn need(&mut self, term: &Term, usage: &EscapeUse) -> Denotation {
        let flow = self.term(term);
        self.escape(&flow, term.origin, usage);
        flow
    }

    fn escape(&mut self, flow: &Denotation, at: Origin, usage: &EscapeUse) {
        for input in &flow.inputs {
            let found = self.uses.entry(*input).or_default();
            if found.escape.is_none() {
                found.escape = Some(Escape {
                    at,
                    usage: usage.clone(),
                });
            }
        }
    }

    /// Two terms are compared.
    fn compare(&mut self, left: &Term, right: &Term, is_order: bool, origin: Origin) {
        let (left, right) = (self.term(left), self.term(right));
        self.compared(&left, &right, is_order, origin);
        self.compared(&right, &left, is_order, origin);
    }

    fn compared(
        &mut self,
        inputs: &Denotation,
        other: &Denotation,
        is_order: bool,
        origin: Origin,
    ) {
        for input in &inputs.inputs {
            let stranger = other
                .inputs
                .iter()
                .find(|it| !self.are_related(*input, **it));
            let usage = match (stranger, &other.values) {
                (Some(other), _) => EscapeUse::ComparedWithInput(*other),
                (None, None) => EscapeUse::ComparedWithUnknown,
                // the order of strings has no representatives
                (None, Some(_)) if is_order && self.is_text(*input) => EscapeUse::Other,
                (None, Some(values)) => {
                    let locations = self.locations(*input).unwrap_or(1);
                    let found = self.uses.entry(*input).or_default();
                    found.compared.extend(values.iter().cloned());
                    found.related.extend(&other.inputs);
                    found.locations = locations;
                    continue;
                }
            };
            self.escape(&Denotation::of_input(*input), origin, &usage);
        }
    }

    /// Returns `true` if inputs can be represented although they are compared with each other.
    fn are_related(&self, input: FunctionId, other: FunctionId) -> bool {
        let functions = &self.program.functions;
        let codomain = |id: FunctionId| functions.get(id.0 as usize).map(|it| &it.codomain);
        !self.are_kept
            && codomain(input) == codomain(other)
            && [input, other]
                .into_iter()
                .all(|it| self.locations(it).is_some())
    }

    /// Returns the number of a function's locations, if it has few.
    fn locations(&self, function: FunctionId) -> Option<usize> {
        let declared = self.program.functions.get(function.0 as usize)?;
        let parameters = declared.parameters.iter();
        let elements = parameters.map(|shape| Some(self.extent(shape).values?.len()));
        elements.product()
    }

    fn is_text(&self, function: FunctionId) -> bool {
        let declared = self.program.functions.get(function.0 as usize);
        declared.is_some_and(|it| it.codomain == ValueShape::Text)
    }
}

fn arguments_of<T>(code: &[Body<T>], index: u32) -> u32 {
    code.get(index as usize).map_or(0, |body| body.arguments)
}

/// The integers between two bounds, both included.
fn integers(low: i64, high: i64) -> Denotation {
    if low <= high && high.abs_diff(low) >= MAX_LISTED as u64 {
        return Denotation::any();
    }
    Denotation::listed((low..=high).map(Value::Int))
}
