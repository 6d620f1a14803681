//! Executes the commands of a session.

use super::save;
use super::verb::{VERBS, split};
use crate::prompt;
use crate::show;
use crate::terminal::{FAINT, GOOD, NAME, NOTE, TerminalOutput};
use asmotion_lang::ir::{AddedTerm, FunctionId, FunctionKind};
use asmotion_lang::{History, HistoryEvent, LastWrite, Machine, Report, Value, simulate};
use std::path::Path;

/// Default number of steps of `run`.
const RUN: u64 = 1000;

/// The state of a session.
pub struct ReplSession {
    /// Path of the specification.
    path: String,
    seed: u64,
    history: History,
    watches: Vec<(String, AddedTerm)>,
    breaks: Vec<Breakpoint>,
}

/// Conditions at which `run` stops.
enum Breakpoint {
    /// A location is written; without arguments, any location of the function.
    Location(String, FunctionId, Vec<Value>),
    /// A rule runs; the number is how often it has run so far.
    Rule(String, u64),
    /// A term becomes true.
    When(String, AddedTerm, bool),
}

impl ReplSession {
    pub fn new(path: String, seed: u64, history: History) -> Self {
        Self {
            path,
            seed,
            history,
            watches: Vec::new(),
            breaks: Vec::new(),
        }
    }

    /// The prompt: name of the specification and number of steps.
    pub fn prompt(&self) -> String {
        let name = Path::new(&self.path).file_stem().unwrap_or_default();
        format!("{} {}> ", name.to_string_lossy(), self.machine().steps())
    }

    pub fn print_banner(&self, terminal: &mut TerminalOutput) {
        let report = &self.history.session().specification.report;
        terminal.report(report, &self.history.session().specification.sources);
        terminal.progress(format_args!(
            "{FAINT}`step` executes a step, `set x := 1` sets an input, a term prints its value, `help` lists all commands{FAINT:#}"
        ));
        let recorded = self.history.recorded();
        if recorded > 0 {
            let plural = if recorded == 1 { "" } else { "s" };
            terminal.progress(format_args!(
                "{FAINT}{recorded} step{plural} recorded: `step` repeats the next one, `undo` goes back, `run` goes to the end{FAINT:#}"
            ));
        }
    }

    /// Executes one line. Returns `false` at the end of the session.
    pub fn execute(&mut self, line: &str, terminal: &mut TerminalOutput) -> bool {
        let line = line.trim();
        if line.is_empty() || line.starts_with("//") {
            return true;
        }
        let (verb, rest) = split(line).unwrap_or(("eval", line));
        let answered = match verb {
            "step" => self.steps(rest, 1, false, terminal),
            "run" => self.steps(rest, RUN, true, terminal),
            "set" => self.set(rest, terminal),
            "unset" => self.history.release(rest),
            "eval" => self.eval(rest, terminal),
            "fire" => self.fire(rest, terminal),
            "watch" => self.watch(rest, terminal),
            "unwatch" => remove(&mut self.watches, rest, terminal),
            "break" => self.add_break(rest, terminal),
            "unbreak" => remove(&mut self.breaks, rest, terminal),
            "who" => self.print_last_writer(rest, terminal),
            "state" => self.state(rest, terminal),
            "inputs" => self.inputs(terminal),
            "undo" => self.undo(rest, terminal),
            "history" => self.print_history(terminal),
            "save" => self.save(rest, terminal),
            "help" => {
                prompt::help(VERBS, terminal);
                Ok(())
            }
            _ => return false,
        };
        if let Err(report) = answered {
            terminal.report(&report, &self.history.session().specification.sources);
        }
        true
    }

    fn machine(&self) -> &Machine {
        &self.history.session().machine
    }

    fn value_text(&self, value: &Value) -> String {
        value.show(&self.machine().naming()).to_string()
    }

    /// Makes steps: `step` prints each of them, `run` stops at breakpoints and prints a summary.
    fn steps(
        &mut self,
        count: &str,
        default: u64,
        is_run: bool,
        terminal: &mut TerminalOutput,
    ) -> Result<(), Report> {
        let Some(count) = number(count, default, terminal) else {
            return Ok(());
        };
        let from = self.machine().steps();
        let was_recorded = self.history.is_recorded();
        for _ in 0..count {
            // a run ends with its recording; further steps have other inputs
            if was_recorded && !self.history.is_recorded() && self.machine().steps() > from {
                terminal.result(format_args!("{NOTE}the recorded run ends here{NOTE:#}"));
                break;
            }
            self.count_rules();
            let result = self.history.step();
            if result.is_err() {
                self.print_unset(terminal);
            }
            result?;
            let hit = if is_run { self.breakpoint_hit()? } else { None };
            if !is_run || hit.is_some() {
                self.print_step(terminal);
                self.print_watches(terminal);
            }
            if let Some(what) = hit {
                terminal.result(format_args!("{NOTE}break{NOTE:#}: {what}"));
                return Ok(());
            }
        }
        if is_run {
            let count = self.machine().steps() - from;
            terminal.result(format_args!(
                "{FAINT}{count} steps without a break{FAINT:#}"
            ));
            self.print_watches(terminal);
        }
        Ok(())
    }

