//! Results of a verification as text.

use super::memory::MemoryLimit;
use super::run::show_run;
use super::words::{duration, heading, incomplete, machine_name, place_in, qualified_verdict};
use crate::numbers::{counted, number};
use crate::terminal::{BAD, FAINT, GOOD, NAME, NOTE, TerminalOutput};
use asmotion_verify::{
    CheckedProperty, Note, PropertyKind, RepresentedInput, Verdict, Verification,
};
use std::time::Duration;

/// Prints the results for a specification.
pub fn text(
    path: &str,
    verification: &Verification,
    time: Duration,
    limit: MemoryLimit,
    terminal: &mut TerminalOutput,
) {
    terminal.result(format_args!("{NAME}{path}{NAME:#}"));
    for property in &verification.properties {
        show_property(property, verification, limit, terminal);
    }
    let count = |is: fn(&Verdict) -> bool| {
        let properties = verification.properties.iter();
        properties.filter(|it| is(&it.verdict)).count() as u64
    };
    // a verdict that depends on all states is marked in its own line, too
    let unless = match verification.expected_missed {
        Some(_) => " unless a state was missed",
        None => "",
    };
    let states = counted(verification.states, "state");
    let transitions = counted(verification.transitions, "transition");
    let (depth, time) = (counted(verification.depth.into(), "step"), duration(time));
    terminal.result(format_args!(
        "  {} hold{unless}, {} violated, {} not known: {states}, {transitions}, {depth} deep, {time}",
        number(count(Verdict::holds)),
        number(count(Verdict::is_violated)),
        number(count(|it| matches!(it, Verdict::Unknown))),
    ));
    if !verification.left_out.is_empty() {
        terminal.result(format_args!(
            "  {NOTE}note{NOTE:#} locations were left out on which the properties do not depend: of {}",
            verification.left_out.join(", ")
        ));
    }
    if verification.has_left_out_steps {
        terminal.result(format_args!(
            "  {NOTE}note{NOTE:#} steps that do not influence each other were executed in one order: there are fewer states and transitions than without `--independent`"
        ));
    }
    for domain in &verification.symmetric {
        terminal.result(format_args!(
            "  {NOTE}note{NOTE:#} states that differ by a permutation of {domain} are counted once"
        ));
    }
    if let Some(missed) = verification.expected_missed {
        terminal.result(format_args!(
            "  {NOTE}note{NOTE:#} states were stored as fingerprints of 64 bits: the expected number of states that were missed is {missed:.1e}; `--storage exact` and `--storage disk` miss none"
        ));
    }
    for assumption in &verification.assumptions {
        terminal.result(format_args!("  {NOTE}assumed{NOTE:#} {assumption}"));
    }
    for input in &verification.represented {
        show_represented(input, verification, terminal);
    }
    if verification.excluded > 0 {
        let excluded = counted(verification.excluded, "combination");
        terminal.result(format_args!(
            "  {NOTE}note{NOTE:#} the assumptions exclude {excluded} of a state and inputs"
        ));
    }
    if verification.ends > 0 {
        let ends = counted(verification.ends, "state");
        terminal.result(format_args!(
            "  {NOTE}note{NOTE:#} no step leads on from {ends}: for temporal properties, runs stay there for ever"
        ));
    }
    if let Some(reason) = verification.incomplete {
        terminal.result(format_args!(
            "  {NOTE}note{NOTE:#} not all states were explored: {}",
            incomplete(reason, limit)
        ));
        for growing in &verification.growing {
            let machines = verification.machines.as_slice();
            let place = place_in(machines, growing.machine, growing.place);
            let machine = machine_name(machines, growing.machine);
            let machine = machine.map_or_else(String::new, |name| format!("{name}."));
            terminal.result(format_args!(
                "  {NOTE}note{NOTE:#} {machine}{} grows: {}, … takes {} values in {}; bound its domain, or the steps with `--bound`  {FAINT}{place}{FAINT:#}",
                growing.location,
                growing.values.join(", "),
                number(growing.count as u64),
                counted(growing.states as u64, "state"),
            ));
        }
    }
}

/// Says that no location was left out.
pub fn without_cone(verification: &Verification, terminal: &mut TerminalOutput) {
    without_reduction(
        "--cone",
        "the properties depend on all locations, are about paths or shown by a run, or the states have no grounded form",
        verification,
        terminal,
    );
}

/// Says that no step was left out.
pub fn without_independence(verification: &Verification, terminal: &mut TerminalOutput) {
    without_reduction(
        "--independent",
        "all steps influence each other or a property, a property is about paths or shown by a run, or the states have no grounded form",
        verification,
        terminal,
    );
}

/// Says that no state was left out for symmetry.
pub fn without_symmetry(verification: &Verification, terminal: &mut TerminalOutput) {
    without_reduction(
        "--symmetry",
        "no domain is found whose elements are used alike, the states have no grounded form, or fairness tells elements apart",
        verification,
        terminal,
    );
}

