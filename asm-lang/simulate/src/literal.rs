//! Parses values in the notation of scripts and traces.

use asmotion_ir::{DomainElements, DomainId, FunctionId, FunctionKind, Program, ValueShape};
use asmotion_value::{Atom, RuleId, Value};
use std::sync::Arc;

/// Limit for the nesting of values.
const MAX_DEPTH: usize = 64;

/// Parses values of a program.
#[derive(Clone, Copy)]
pub(crate) struct Literals<'a> {
    program: &'a Program,
    /// The elements that the machine has created from the reserve.
    reserve: &'a [(DomainId, u32)],
}

impl<'a> Literals<'a> {
    /// Creates a parser for the elements that a program declares and those created from the
    /// reserve.
    pub fn new(program: &'a Program, reserve: &'a [(DomainId, u32)]) -> Self {
        Self { program, reserve }
    }

    /// Parses a value of this shape; returns `None` if the text denotes none.
    pub fn value(self, text: &str, shape: &ValueShape) -> Option<Value> {
        let mut reader = LiteralReader {
            literals: self,
            rest: text,
            depth: 0,
        };
        let value = reader.value(shape)?;
        reader.rest.trim_start().is_empty().then_some(value)
    }

    /// Splits a location such as `battery(ROB1)` into its name and the texts of its arguments.
    pub fn location(text: &str) -> (&str, Vec<&str>) {
        let text = text.trim();
        match text.split_once('(') {
            Some((name, rest)) => (name.trim(), split(rest.strip_suffix(')').unwrap_or(rest))),
            None => (text, Vec::new()),
        }
    }

    /// Iterates over the inputs with this name and number of parameters.
    pub fn inputs(self, name: &str, arity: usize) -> impl Iterator<Item = FunctionId> {
        let functions = self.program.functions.iter().enumerate();
        let found = functions.filter(move |(index, function)| {
            matches!(
                function.kind,
                FunctionKind::Monitored | FunctionKind::Shared
            ) && function.parameters.len() == arity
                && &*self.program.symbols.functions[*index] == name
        });
        found.map(|(index, _)| FunctionId(index as u32))
    }

    /// Parses the arguments of a function.
    pub fn arguments(self, function: FunctionId, texts: &[&str]) -> Option<Vec<Value>> {
        let shapes = &self.program.functions[function.0 as usize].parameters;
        texts
            .iter()
            .zip(shapes)
            .map(|(text, shape)| self.value(text, shape))
            .collect()
    }

    /// Parses an input location and its value.
    pub fn input(self, location: &str, value: &str) -> Option<((FunctionId, Vec<Value>), Value)> {
        let (name, arguments) = Self::location(location);
        self.inputs(name, arguments.len()).find_map(|function| {
            let arguments = self.arguments(function, &arguments)?;
            let value = self.value(value, &self.program.functions[function.0 as usize].codomain)?;
            Some(((function, arguments), value))
        })
    }

    /// Returns the names of the elements of a domain, if they are known before the run.
    pub fn names(self, shape: &ValueShape) -> Option<&'a [Arc<str>]> {
        let ValueShape::Domain(domain) = shape else {
            return None;
        };
        match self.program.domains.get(domain.0 as usize)?.elements {
            DomainElements::Atoms { first, count } => {
                let first = first.0 as usize;
                let atoms = &self.program.symbols.atoms;
                atoms.get(first..first + count as usize)
            }
            DomainElements::Ints { .. }
            | DomainElements::Computed(_)
            | DomainElements::Undefined
            | DomainElements::Open => None,
        }
    }

    fn element(self, word: &str, domain: DomainId) -> Option<Value> {
        let number = || word.trim_end_matches('n').parse::<i64>().ok();
        match self.program.domains.get(domain.0 as usize)?.elements {
            DomainElements::Ints { low, high } => number()
                .filter(|number| (low..=high).contains(number))
                .map(Value::Int),
            DomainElements::Atoms { first, count } => {
                let mut declared = first.0..first.0 + count;
                let found =
                    declared.find(|&atom| &*self.program.symbols.atoms[atom as usize] == word);
                found
                    .or_else(|| self.reserve_index(word))
                    .map(|atom| Value::Atom(Atom(atom)))
            }
            DomainElements::Computed(_) | DomainElements::Undefined | DomainElements::Open => {
                self.word(word)
            }
        }
    }

    /// Resolves `domain!number`, the name of an element created by `extend`; returns its index in
    /// the reserve.
    fn reserve_index(self, word: &str) -> Option<u32> {
        let (name, number) = word.split_once('!')?;
        let number: u32 = number.parse().ok()?;
        let at = self.reserve.iter().position(|(domain, count)| {
            let known = &self.program.symbols.domains[domain.0 as usize];
            *count == number && known.eq_ignore_ascii_case(name)
        })?;
        Some((self.program.symbols.atoms.len() + at) as u32)
    }

    /// Parses a word of unknown shape.
    fn word(self, word: &str) -> Option<Value> {
        match word {
            "undef" => return Some(Value::Undef),
            "true" => return Some(Value::Bool(true)),
            "false" => return Some(Value::Bool(false)),
            _ => {}
        }
        if let Ok(number) = word.parse() {
            return Some(Value::Int(number));
        }
        if word.starts_with(|first: char| first.is_ascii_digit() || first == '-') {
            return word.parse().ok().map(Value::real);
        }
        let declared = self
            .program
            .symbols
            .atoms
            .iter()
            .position(|name| &**name == word);
        let atom = declared
            .map(|atom| atom as u32)
            .or_else(|| self.reserve_index(word));
        atom.map(|atom| Value::Atom(Atom(atom)))
    }
}