    fn set(&mut self, assignment: &str, terminal: &mut TerminalOutput) -> Result<(), Report> {
        self.history.set(assignment)?;
        if let Some(HistoryEvent::Set(function, arguments, value)) = self.history.events().last() {
            let location = simulate::applied(self.machine(), *function, arguments);
            terminal.result(format_args!("{location} = {}", self.value_text(value)));
        }
        Ok(())
    }

    fn eval(&mut self, term: &str, terminal: &mut TerminalOutput) -> Result<(), Report> {
        let value = self.history.evaluate(term)?;
        terminal.result(self.value_text(&value));
        Ok(())
    }

    fn fire(&mut self, rule: &str, terminal: &mut TerminalOutput) -> Result<(), Report> {
        self.history.fire(rule)?;
        self.print_updates(terminal);
        self.print_watches(terminal);
        Ok(())
    }

    fn watch(&mut self, term: &str, terminal: &mut TerminalOutput) -> Result<(), Report> {
        if !term.is_empty() {
            let added = self.history.watch(term)?;
            self.watches.push((term.to_owned(), added));
        }
        self.print_watches(terminal);
        Ok(())
    }

    fn add_break(&mut self, at: &str, terminal: &mut TerminalOutput) -> Result<(), Report> {
        if let Some(term) = at.strip_prefix("if ") {
            let added = self.history.watch(term)?;
            let is_true = self.history.value(added)? == Value::Bool(true);
            let text = term.trim().to_owned();
            self.breaks.push(Breakpoint::When(text, added, is_true));
        } else if at.starts_with("r_") {
            let model = &self.history.session().specification.model;
            if !model.rules.iter().any(|rule| &*rule.name == at) {
                terminal.error(format_args!("unknown rule `{at}`"));
                return Ok(());
            }
            self.history.count()?;
            self.breaks.push(Breakpoint::Rule(at.to_owned(), 0));
        } else if let Some(function) = self.function(at) {
            self.breaks
                .push(Breakpoint::Location(at.to_owned(), function, Vec::new()));
        } else if !at.is_empty() {
            let (function, arguments) = self.history.location(at)?;
            self.breaks
                .push(Breakpoint::Location(at.to_owned(), function, arguments));
        }
        for (index, stop) in (1..).zip(&self.breaks) {
            let what = match stop {
                Breakpoint::Location(text, ..) => format!("when `{text}` is written"),
                Breakpoint::Rule(rule, _) => format!("when `{rule}` runs"),
                Breakpoint::When(term, ..) => format!("when `{term}` becomes true"),
            };
            terminal.result(format_args!("{index}: {what}"));
        }
        Ok(())
    }

    /// The function of the specification with this name.
    fn function(&self, name: &str) -> Option<FunctionId> {
        let mut own = self.history.session().specification.model.own_functions();
        own.find(|(_, function)| &*function.name == name)
            .map(|(id, _)| FunctionId(id.0))
    }

    /// Records how often the rules with breakpoints have run before the next step.
    fn count_rules(&mut self) {
        for stop in &mut self.breaks {
            if let Breakpoint::Rule(rule, before) = stop {
                *before = calls(&self.history, rule);
            }
        }
    }

    /// Returns the breakpoint reached by the last step.
    fn breakpoint_hit(&mut self) -> Result<Option<String>, Report> {
        let mut hit = None;
        for stop in &mut self.breaks {
            let is_hit = match stop {
                Breakpoint::Location(_, function, arguments) => {
                    writes(&self.history, *function, arguments)
                }
                Breakpoint::Rule(rule, before) => calls(&self.history, rule) > *before,
                Breakpoint::When(_, term, was_true) => {
                    let is_true = self.history.value(*term)? == Value::Bool(true);
                    is_true && !std::mem::replace(was_true, is_true)
                }
            };
            if is_hit && hit.is_none() {
                hit = Some(match stop {
                    Breakpoint::Location(text, ..) => format!("`{text}` was written"),
                    Breakpoint::Rule(rule, _) => format!("`{rule}` ran"),
                    Breakpoint::When(term, ..) => format!("`{term}` became true"),
                });
            }
        }
        Ok(hit)
    }

