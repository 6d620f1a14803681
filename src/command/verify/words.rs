//! Numbers, places and results in words.

use super::interrupt;
use super::memory::MemoryLimit;
use asmotion_lang::{Span, Specification};
use asmotion_verify::{
    CheckedProperty, Incomplete, PropertyKind, Verdict, Verification, VerifiedMachine,
};
use std::time::Duration;

pub fn duration(time: Duration) -> String {
    if time < Duration::from_secs(1) {
        format!("{} ms", time.as_millis())
    } else {
        format!("{:.1} s", time.as_secs_f64())
    }
}

pub fn incomplete(reason: Incomplete, limit: MemoryLimit) -> String {
    let text = match reason {
        Incomplete::States => "the number of states reached the limit, which `--states` sets",
        Incomplete::Depth => "the number of steps reached the limit, which `--bound` sets",
        Incomplete::Memory => return limit.reached(),
        Incomplete::Reserve => {
            "a state has more elements created by `extend` than `--reserve` permits"
        }
        Incomplete::Stopped if interrupt::has_occurred() => "it was interrupted",
        Incomplete::Stopped => "the time is up, which `--time` sets",
    };
    text.to_owned()
}

pub fn kind(kind: PropertyKind) -> &'static str {
    match kind {
        PropertyKind::Invariant => "invariant",
        PropertyKind::Constraint => "constraint",
        PropertyKind::Ctl => "CTL",
        PropertyKind::Ltl => "LTL",
        PropertyKind::Possible => "possible",
        PropertyKind::NoFault => "no-fault",
        PropertyKind::NotStuck => "not-stuck",
        PropertyKind::RulesRun => "rules-run",
    }
}

pub fn verdict(verdict: &Verdict) -> &'static str {
    match verdict {
        Verdict::Holds(_) => "holds",
        Verdict::Violated(_) => "violated",
        Verdict::Unknown => "unknown",
    }
}

/// Returns `true` if the verdict is about all states, of which one may have been missed.
pub fn is_qualified(property: &CheckedProperty, verification: &Verification) -> bool {
    verification.expected_missed.is_some() && property.is_about_all_states()
}

/// The verdict of a property, with what it depends on.
pub fn qualified_verdict(property: &CheckedProperty, verification: &Verification) -> String {
    let word = verdict(&property.verdict);
    if is_qualified(property, verification) {
        format!("{word} unless a state was missed:")
    } else {
        word.to_owned()
    }
}

/// Path and line of a place.
pub fn place_text(specification: &Specification, place: Span) -> String {
    let sources = &specification.sources;
    let (line, _) = sources.position(place.file, place.start);
    format!("{}:{line}", sources.path(place.file))
}

/// Path and line of a place in the specification of a machine.
pub fn place_in(machines: &[VerifiedMachine], machine: usize, place: Span) -> String {
    let machine = machines.get(machine);
    machine.map_or_else(String::new, |it| place_text(&it.specification, place))
}

/// Name of a machine; `None` if there is only one.
pub fn machine_name(machines: &[VerifiedMachine], machine: usize) -> Option<&str> {
    let named = machines.get(machine).filter(|_| machines.len() > 1);
    named.map(|it| it.name.as_str())
}

/// The rule that contains a place, with the line.
pub fn rule_text(specification: &Specification, place: Span) -> String {
    let (line, _) = specification.sources.position(place.file, place.start);
    match specification.rule_at(place) {
        Some(rule) => format!("{}, line {line}", rule.name),
        None => format!("line {line}"),
    }
}

/// The words before a property's text.
pub fn heading(property: &CheckedProperty) -> String {
    let introduced = match property.kind {
        PropertyKind::Invariant => "invariant ",
        PropertyKind::Constraint => "INVAR ",
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