/// Says why an option has no effect. Several machines are never reduced: each can read what the others write.
fn without_reduction(
    option: &str,
    reason: &str,
    verification: &Verification,
    terminal: &mut TerminalOutput,
) {
    let reason = if verification.machines.len() > 1 {
        "it is for one specification, and several are verified together, each of which can read and receive what the others write and send"
    } else {
        reason
    };
    terminal.result(format_args!(
        "  {NOTE}note{NOTE:#} `{option}` has no effect: {reason}"
    ));
}

/// Number of values of an input that are shown.
const SHOWN_VALUES: usize = 12;

/// Prints the values that stand for all others of an input.
fn show_represented(
    input: &RepresentedInput,
    verification: &Verification,
    terminal: &mut TerminalOutput,
) {
    let machine = machine_name(&verification.machines, input.machine);
    let machine = machine.map_or_else(String::new, |name| format!("{name}."));
    let values = input.values.iter().take(SHOWN_VALUES);
    let values = values.map(|it| match &it.stands_for {
        Some(others) => format!("{} ({others})", it.value),
        None => it.value.clone(),
    });
    let mut values: Vec<String> = values.collect();
    if let Some(more) = input.values.len().checked_sub(SHOWN_VALUES + 1) {
        values.push(format!("and {} more", number(more as u64 + 1)));
    }
    terminal.result(format_args!(
        "  {NOTE}note{NOTE:#} {machine}{} is only compared, so these values stand for all: {}",
        input.function,
        values.join(", ")
    ));
}

/// Prints the advice.
pub fn advice(verification: &Verification, terminal: &mut TerminalOutput) {
    if verification.incomplete.is_some() {
        terminal.result(format_args!(
            "  {NOTE}note{NOTE:#} there is no advice, because not all states were explored"
        ));
        return;
    }
    if !verification.has_advice_on_steps {
        terminal.result(format_args!(
            "  {NOTE}note{NOTE:#} there are too many steps for advice about updates and inputs"
        ));
    }
    for advice in &verification.advice {
        let place = place_in(&verification.machines, advice.machine, advice.place);
        terminal.result(format_args!(
            "  {NOTE}advice{NOTE:#}    {}  {FAINT}{place}{FAINT:#}",
            advice.text
        ));
    }
    if verification.advice.is_empty() {
        terminal.result(
            "  no advice: every branch is taken, every value occurs, every update has an effect",
        );
    }
}

fn show_property(
    property: &CheckedProperty,
    verification: &Verification,
    limit: MemoryLimit,
    terminal: &mut TerminalOutput,
) {
    let colour = match property.verdict {
        Verdict::Holds(_) => GOOD,
        Verdict::Violated(_) => BAD,
        Verdict::Unknown => NOTE,
    };
    let machines = verification.machines.as_slice();
    let at = property
        .place
        .map(|place| place_in(machines, property.machine, place));
    let at = at.map_or_else(String::new, |at| format!("  {FAINT}{at}{FAINT:#}"));
    let word = qualified_verdict(property, verification);
    let heading = heading(property);
    terminal.result(format_args!("  {colour}{word:<9}{colour:#} {heading}{at}"));
    for note in &property.notes {
        show_note(property, note, limit, terminal);
    }
    if let Verdict::Violated(Some(run)) = &property.verdict {
        show_run(run, machines, terminal);
    } else if let (PropertyKind::Possible, Some(run)) = (property.kind, property.verdict.run()) {
        show_run(run, machines, terminal);
    }
}

fn show_note(
    property: &CheckedProperty,
    note: &Note,
    limit: MemoryLimit,
    terminal: &mut TerminalOutput,
) {
    let text = match note {
        Note::Undefined(count) => {
            format!(
                "a condition is undef in {}, where it counts as false",
                counted(*count, "case")
            )
        }
        Note::Fails(diagnostic) => {
            format!(
                "a condition cannot be evaluated everywhere, and counts as false there: {}",
                diagnostic.message
            )
        }
        Note::Unmet(conditions) => {
            let conditions = conditions.join("`, `");
            format!(
                "vacuous: `{conditions}` is never true, so nothing is said about what it implies"
            )
        }
        Note::Irrelevant(conditions) => {
            format!(
                "it holds whatever the value of `{}`",
                conditions.join("`, `")
            )
        }
        Note::Unfair { all: true } => {
            "no run satisfies the fairness constraints, so every property holds".to_owned()
        }
        Note::Unfair { all: false } => {
            "from some initial states no run satisfies the fairness constraints".to_owned()
        }
        Note::Undecided(reason) => {
            format!(
                "all states were explored, but it was not decided: {}",
                incomplete(*reason, limit)
            )
        }
        Note::Unexamined(reason) => {
            format!(
                "whether it holds vacuously was not examined: {}",
                incomplete(*reason, limit)
            )
        }
        Note::FailingSteps => {
            "steps that fail have no next state; a state in which every step fails stays for ever"
                .to_owned()
        }
        Note::Also(places) => {
            let word = if property.kind == PropertyKind::RulesRun {
                "never run"
            } else {
                "also"
            };
            format!("{word}: {}", places.join(", "))
        }
    };
    terminal.result(format_args!("            {NOTE}note{NOTE:#} {text}"));
}