    fn print_last_writer(
        &mut self,
        location: &str,
        terminal: &mut TerminalOutput,
    ) -> Result<(), Report> {
        let (function, arguments) = self.history.location(location)?;
        let location = simulate::applied(self.machine(), function, &arguments);
        let guards = self.history.guards(function, &arguments);
        let Some(written) = self.history.written(function, &arguments) else {
            terminal.result(format_args!(
                "`{location}` has its initial value: nothing has written it"
            ));
            return Ok(());
        };
        let specification = &self.history.session().specification;
        let LastWrite {
            steps,
            origin,
            before,
            after,
            event,
        } = written;
        let time = match self.history.events().get(*event) {
            Some(HistoryEvent::Step) => format!("in step {steps}"),
            Some(HistoryEvent::Fire(rule)) => {
                format!("after step {steps}, when `{rule}` was fired")
            }
            Some(HistoryEvent::Set(..) | HistoryEvent::Release(..)) | None => {
                format!("after step {steps}, by `set`")
            }
        };
        let (before, after) = (self.value_text(before), self.value_text(after));
        terminal.result(format_args!(
            "{NAME}{location}{NAME:#} = {after}, written {time}  {FAINT}(was {before}){FAINT:#}"
        ));
        if let Some(origin) = origin {
            let place = specification.span(*origin);
            let sources = &specification.sources;
            let (line, column) = sources.position(place.file, place.start);
            let rule = specification
                .rule_at(place)
                .map_or(String::new(), |rule| format!(" in {}", rule.name));
            terminal.result(format_args!(
                "  `{}`{rule}, {}:{line}:{column}",
                sources.snippet(place),
                sources.path(place.file)
            ));
        }
        for guard in &guards {
            terminal.result(format_args!("  because {}", show::guard(guard)));
        }
        Ok(())
    }

    fn state(&self, name: &str, terminal: &mut TerminalOutput) -> Result<(), Report> {
        for (location, value) in simulate::state(self.machine()) {
            let function = location.split('(').next().unwrap_or_default();
            if name.is_empty() || name == function {
                terminal.result(format_args!("  {location} = {value}"));
            }
        }
        Ok(())
    }

    fn inputs(&self, terminal: &mut TerminalOutput) -> Result<(), Report> {
        let specification = &self.history.session().specification;
        let program = self.machine().program();
        for (id, function) in specification.model.own_functions() {
            if program.functions[id.0 as usize].kind == FunctionKind::Monitored {
                let domain = specification.model.show_type(function.codomain);
                terminal.result(format_args!(
                    "  {} {FAINT}: {domain}{FAINT:#}",
                    function.name
                ));
            }
        }
        for (function, arguments, value) in self.history.held() {
            let location = simulate::applied(self.machine(), function, arguments);
            terminal.result(format_args!(
                "  {GOOD}held{GOOD:#} {location} = {}",
                self.value_text(value)
            ));
        }
        Ok(())
    }

    /// Lists inputs without a value if undef could have caused the failure of a step.
    fn print_unset(&self, terminal: &mut TerminalOutput) {
        let inputs = self.machine().last_step().inputs();
        let unset = inputs.iter().filter(|input| input.value.is_undef());
        let unset: Vec<String> = unset
            .map(|input| format!("`{}`", simulate::location(self.machine(), input.slot)))
            .collect();
        if !unset.is_empty() {
            terminal.progress(format_args!(
                "{NOTE}note{NOTE:#}: {} is not set, so it is undef",
                unset.join(", ")
            ));
        }
    }

    fn undo(&mut self, count: &str, terminal: &mut TerminalOutput) -> Result<(), Report> {
        if let Some(count) = number(count, 1, terminal) {
            let undone = self
                .history
                .undo(usize::try_from(count).unwrap_or(usize::MAX));
            let steps = self.machine().steps();
            terminal.result(format_args!(
                "{FAINT}{undone} undone, {steps} steps left{FAINT:#}"
            ));
            self.print_watches(terminal);
        }
        Ok(())
    }

    fn print_history(&self, terminal: &mut TerminalOutput) -> Result<(), Report> {
        let mut steps = 0;
        for event in self.history.events() {
            let what = match event {
                HistoryEvent::Step => {
                    steps += 1;
                    format!("step {steps}")
                }
                HistoryEvent::Fire(rule) => format!("fire {rule}"),
                HistoryEvent::Set(function, arguments, value) => {
                    let location = simulate::applied(self.machine(), *function, arguments);
                    format!("set {location} := {}", self.value_text(value))
                }
                HistoryEvent::Release(function, arguments) => {
                    let location = simulate::applied(self.machine(), *function, arguments);
                    format!("unset {location}")
                }
            };
            terminal.result(format_args!("  {what}"));
        }
        Ok(())
    }

