//! Results of a verification as text and JSON.

use crate::terminal::{BAD, FAINT, GOOD, NAME, NOTE, TerminalOutput};
use asmotion_lang::{Span, Specification};
use asmotion_verify::{
    CheckedProperty, Incomplete, Note, Progress, PropertyKind, Run, RunStep, Verdict, Verification,
};
use serde_json::{Value, json};
use std::time::Duration;

/// A number with separators, as in `1,745,408`.
fn number(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// A number with a noun, as in `3 states`.
fn counted(count: u64, noun: &str) -> String {
    let plural = if count == 1 { "" } else { "s" };
    format!("{} {noun}{plural}", number(count))
}

fn duration(time: Duration) -> String {
    if time < Duration::from_secs(1) {
        format!("{} ms", time.as_millis())
    } else {
        format!("{:.1} s", time.as_secs_f64())
    }
}

/// A line about an exploration in progress.
pub fn progress(progress: &Progress, time: Duration) -> String {
    let rate = progress.states as f64 / time.as_secs_f64().max(0.001);
    let waiting = progress.states.saturating_sub(progress.explored);
    format!(
        "   Exploring {}, {} not explored yet, {}, {} a second, {} MiB",
        counted(progress.states, "state"),
        number(waiting),
        counted(progress.depth.into(), "step"),
        number(rate as u64),
        progress.memory >> 20,
    )
}

/// Prints the results for a specification.
pub fn text(
    path: &str,
    verification: &Verification,
    time: Duration,
    terminal: &mut TerminalOutput,
) {
    terminal.result(format_args!("{NAME}{path}{NAME:#}"));
    for property in &verification.properties {
        show_property(property, verification, terminal);
    }
    let count = |is: fn(&Verdict) -> bool| {
        let properties = verification.properties.iter();
        properties.filter(|it| is(&it.verdict)).count() as u64
    };
    let states = counted(verification.states, "state");
    let transitions = counted(verification.transitions, "transition");
    let (depth, time) = (counted(verification.depth.into(), "step"), duration(time));
    terminal.result(format_args!(
        "  {} hold, {} violated, {} not known: {states}, {transitions}, {depth} deep, {time}",
        number(count(Verdict::holds)),
        number(count(Verdict::is_violated)),
        number(count(|it| matches!(it, Verdict::Unknown))),
    ));
    for assumption in &verification.assumptions {
        terminal.result(format_args!("  {NOTE}assumed{NOTE:#} {assumption}"));
    }
    if verification.excluded > 0 {
        let excluded = counted(verification.excluded, "combination");
        terminal.result(format_args!(
            "  {NOTE}note{NOTE:#} the assumptions exclude {excluded} of a state and inputs"
        ));
    }
    if let Some(reason) = verification.incomplete {
        terminal.result(format_args!(
            "  {NOTE}note{NOTE:#} not all states were explored: {}",
            incomplete(reason)
        ));
    }
}

fn incomplete(reason: Incomplete) -> &'static str {
    match reason {
        Incomplete::States => "the number of states reached the limit, which `--states` sets",
        Incomplete::Depth => "the number of steps reached the limit, which `--bound` sets",
        Incomplete::Memory => "the memory reached the limit, which `--memory` sets",
        Incomplete::Stopped => "the time is up, which `--time` sets",
    }
}

fn kind(kind: PropertyKind) -> &'static str {
    match kind {
        PropertyKind::Invariant => "invariant",
        PropertyKind::Ctl => "CTL",
        PropertyKind::Ltl => "LTL",
        PropertyKind::Possible => "possible",
        PropertyKind::NoFault => "no-fault",
        PropertyKind::NotStuck => "not-stuck",
        PropertyKind::RulesRun => "rules-run",
    }
}

fn verdict(verdict: &Verdict) -> &'static str {
    match verdict {
        Verdict::Holds(_) => "holds",
        Verdict::Violated(_) => "violated",
        Verdict::Unknown => "unknown",
    }
}

/// The words before a property's text.
fn heading(property: &CheckedProperty) -> String {
    let introduced = match property.kind {
        PropertyKind::Invariant => "invariant ",
        PropertyKind::Ctl => "CTLSPEC ",
        PropertyKind::Ltl => "LTLSPEC ",
        PropertyKind::Possible => "possible: ",
        PropertyKind::NoFault | PropertyKind::NotStuck | PropertyKind::RulesRun => "",
    };
    match &property.name {
        Some(name) => format!("{introduced}{name}: {}", property.text),
        None => format!("{introduced}{}", property.text),
    }
}

