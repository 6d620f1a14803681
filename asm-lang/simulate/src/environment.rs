//! Scripted inputs: values by name, for each step.
//!
//! ```toml
//! [default]                 # for steps that give no other value
//! estop = false
//!
//! [[step]]
//! goalArrived = true
//!
//! [[step]]
//! ev = "MAP_OK"             # an enumeration literal
//! "battery(ROB1)" = 42      # an argument
//!
//! [partner.planner]         # a simulated agent, and its replies
//! plan = { reply = [3, 4], after = 2 }      # two steps after the request
//! cancel = { fault = "CALL_UNAVAILABLE" }   # in the step after the request
//! ```

use crate::codes::s001::InvalidScript;
use crate::codes::s002::UnknownSection;
use crate::codes::s003::UnknownInput;
use crate::codes::s004::WrongInputValue;
use crate::codes::s005::NotAnAnswer;
use crate::codes::s006::UnknownPartner;
use crate::literal::Literals;
use crate::partner::ScriptedAnswer;
use crate::recorded_message::fault_named;
use asmotion_diagnostics::{FileId, Finding, Report, Span, similar};
use asmotion_ir::{FunctionId, FunctionKind, Program, ValueShape};
use asmotion_machine::{CallFault, Environment};
use asmotion_value::{Atom, Value};
use std::borrow::Cow;
use std::collections::BTreeMap;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// The inputs of a run, for each step.
#[derive(Clone, Debug, Default)]
pub struct Script {
    defaults: InputValues,
    /// Functions that return the time: they default to the run's clock.
    clocks: Vec<FunctionId>,
    steps: Vec<InputValues>,
    /// Replies of simulated partners.
    pub(crate) answers: Vec<ScriptedAnswer>,
    /// Index of the current step, from 0.
    at: usize,
}

type InputValues = BTreeMap<(FunctionId, Vec<Value>), Value>;

impl Script {
    /// Reads a script for a program.
    ///
    /// # Errors
    /// The text is not TOML, or it names no input, or a value is outside the codomain of its
    /// function. All errors are reported.
    pub fn read(file: FileId, text: &str, program: &Program) -> Result<Self, Report> {
        let mut reading = ScriptReader {
            program,
            file,
            report: Report::new(),
        };
        let script = reading.script(text);
        if reading.report.has_errors() {
            Err(reading.report.finish())
        } else {
            Ok(script)
        }
    }

    /// Returns the number of steps in the script.
    pub fn len(&self) -> usize {
        self.steps.len()
    }

    /// Returns `true` if the script has no steps.
    pub fn is_empty(&self) -> bool {
        self.steps.is_empty()
    }

    /// Continues with the inputs of a step, given by its index from 0.
    pub fn go_to(&mut self, step: usize) {
        self.at = step;
    }

    /// Returns the replies of simulated partners.
    pub fn answers(&self) -> &[ScriptedAnswer] {
        &self.answers
    }

    /// Advances to the inputs of the next step.
    pub fn advance(&mut self) {
        self.at += 1;
    }
}

impl Environment for Script {
    fn read(&mut self, function: FunctionId, arguments: &[Value]) -> Result<Option<Value>, String> {
        let key = (function, arguments.to_vec());
        let step = self.steps.get(self.at).and_then(|inputs| inputs.get(&key));
        match step.or_else(|| self.defaults.get(&key)) {
            Some(value) => Ok(Some(value.clone())),
            None if self.clocks.contains(&function) => Ok(None),
            None => Err(format!(
                "step {} of the script does not set it, and it has no default",
                self.at + 1
            )),
        }
    }

    fn source(&self, function: FunctionId, arguments: &[Value]) -> String {
        let key = (function, arguments.to_vec());
        match self.steps.get(self.at).and_then(|inputs| inputs.get(&key)) {
            Some(_) => format!("step {} of the script", self.at + 1),
            None => "`[default]` in the script".to_owned(),
        }
    }
}

struct ScriptReader<'a> {
    program: &'a Program,
    file: FileId,
    report: Report,
}