    fn save(&mut self, path: &str, terminal: &mut TerminalOutput) -> Result<(), Report> {
        if path.is_empty() {
            terminal.error("`save` needs a file name, as in `save found.avalla`");
            return Ok(());
        }
        let path = Path::new(path).with_extension("avalla");
        let text = save::scenario(&mut self.history, &path, Path::new(&self.path), self.seed);
        match std::fs::write(&path, text) {
            Ok(()) => terminal.status("Saved", path.display()),
            Err(error) => {
                terminal.error(format_args!("cannot write `{}`: {error}", path.display()))
            }
        }
        Ok(())
    }

    fn print_step(&self, terminal: &mut TerminalOutput) {
        let machine = self.machine();
        let step = machine.last_step();
        terminal.result(format_args!("{NAME}step {}{NAME:#}", step.number()));
        for input in step.inputs() {
            let location = simulate::location(machine, input.slot);
            let hint = if input.value.is_undef() {
                format!("  (`set {location} := …` sets it)")
            } else {
                String::new()
            };
            terminal.result(format_args!(
                "  {FAINT}{location} = {}{hint}{FAINT:#}",
                self.value_text(&input.value)
            ));
        }
        for choice in step.choices() {
            let place = self.history.session().specification.span(choice.origin);
            let sources = &self.history.session().specification.sources;
            let (line, _) = sources.position(place.file, place.start);
            terminal.result(format_args!(
                "  {FAINT}chose candidate {} of {} in line {line}{FAINT:#}",
                choice.index + 1,
                choice.count
            ));
        }
        self.print_updates(terminal);
    }

    fn print_updates(&self, terminal: &mut TerminalOutput) {
        let machine = self.machine();
        let step = machine.last_step();
        for (location, before, after) in simulate::updates(machine, &step) {
            terminal.result(format_args!(
                "  {location} := {after}  {FAINT}(was {before}){FAINT:#}"
            ));
        }
        for sent in step.sent() {
            terminal.result(simulate::sent(machine, sent));
        }
        for line in step.printed() {
            terminal.result(format_args!("  print: {line}"));
        }
        if step.updates().is_empty() {
            terminal.result(format_args!("  {FAINT}no updates{FAINT:#}"));
        }
    }

    fn print_watches(&mut self, terminal: &mut TerminalOutput) {
        for (index, (text, term)) in (1..).zip(&self.watches) {
            let value = match self.history.value(*term) {
                Ok(value) => {
                    let naming = self.history.session().machine.naming();
                    value.show(&naming).to_string()
                }
                Err(report) => {
                    let finding = report.diagnostics.into_iter().next();
                    finding.map_or(String::new(), |finding| finding.message)
                }
            };
            terminal.result(format_args!(
                "  {GOOD}watch {index}{GOOD:#} {text} = {value}"
            ));
        }
    }
}

/// Returns `true` if the last step wrote a location of the function, or the location with these arguments.
fn writes(history: &History, function: FunctionId, arguments: &[Value]) -> bool {
    let machine = &history.session().machine;
    let step = machine.last_step();
    step.updates().iter().any(|update| {
        let location = machine.state().location(machine.program(), update.slot);
        location.is_some_and(|(written, with)| {
            written == function && (arguments.is_empty() || with == arguments)
        })
    })
}

/// Number of times that a rule has run since it was last recorded.
fn calls(history: &History, rule: &str) -> u64 {
    let session = history.session();
    session.specification.calls(rule, &session.machine)
}

/// Parses a number; an empty text gives the default, any other text prints an error.
fn number(text: &str, default: u64, terminal: &mut TerminalOutput) -> Option<u64> {
    if text.is_empty() {
        return Some(default);
    }
    let number = text.parse().ok();
    if number.is_none() {
        terminal.error(format_args!("`{text}` is not a number"));
    }
    number
}

fn remove<T>(from: &mut Vec<T>, number: &str, terminal: &mut TerminalOutput) -> Result<(), Report> {
    let index = number
        .parse::<usize>()
        .ok()
        .and_then(|number| number.checked_sub(1));
    match index.filter(|index| *index < from.len()) {
        Some(index) => drop(from.remove(index)),
        None => terminal.error(format_args!("no entry has the number `{number}`")),
    }
    Ok(())
}