/// Splits at the commas outside brackets and quotes.
fn split(text: &str) -> Vec<&str> {
    let mut parts = Vec::new();
    let (mut depth, mut quoted, mut escaped, mut start) = (0i32, false, false, 0);
    for (at, letter) in text.char_indices() {
        match letter {
            _ if escaped => escaped = false,
            '\\' if quoted => escaped = true,
            '"' => quoted = !quoted,
            _ if quoted => {}
            '(' | '[' | '{' => depth += 1,
            ')' | ']' | '}' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(text.get(start..at).unwrap_or_default().trim());
                start = at + 1;
            }
            _ => {}
        }
    }
    let last = text.get(start..).unwrap_or_default().trim();
    if !last.is_empty() || !parts.is_empty() {
        parts.push(last);
    }
    parts
}

/// The remaining text of a value.
struct LiteralReader<'a> {
    literals: Literals<'a>,
    rest: &'a str,
    depth: usize,
}

impl<'a> LiteralReader<'a> {
    fn accept(&mut self, token: &str) -> bool {
        let rest = self.rest.trim_start();
        match rest.strip_prefix(token) {
            Some(rest) => {
                self.rest = rest;
                true
            }
            None => false,
        }
    }

    fn value(&mut self, shape: &ValueShape) -> Option<Value> {
        if self.depth >= MAX_DEPTH {
            return None;
        }
        self.depth += 1;
        let value = self.value_here(shape);
        self.depth -= 1;
        value
    }

    fn value_here(&mut self, shape: &ValueShape) -> Option<Value> {
        if self.accept("(") {
            return self.tuple(shape);
        }
        if self.accept("[") {
            let item = if let ValueShape::Seq(item) = shape {
                item
            } else {
                &ValueShape::Any
            };
            return self.items(item, "]").map(Value::seq);
        }
        if self.accept("{") {
            return self.set_or_map(shape);
        }
        if self.accept("\"") {
            return self.text().map(Value::text);
        }
        if self.accept("'") {
            return self.character();
        }
        if self.accept("<<") {
            let rule = self.rule()?;
            return self.accept(">>").then_some(rule);
        }
        if self.accept("<") {
            let item = if let ValueShape::Bag(item) = shape {
                item
            } else {
                &ValueShape::Any
            };
            return self.items(item, ">").map(Value::bag);
        }
        let word = self.word();
        if word == "rule" {
            return self.rule();
        }
        self.scalar(word, shape)
    }

    fn scalar(&self, word: &str, shape: &ValueShape) -> Option<Value> {
        if word == "undef" {
            return Some(Value::Undef);
        }
        match shape {
            ValueShape::Bool => word.parse().ok().map(Value::Bool),
            ValueShape::Int => word.parse().ok().map(Value::Int),
            ValueShape::Natural => {
                let number = word.trim_end_matches('n').parse().ok();
                number.filter(|number| *number >= 0).map(Value::Int)
            }
            ValueShape::Real => word.parse().ok().map(Value::real),
            ValueShape::Domain(domain) => self.literals.element(word, *domain),
            ValueShape::Any => self.literals.word(word),
            ValueShape::Char
            | ValueShape::Text
            | ValueShape::Complex
            | ValueShape::Rule
            | ValueShape::Tuple(_)
            | ValueShape::Seq(_)
            | ValueShape::Set(_)
            | ValueShape::Bag(_)
            | ValueShape::Map(..) => None,
        }
    }