impl ScriptReader<'_> {
    fn literals(&self) -> Literals<'_> {
        Literals::new(self.program, &[])
    }

    fn span(&self, range: std::ops::Range<usize>) -> Span {
        Span::new(self.file, range.start, range.end)
    }

    fn script(&mut self, text: &str) -> Script {
        let functions = (0..).zip(&self.program.functions);
        let clocks = functions.filter(|(_, function)| function.clock.is_some());
        let mut script = Script {
            clocks: clocks.map(|(index, _)| FunctionId(index)).collect(),
            ..Script::default()
        };
        let table = match DeTable::parse(text) {
            Ok(table) => table.into_inner(),
            Err(error) => {
                let at = self.span(error.span().unwrap_or(0..0));
                self.report.push(
                    InvalidScript {
                        message: error.message().to_owned(),
                        at,
                    }
                    .diagnostic(),
                );
                return script;
            }
        };
        for (key, value) in &table {
            match (&**key.get_ref(), value.get_ref()) {
                ("partner", DeValue::Table(partners)) => {
                    for (name, operations) in partners {
                        script.answers.extend(self.partner(name, operations));
                    }
                }
                ("default", DeValue::Table(inputs)) => script.defaults = self.inputs(inputs),
                ("step", DeValue::Array(steps)) => {
                    for step in steps {
                        if let DeValue::Table(inputs) = step.get_ref() {
                            script.steps.push(self.inputs(inputs));
                        } else {
                            self.not_a_section(step.span());
                        }
                    }
                }
                _ => self.not_a_section(key.span()),
            }
        }
        script
    }

    /// Reads the replies of a partner to its operations.
    fn partner(
        &mut self,
        name: &Spanned<Cow<'_, str>>,
        operations: &Spanned<DeValue<'_>>,
    ) -> Vec<ScriptedAnswer> {
        let atoms = &self.program.symbols.atoms;
        let Some(atom) = (0..)
            .zip(atoms)
            .find(|(_, atom)| ***atom == **name.get_ref())
        else {
            let at = self.span(name.span());
            let name = name.get_ref();
            let similar = similar(name, atoms).cloned();
            let name = name.to_string();
            self.report
                .push(UnknownPartner { name, at, similar }.diagnostic());
            return Vec::new();
        };
        let DeValue::Table(operations) = operations.get_ref() else {
            self.not_an_answer(operations.span());
            return Vec::new();
        };
        let mut answers = Vec::new();
        for (operation, answer) in operations {
            match self.answer(operation.get_ref(), answer.get_ref()) {
                Some((outcome, after)) => answers.push(ScriptedAnswer {
                    partner: Value::Atom(Atom(atom.0)),
                    operation: asmotion_stdlib::operation(operation.get_ref()).to_owned(),
                    outcome,
                    after,
                }),
                None => self.not_an_answer(answer.span()),
            }
        }
        answers
    }

    fn answer(
        &self,
        operation: &str,
        answer: &DeValue<'_>,
    ) -> Option<(Result<Value, CallFault>, u64)> {
        let DeValue::Table(answer) = answer else {
            return None;
        };
        let shape = self
            .program
            .operation(asmotion_stdlib::operation(operation))
            .gives;
        let (mut outcome, mut after) = (None, 1);
        for (key, value) in answer {
            match (&**key.get_ref(), value.get_ref()) {
                ("reply", value) => outcome = Some(Ok(self.value(value, &shape)?)),
                ("fault", DeValue::String(fault)) => outcome = Some(Err(fault_named(fault)?)),
                ("after", DeValue::Integer(steps)) => {
                    after = steps.to_string().parse().ok().filter(|&steps| steps > 0)?;
                }
                _ => return None,
            }
        }
        Some((outcome?, after))
    }

    fn not_an_answer(&mut self, at: std::ops::Range<usize>) {
        let at = self.span(at);
        self.report.push(NotAnAnswer { at }.diagnostic());
    }

    fn not_a_section(&mut self, at: std::ops::Range<usize>) {
        let at = self.span(at);
        self.report.push(UnknownSection { at }.diagnostic());
    }

    fn inputs(&mut self, table: &DeTable<'_>) -> InputValues {
        let mut inputs = InputValues::new();
        for (key, value) in table {
            if let Some((location, value)) = self.input(key, value) {
                inputs.insert(location, value);
            }
        }
        inputs
    }

    fn input(
        &mut self,
        key: &Spanned<std::borrow::Cow<'_, str>>,
        value: &Spanned<DeValue<'_>>,
    ) -> Option<((FunctionId, Vec<Value>), Value)> {
        let at = self.span(key.span());
        let (name, arguments) = Literals::location(key.get_ref());
        let overloads: Vec<FunctionId> = self.literals().inputs(name, arguments.len()).collect();
        let Some(&first) = overloads.first() else {
            self.unknown(name, at);
            return None;
        };
        let mut fitting = overloads.iter().filter_map(|&function| {
            Some((function, self.literals().arguments(function, &arguments)?))
        });
        let Some((function, values)) = fitting.next() else {
            let shapes = arguments
                .iter()
                .zip(&self.program.functions[first.0 as usize].parameters);
            for (argument, shape) in shapes {
                if self.literals().value(argument, shape).is_none() {
                    self.misfit(&format!("`{argument}`"), argument, shape, at);
                }
            }
            return None;
        };
        let declared = &self.program.functions[function.0 as usize];
        match self.value(value.get_ref(), &declared.codomain) {
            Some(value) => Some(((function, values), value)),
            None => {
                let at = self.span(value.span());
                let (what, text) = if let DeValue::String(text) = value.get_ref() {
                    (format!("`{text}`"), text.as_ref())
                } else {
                    (format!("this value of `{name}`"), "")
                };
                self.misfit(&what, text, &declared.codomain, at);
                None
            }
        }
    }

    fn unknown(&mut self, name: &str, at: Span) {
        let functions = self.program.functions.iter().enumerate();
        let names = functions
            .filter(|(_, function)| is_input(function.kind) && function.own)
            .map(|(index, _)| &self.program.symbols.functions[index]);
        let similar = similar(name, names).cloned();
        let name = name.to_owned();
        self.report
            .push(UnknownInput { name, at, similar }.diagnostic());
    }

    fn misfit(&mut self, what: &str, text: &str, shape: &ValueShape, at: Span) {
        let names = self.literals().names(shape).unwrap_or_default();
        let finding = WrongInputValue {
            what: what.to_owned(),
            expected: self.describe(shape),
            at,
            similar: similar(text, names).cloned(),
            elements: names.to_vec(),
        };
        self.report.push(finding.diagnostic());
    }

    fn describe(&self, shape: &ValueShape) -> String {
        match shape {
            ValueShape::Bool => "a Boolean".to_owned(),
            ValueShape::Int => "an Integer".to_owned(),
            ValueShape::Natural => "a Natural".to_owned(),
            ValueShape::Real => "a Real".to_owned(),
            ValueShape::Char => "a character".to_owned(),
            ValueShape::Text => "a String".to_owned(),
            ValueShape::Domain(domain) => format!(
                "an element of {}",
                self.program.symbols.domains[domain.0 as usize]
            ),
            ValueShape::Tuple(items) => format!("a tuple of {}", items.len()),
            ValueShape::Seq(_) => "a sequence".to_owned(),
            ValueShape::Set(_) => "a set".to_owned(),
            ValueShape::Bag(_) => "a bag".to_owned(),
            ValueShape::Map(..) | ValueShape::Complex | ValueShape::Rule | ValueShape::Any => {
                "a value that a script can write".to_owned()
            }
        }
    }

    /// Converts a TOML value to a value of the shape.
    fn value(&self, value: &DeValue<'_>, shape: &ValueShape) -> Option<Value> {
        match (value, shape) {
            (DeValue::String(text), ValueShape::Text | ValueShape::Any) => {
                Some(Value::text(text.as_ref()))
            }
            (DeValue::String(text), ValueShape::Char) => {
                let mut letters = text.chars();
                letters
                    .next()
                    .filter(|_| letters.next().is_none())
                    .map(Value::Char)
            }
            (DeValue::String(text), shape) => self.literals().value(text, shape),
            (DeValue::Boolean(truth), ValueShape::Bool | ValueShape::Any) => {
                Some(Value::Bool(*truth))
            }
            (DeValue::Integer(number), ValueShape::Any) => {
                number.to_string().parse().ok().map(Value::Int)
            }
            (DeValue::Integer(number), shape) => self.literals().value(&number.to_string(), shape),
            (DeValue::Array(items), ValueShape::Any) => self.items(items, shape).map(Value::seq),
            (DeValue::Float(number), ValueShape::Real | ValueShape::Any) => {
                number.as_str().parse().ok().map(Value::real)
            }
            (DeValue::Array(items), ValueShape::Tuple(shapes)) if items.len() == shapes.len() => {
                let items = items
                    .iter()
                    .zip(shapes)
                    .map(|(item, shape)| self.value(item.get_ref(), shape));
                items.collect::<Option<Vec<_>>>().map(Value::tuple)
            }
            (DeValue::Array(items), ValueShape::Seq(shape)) => {
                self.items(items, shape).map(Value::seq)
            }
            (DeValue::Array(items), ValueShape::Set(shape)) => {
                self.items(items, shape).map(Value::set)
            }
            (DeValue::Array(items), ValueShape::Bag(shape)) => {
                self.items(items, shape).map(Value::bag)
            }
            _ => None,
        }
    }

    fn items<'b>(
        &self,
        items: impl IntoIterator<Item = &'b Spanned<DeValue<'b>>>,
        shape: &ValueShape,
    ) -> Option<Vec<Value>> {
        items
            .into_iter()
            .map(|item| self.value(item.get_ref(), shape))
            .collect()
    }
}

fn is_input(kind: FunctionKind) -> bool {
    matches!(kind, FunctionKind::Monitored | FunctionKind::Shared)
}
