//! Runs as text: the first state, then what each step changes, and why.

use super::words::{machine_name, rule_text};
use crate::terminal::{BAD, FAINT, TerminalOutput};
use asmotion_lang::guards::PassedGuard;
use asmotion_lang::{Diagnostic, Sources, Specification};
use asmotion_verify::{Run, RunChoice, RunStep, VerifiedMachine};

pub fn show_run(run: &Run, machines: &[VerifiedMachine], terminal: &mut TerminalOutput) {
    let initial: Vec<String> = run
        .initial
        .iter()
        .map(|(location, value)| format!("{location} = {value}"))
        .collect();
    terminal.result(format_args!(
        "            {FAINT}initially{FAINT:#} {}",
        initial.join(", ")
    ));
    for (index, step) in run.steps.iter().enumerate() {
        if run.cycle == Some(index) {
            terminal.result(format_args!(
                "            {FAINT}from here on repeated for ever{FAINT:#}"
            ));
        }
        if let Some(machine) = machines.get(step.machine) {
            let mover = machine_name(machines, step.machine);
            show_step(mover, step, &machine.specification, terminal);
        }
    }
    if run.cycle.is_some_and(|cycle| cycle >= run.steps.len()) {
        terminal.result(format_args!(
            "            {FAINT}and nothing changes any more{FAINT:#}"
        ));
    }
    if !run.inputs.is_empty() {
        let inputs: Vec<String> = run
            .inputs
            .iter()
            .map(|(it, value)| format!("{it} = {value}"))
            .collect();
        terminal.result(format_args!(
            "            {FAINT}then{FAINT:#} {}",
            inputs.join(", ")
        ));
    }
}

fn show_step(
    mover: Option<&str>,
    step: &RunStep,
    specification: &Specification,
    terminal: &mut TerminalOutput,
) {
    let mut causes: Vec<String> = step
        .inputs
        .iter()
        .map(|(input, value)| format!("{input} = {value}"))
        .collect();
    causes.extend(step.choices.iter().map(|it| choice_text(it, specification)));
    let causes = causes.join(", ");
    let number = step.transition;
    let mover = mover.map_or_else(String::new, |name| format!("{name}: "));
    terminal.result(format_args!(
        "            {FAINT}step {number}{FAINT:#} {mover}{causes}"
    ));
    for (index, update) in step.updates.iter().enumerate() {
        let rule = rule_text(specification, update.place);
        terminal.result(format_args!(
            "              {}: {} → {}  {FAINT}{rule}{FAINT:#}",
            update.location, update.before, update.after
        ));
        let next = step.updates.get(index + 1);
        let is_last = next.is_none_or(|next| next.guards != update.guards);
        if is_last && !update.guards.is_empty() {
            let guards = update.guards.iter().map(|guard| guard_text(guard, step));
            let guards = guards.collect::<Vec<String>>().join(", ");
            terminal.result(format_args!(
                "                {FAINT}because {guards}{FAINT:#}"
            ));
        }
    }
    for message in &step.messages {
        terminal.result(format_args!("              {FAINT}{message}{FAINT:#}"));
    }
    if let Some(fault) = &step.fault {
        show_fault(fault, &specification.sources, terminal);
    } else if step.updates.is_empty() && step.messages.is_empty() {
        terminal.result(format_args!("              {FAINT}no change{FAINT:#}"));
    }
}

/// The fault of a step: code and message, its places with what they say, and the way out.
fn show_fault(fault: &Diagnostic, sources: &Sources, terminal: &mut TerminalOutput) {
    terminal.result(format_args!(
        "              {BAD}fails[{}]{BAD:#}: {}",
        fault.code, fault.message
    ));
    for label in fault.primary.iter().chain(&fault.secondary) {
        let (line, column) = sources.position(label.span.file, label.span.start);
        let path = sources.path(label.span.file);
        let text = if label.text.is_empty() {
            String::new()
        } else {
            format!(": {}", label.text)
        };
        terminal.result(format_args!(
            "                {FAINT}{path}:{line}:{column}{FAINT:#}{text}"
        ));
    }
    for note in &fault.notes {
        terminal.result(format_args!("                {FAINT}note:{FAINT:#} {note}"));
    }
    for help in &fault.helps {
        terminal.result(format_args!("                {FAINT}help:{FAINT:#} {help}"));
    }
}

/// A choice with the values of its variables, as in `$p = 2 (3 of 5, r_Main, line 40)`.
fn choice_text(choice: &RunChoice, specification: &Specification) -> String {
    let values = choice
        .values
        .iter()
        .map(|(variable, value)| format!("{variable} = {value}"));
    let values = values.collect::<Vec<String>>().join(", ");
    let values = if values.is_empty() {
        "choice".to_owned()
    } else {
        values
    };
    let rule = rule_text(specification, choice.place);
    format!(
        "{values} ({} of {}, {rule})",
        choice.index + 1,
        choice.count
    )
}

/// A guard with the values that it read, without the inputs of the step, which are shown before, and those that its text says.
fn guard_text(guard: &PassedGuard, step: &RunStep) -> String {
    let values = guard
        .values
        .iter()
        .filter(|pair| !step.inputs.contains(pair) && !is_said(guard, pair));
    let values = values.map(|(name, value)| format!("{name} = {value}"));
    let values = values.collect::<Vec<String>>().join(", ");
    let not = if guard.holds { "" } else { "not " };
    if values.is_empty() {
        format!("{not}`{}`", guard.text)
    } else {
        format!("{not}`{}` ({values})", guard.text)
    }
}

/// Returns `true` if the text of a guard that holds says the value: `mode = READY`, alone or as one of several conditions.
fn is_said(guard: &PassedGuard, (name, value): &(String, String)) -> bool {
    let is_conjunction = !OTHER_OPERATORS.iter().any(|it| guard.text.contains(it));
    if guard.text == *name {
        return *value == guard.holds.to_string();
    }
    guard.holds
        && is_conjunction
        && guard.text.split(" and ").any(|condition| {
            condition
                .split_once(" = ")
                .is_some_and(|(left, right)| left == name && right == value)
        })
}

/// Signs of a term in which a condition can be false although the whole is true.
const OTHER_OPERATORS: [&str; 7] = ["(", " or ", " xor ", " implies ", " iff ", "not ", "if "];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_is_omitted_only_if_the_guard_says_it() {
        let says = |text: &str, holds: bool| {
            let guard = PassedGuard {
                text: text.to_owned(),
                holds,
                values: Vec::new(),
                place: Default::default(),
            };
            is_said(&guard, &("mode".to_owned(), "READY".to_owned()))
        };
        assert!(says("mode = READY", true));
        assert!(says("mode = READY and start", true));
        assert!(!says("mode = READY", false));
        assert!(!says("mode = target", true));
        assert!(!says("mode = READY or start", true));
        assert!(!says("not mode = READY and start", true));
        assert!(!says("mode != IDLE", true));
    }
}