    /// Reads the characters up to the next bracket, comma, blank or arrow.
    fn word(&mut self) -> &'a str {
        let rest = self.rest.trim_start();
        let stops = |letter: char| letter.is_whitespace() || ",()[]{}<>\"'".contains(letter);
        let end = rest.find(stops).unwrap_or(rest.len());
        let arrow = rest.find("->").unwrap_or(rest.len());
        let (word, rest) = rest.split_at(end.min(arrow));
        self.rest = rest;
        word
    }

    fn tuple(&mut self, shape: &ValueShape) -> Option<Value> {
        let mut items = Vec::new();
        loop {
            let item = if let ValueShape::Tuple(shapes) = shape {
                shapes.get(items.len())?
            } else {
                &ValueShape::Any
            };
            items.push(self.value(item)?);
            if self.accept(")") {
                return Some(Value::tuple(items));
            }
            if !self.accept(",") {
                return None;
            }
        }
    }

    fn items(&mut self, item: &ValueShape, close: &str) -> Option<Vec<Value>> {
        let mut items = Vec::new();
        if self.accept(close) {
            return Some(items);
        }
        loop {
            items.push(self.value(item)?);
            if self.accept(close) {
                return Some(items);
            }
            if !self.accept(",") {
                return None;
            }
        }
    }

    fn set_or_map(&mut self, shape: &ValueShape) -> Option<Value> {
        if self.accept("->") {
            return self.accept("}").then(|| Value::map([]));
        }
        if self.accept("}") {
            let is_map = matches!(shape, ValueShape::Map(..));
            return Some(if is_map {
                Value::map([])
            } else {
                Value::set([])
            });
        }
        let (key, value) = if let ValueShape::Map(key, value) = shape {
            (&**key, &**value)
        } else if let ValueShape::Set(item) = shape {
            (&**item, &ValueShape::Any)
        } else {
            (&ValueShape::Any, &ValueShape::Any)
        };
        let (mut keys, mut values) = (Vec::new(), Vec::new());
        loop {
            keys.push(self.value(key)?);
            if self.accept("->") {
                values.push(self.value(value)?);
            }
            if self.accept("}") {
                break;
            }
            if !self.accept(",") {
                return None;
            }
        }
        match values.len() {
            0 => Some(Value::set(keys)),
            count if count == keys.len() => Some(Value::map(keys.into_iter().zip(values))),
            _ => None,
        }
    }

    /// Reads a string in JSON notation, after the opening quote.
    fn text(&mut self) -> Option<String> {
        let mut text = String::new();
        let mut letters = self.rest.chars();
        loop {
            match letters.next()? {
                '"' => break,
                '\\' => text.push(escaped(&mut letters)?),
                letter => text.push(letter),
            }
        }
        self.rest = letters.as_str();
        Some(text)
    }

    fn character(&mut self) -> Option<Value> {
        let mut letters = self.rest.chars();
        let letter = match letters.next()? {
            '\\' => escaped(&mut letters)?,
            letter => letter,
        };
        self.rest = letters.as_str();
        self.accept("'").then_some(Value::Char(letter))
    }

    /// Reads a rule by its name; the domains of the parameters that may follow select among
    /// several.
    fn rule(&mut self) -> Option<Value> {
        let name = self.word();
        let domains = self.bracketed();
        let symbols = &self.literals.program.symbols;
        let is_it = |index: &usize| {
            let known = symbols.rule_domains.get(*index);
            domains.is_none() || known.is_some_and(|known| Some(&**known) == domains)
        };
        let mut named = (0..symbols.rules.len()).filter(|&index| *symbols.rules[index] == *name);
        let at = named.find(is_it)?;
        Some(Value::Rule(RuleId(at as u32)))
    }

    /// Reads the text in brackets that may follow.
    fn bracketed(&mut self) -> Option<&'a str> {
        let inner = self.rest.strip_prefix('(')?;
        let mut open = 1;
        let end = inner.find(|letter| {
            open += i32::from(letter == '(') - i32::from(letter == ')');
            open == 0
        })?;
        self.rest = &inner[end + 1..];
        Some(&inner[..end])
    }
}

/// Reads the character after a backslash.
fn escaped(letters: &mut std::str::Chars<'_>) -> Option<char> {
    Some(match letters.next()? {
        'n' => '\n',
        'r' => '\r',
        't' => '\t',
        'b' => '\u{8}',
        'f' => '\u{c}',
        'u' => {
            let mut code = 0;
            for _ in 0..4 {
                code = code * 16 + letters.next()?.to_digit(16)?;
            }
            char::from_u32(code)?
        }
        letter => letter,
    })
}