fn show_property(
    property: &CheckedProperty,
    verification: &Verification,
    terminal: &mut TerminalOutput,
) {
    let colour = match property.verdict {
        Verdict::Holds(_) => GOOD,
        Verdict::Violated(_) => BAD,
        Verdict::Unknown => NOTE,
    };
    let specification = &verification.specification;
    let at = property.place.map(|place| place_text(specification, place));
    let at = at.map_or_else(String::new, |at| format!("  {FAINT}{at}{FAINT:#}"));
    let word = verdict(&property.verdict);
    let heading = heading(property);
    terminal.result(format_args!("  {colour}{word:<9}{colour:#} {heading}{at}"));
    for note in &property.notes {
        show_note(property, note, terminal);
    }
    if let Verdict::Violated(Some(run)) = &property.verdict {
        show_run(run, specification, terminal);
    } else if let (PropertyKind::Possible, Some(run)) = (property.kind, property.verdict.run()) {
        show_run(run, specification, terminal);
    }
}

fn show_note(property: &CheckedProperty, note: &Note, terminal: &mut TerminalOutput) {
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

/// Path and line of a place.
fn place_text(specification: &Specification, place: Span) -> String {
    let sources = &specification.sources;
    let (line, _) = sources.position(place.file, place.start);
    format!("{}:{line}", sources.path(place.file))
}

/// The rule that contains a place, with the line.
fn rule_text(specification: &Specification, place: Span) -> String {
    let (line, _) = specification.sources.position(place.file, place.start);
    match specification.rule_at(place) {
        Some(rule) => format!("{}, line {line}", rule.name),
        None => format!("line {line}"),
    }
}

fn show_run(run: &Run, specification: &Specification, terminal: &mut TerminalOutput) {
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
        show_step(index + 1, step, specification, terminal);
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
    number: usize,
    step: &RunStep,
    specification: &Specification,
    terminal: &mut TerminalOutput,
) {
    let mut causes: Vec<String> = step
        .inputs
        .iter()
        .map(|(input, value)| format!("{input} = {value}"))
        .collect();
    for (index, count, place) in &step.choices {
        let rule = rule_text(specification, *place);
        causes.push(format!("choice {} of {count} ({rule})", index + 1));
    }
    let causes = causes.join(", ");
    terminal.result(format_args!(
        "            {FAINT}step {number}{FAINT:#} {causes}"
    ));
    for update in &step.updates {
        let rule = rule_text(specification, update.place);
        terminal.result(format_args!(
            "              {}: {} → {}  {FAINT}{rule}{FAINT:#}",
            update.location, update.before, update.after
        ));
    }
    if let Some(fault) = &step.fault {
        terminal.result(format_args!(
            "              {BAD}fails{BAD:#}: {}",
            fault.message
        ));
    } else if step.updates.is_empty() {
        terminal.result(format_args!("              {FAINT}no change{FAINT:#}"));
    }
}

/// The results as a JSON object.
pub fn json(path: &str, verification: &Verification, time: Duration) -> Value {
    let specification = &verification.specification;
    let properties = verification.properties.iter().map(|property| {
        let place = property.place.map(|place| place_text(specification, place));
        json!({
            "kind": kind(property.kind),
            "name": property.name,
            "text": property.text,
            "place": place,
            "verdict": verdict(&property.verdict),
            "run": property.verdict.run().map(|run| run_json(run, specification)),
        })
    });
    json!({
        "type": "verification", "v": 1,
        "path": path,
        "properties": properties.collect::<Vec<Value>>(),
        "states": verification.states,
        "transitions": verification.transitions,
        "depth": verification.depth,
        "excluded": verification.excluded,
        "assumptions": verification.assumptions,
        "incomplete": verification.incomplete.map(incomplete_word),
        "milliseconds": time.as_millis() as u64,
    })
}

fn incomplete_word(reason: Incomplete) -> &'static str {
    match reason {
        Incomplete::States => "states",
        Incomplete::Depth => "bound",
        Incomplete::Memory => "memory",
        Incomplete::Stopped => "time",
    }
}

fn run_json(run: &Run, specification: &Specification) -> Value {
    let object = |pairs: &[(String, String)]| {
        let pairs = pairs
            .iter()
            .map(|(key, value)| (key.clone(), Value::from(value.clone())));
        Value::Object(pairs.collect())
    };
    let steps = run.steps.iter().map(|step| {
        let choices = step.choices.iter().map(|(index, count, place)| {
            json!({ "index": index, "count": count, "place": place_text(specification, *place) })
        });
        let updates = step.updates.iter().map(|update| {
            json!({
                "location": update.location,
                "before": update.before,
                "after": update.after,
                "place": place_text(specification, update.place),
            })
        });
        json!({
            "inputs": object(&step.inputs),
            "choices": choices.collect::<Vec<Value>>(),
            "updates": updates.collect::<Vec<Value>>(),
            "fault": step.fault.as_ref().map(|fault| fault.message.clone()),
        })
    });
    json!({
        "initial": object(&run.initial),
        "steps": steps.collect::<Vec<Value>>(),
        "cycle": run.cycle,
        "inputs": object(&run.inputs),
    })
}
