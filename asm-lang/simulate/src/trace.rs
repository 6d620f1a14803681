//! The normalised trace: what a run read, chose and wrote, one fact a line.
//!
//! ```text
//! # trace-format 1
//! D0 Robot = {rob1,rob2}        the elements of the domains that may grow, before the first step;
//!                               each in the domain it was declared in or taken for
//! @step 1
//! T 40000000                    the time of the step in nanoseconds, unless it is 0
//! M estop = false               what was read of the environment, in reading order
//! C 1 of 3                      which candidate was chosen, counted from 0
//! U mode = MOVING               the update set, sorted
//! UD Order = {order!1}          the elements that joined a domain
//! S mode = MOVING               every location that rules may write, after the step
//! D Order = {order!1}           the elements of the domains that may grow, after the step
//! D Robot = {rob1,rob2}
//! @invariant post inv_safe      or `@error CLASH …`: why there is no further step
//! @end INV                      `OK`, or the kind of the fault
//! I mode = IDLE                 what the locations that rules may write held in the initial state
//! ```
//!
//! Values are written as in the language, without blanks; the elements of sets, bags and maps are
//! sorted by their text. Every tool that runs the language can write such a trace, so that runs can
//! be compared; and a [`Recording`](crate::Recording) replays one.

use ir::{DomainId, FunctionId, FunctionKind, Program, Slot};
use machine::{Fault, FaultKind, Machine, Step};
use std::collections::BTreeMap;
use std::fmt::Write;
use value::Value;

/// A trace that is being written.
#[derive(Debug, Default)]
pub struct Trace {
    text: String,
}

impl Trace {
    /// The head of a trace: the format, lines of comment, the machine's domains.
    pub fn begin(machine: &Machine, comment: &str) -> Self {
        let mut trace = Self::default();
        trace.head(comment);
        trace.domains("D0", machine);
        trace
    }

    /// The trace of a run that could not begin, for a fault in the initial state.
    pub fn stillborn(program: &Program, fault: &Fault, comment: &str) -> String {
        let mut trace = Self::default();
        trace.head(comment);
        trace.line(format_args!("@step 1"));
        match &fault.kind {
            FaultKind::Invariant { index, .. } => trace.invariant(program, *index, "pre"),
            _ => trace.line(format_args!("@error {}", kind(fault))),
        }
        trace.line(format_args!("@end {}", kind(fault)));
        trace.text
    }

    /// The step that the machine did last.
    pub fn step(&mut self, machine: &Machine) {
        let step = machine.last_step();
        self.causes(machine, &step, step.number);
        self.effects(machine, &step);
    }

    /// The step that failed last.
    pub fn fault(&mut self, machine: &Machine, fault: &Fault) {
        let step = machine.last_step();
        self.causes(machine, &step, fault.step);
        if let FaultKind::Invariant { index, .. } = &fault.kind {
            let invariant = &machine.program().invariants[*index];
            if !invariant.assumes {
                self.effects(machine, &step);
            }
            let when = if invariant.assumes { "pre" } else { "post" };
            self.invariant(machine.program(), *index, when);
        } else {
            self.line(format_args!("@error {}", kind(fault)));
        }
    }

    /// The whole text, of a run that was stopped by a fault or was not.
    pub fn end(mut self, machine: &Machine, fault: Option<&Fault>) -> String {
        self.line(format_args!("@end {}", fault.map_or("OK", kind)));
        let state = machine.state();
        let fixed = written(machine).filter(|&slot| slot < machine.program().slots);
        self.locations(
            "I",
            machine,
            fixed.map(|slot| (slot, state.get_initial(slot))),
        );
        self.text
    }

    fn head(&mut self, comment: &str) {
        self.line(format_args!("# trace-format 1"));
        for line in comment.lines() {
            self.line(format_args!("# {line}"));
        }
    }

    fn invariant(&mut self, program: &Program, index: usize, when: &str) {
        // an invariant without a name is called by its text
        let name: Vec<&str> = program.invariants[index].name.split_whitespace().collect();
        self.line(format_args!("@invariant {when} {}", name.join(" ")));
    }

    fn line(&mut self, line: std::fmt::Arguments<'_>) {
        // writing to a string cannot fail
        let _ = self.text.write_fmt(line);
        self.text.push('\n');
    }

    fn causes(&mut self, machine: &Machine, step: &Step<'_>, number: u64) {
        self.line(format_args!("@step {number}"));
        if step.now_ns != 0 {
            self.line(format_args!("T {}", step.now_ns));
        }
        for input in step.inputs {
            self.line(format_args!(
                "M {} = {}",
                location(machine, input.slot),
                text(machine, &input.value)
            ));
        }
        for choice in step.choices {
            self.line(format_args!("C {} of {}", choice.index, choice.count));
        }
    }

    fn effects(&mut self, machine: &Machine, step: &Step<'_>) {
        let updates = step
            .updates
            .iter()
            .map(|update| (update.slot, &update.value));
        self.locations("U", machine, updates);
        let mut joined: BTreeMap<DomainId, Vec<Value>> = BTreeMap::new();
        for (domain, atom) in step.extended {
            joined.entry(*domain).or_default().push(Value::Atom(*atom));
        }
        for (domain, atoms) in joined {
            self.domain("UD", machine, domain, &atoms);
        }
        let state = machine.state();
        let slots = written(machine).map(|slot| (slot, state.get(slot)));
        self.locations("S", machine, slots);
        self.domains("D", machine);
    }

    fn locations<'a>(
        &mut self,
        word: &str,
        machine: &Machine,
        locations: impl Iterator<Item = (Slot, &'a Value)>,
    ) {
        let lines = locations
            .map(|(slot, value)| format!("{} = {}", location(machine, slot), text(machine, value)));
        let mut lines: Vec<String> = lines.collect();
        lines.sort();
        for line in lines {
            self.line(format_args!("{word} {line}"));
        }
    }

    /// The domains that may grow; an element of several stands in the one it was declared in or taken
    /// for.
    fn domains(&mut self, word: &str, machine: &Machine) {
        let (state, program) = (machine.state(), machine.program());
        for (index, domain) in program.domains.iter().enumerate() {
            if !domain.grows {
                continue;
            }
            let id = DomainId(index as u32);
            let is_at_home = |element: &&Value| match element {
                Value::Atom(atom) => state.domain_of(program, *atom) == Some(id),
                _ => true,
            };
            let extent = state.extent(id).iter();
            let elements: Vec<Value> = extent.filter(is_at_home).cloned().collect();
            if !elements.is_empty() {
                self.domain(word, machine, id, &elements);
            }
        }
    }

    fn domain(&mut self, word: &str, machine: &Machine, domain: DomainId, elements: &[Value]) {
        let name = &machine.program().symbols.domains[domain.0 as usize];
        self.line(format_args!(
            "{word} {name} = {}",
            list(machine, elements, "{", "}", true)
        ));
    }
}

/// The locations that rules may write.
fn written(machine: &Machine) -> impl Iterator<Item = Slot> {
    let (state, program) = (machine.state(), machine.program());
    (0..state.len() as Slot).filter(move |&slot| {
        let function = state.function(program, slot);
        let kind = function.map(|id| program.functions[id.0 as usize].kind);
        matches!(kind, Some(FunctionKind::Controlled | FunctionKind::Out)) && slot != program.result
    })
}

fn kind(fault: &Fault) -> &'static str {
    match &fault.kind {
        FaultKind::Clash { .. } => "CLASH",
        FaultKind::Outside { .. } => "DOMAIN",
        FaultKind::Input { .. } => "MONREAD",
        FaultKind::Invariant { .. } => "INV",
        FaultKind::UndefinedGuard => "EXC:UndefinedGuard",
        FaultKind::Library(_) => "EXC:Library",
        FaultKind::Infinite => "EXC:Infinite",
        FaultKind::NotACollection(_) => "EXC:NotACollection",
        FaultKind::NotARule(_) => "EXC:NotARule",
        FaultKind::RuleArity { .. } => "EXC:RuleArity",
        FaultKind::NoProgram(_) => "EXC:NoProgram",
        FaultKind::TooDeep(_) => "EXC:TooDeep",
        FaultKind::Endless(_) => "EXC:Endless",
        FaultKind::TooLarge(_) => "EXC:TooLarge",
        FaultKind::Unbound => "EXC:Unbound",
        FaultKind::Unbounded => "EXC:Unbounded",
        FaultKind::NoCandidate(_) => "EXC:NoCandidate",
        FaultKind::NoMain => "EXC:NoMain",
    }
}

fn location(machine: &Machine, slot: Slot) -> String {
    match machine.state().location(machine.program(), slot) {
        Some((function, arguments)) => applied(machine, function, &arguments),
        None => format!("location {slot}"),
    }
}

fn applied(machine: &Machine, function: FunctionId, arguments: &[Value]) -> String {
    let name = &machine.program().symbols.functions[function.0 as usize];
    match arguments {
        [] => name.to_string(),
        arguments => format!("{name}{}", list(machine, arguments, "(", ")", false)),
    }
}

fn list(machine: &Machine, items: &[Value], open: &str, close: &str, sorted: bool) -> String {
    let mut items: Vec<String> = items.iter().map(|item| text(machine, item)).collect();
    if sorted {
        items.sort();
    }
    format!("{open}{}{close}", items.join(","))
}

/// A value as a trace writes it.
fn text(machine: &Machine, value: &Value) -> String {
    match value {
        Value::Tuple(items) => list(machine, items, "(", ")", false),
        Value::Seq(items) => list(machine, items, "[", "]", false),
        Value::Set(items) => {
            let items: Vec<Value> = items.iter().cloned().collect();
            list(machine, &items, "{", "}", true)
        }
        Value::Bag(items) => {
            let each = items
                .iter()
                .flat_map(|(item, &count)| std::iter::repeat_n(item.clone(), count));
            list(machine, &each.collect::<Vec<_>>(), "<", ">", true)
        }
        Value::Map(pairs) => {
            let pairs = pairs
                .iter()
                .map(|(key, value)| format!("{}->{}", text(machine, key), text(machine, value)));
            let mut pairs: Vec<String> = pairs.collect();
            pairs.sort();
            format!(
                "{{{}}}",
                if pairs.is_empty() {
                    "->".to_owned()
                } else {
                    pairs.join(",")
                }
            )
        }
        Value::Rule(rule) => {
            let symbols = &machine.program().symbols;
            let index = rule.0 as usize;
            match (symbols.rules.get(index), symbols.rule_domains.get(index)) {
                (Some(name), Some(domains)) => format!("rule {name}({domains})"),
                _ => format!("rule {index}"),
            }
        }
        Value::Real(number) => real(number.get()),
        Value::Undef
        | Value::Bool(_)
        | Value::Int(_)
        | Value::Char(_)
        | Value::Atom(_)
        | Value::Text(_)
        | Value::Complex(_) => value.show(&machine.naming()).to_string(),
    }
}

/// A number with a point, also in front of an exponent, as other tools write it.
fn real(number: f64) -> String {
    if number.is_infinite() {
        return if number > 0.0 {
            "Infinity"
        } else {
            "-Infinity"
        }
        .to_owned();
    }
    let shown = format!("{number:?}");
    let exponent = if shown.contains('.') { "E" } else { ".0E" };
    shown.replace('e', exponent)
}
