//! Compares a recorded step with its repetition.

use std::collections::{BTreeMap, BTreeSet};

use asmotion_coordinator::{RecordedCycle, UpdateRecord, ViolationRecord};
use asmotion_lang::Specification;

use super::difference::{DifferenceKind, WrittenValue};

/// A recorded step and its repetition, with the specifications that made them.
pub(super) struct StepPair<'a> {
    pub recorded: &'a RecordedCycle,
    pub replayed: &'a RecordedCycle,
    /// The recorded specification, if it can be opened.
    pub recorded_specification: Option<&'a Specification>,
    pub replayed_specification: &'a Specification,
}

impl StepPair<'_> {
    /// Returns the first difference in the effects of the step. Updates of the functions in `new` are not compared, nor are the
    /// places of updates if the specifications are different.
    pub fn effects(&self, new: &BTreeSet<String>, is_same: bool) -> Option<DifferenceKind> {
        let (recorded, replayed) = (self.recorded, self.replayed);
        let has_same_fault = if is_same {
            recorded.fault == replayed.fault
        } else {
            // a message names places and values, which may differ for one reason
            recorded.fault.is_some() == replayed.fault.is_some()
        };
        if !has_same_fault {
            return Some(DifferenceKind::Fault {
                recorded: recorded.fault.clone(),
                replayed: replayed.fault.clone(),
            });
        }
        let rule = |cycle: &RecordedCycle| Some(cycle.replaced.as_ref()?.rule.clone());
        let (recorded_rule, replayed_rule) = (rule(recorded), rule(replayed));
        if recorded_rule != replayed_rule {
            return Some(DifferenceKind::Rule {
                recorded: recorded_rule,
                replayed: replayed_rule,
            });
        }
        let update = self.update(new, is_same);
        let violated = || {
            let texts = |cycle: &RecordedCycle| -> Vec<String> {
                let violations = cycle.violations.iter();
                violations.map(|it| violation(it, is_same)).collect()
            };
            let (recorded, replayed) = first_pair(&texts(recorded), &texts(replayed))?;
            Some(DifferenceKind::Violation { recorded, replayed })
        };
        let extended = || {
            let (recorded, replayed) = first_pair(&recorded.extended, &replayed.extended)?;
            Some(DifferenceKind::Extended { recorded, replayed })
        };
        let sent = || {
            let (recorded, replayed) = first_pair(&recorded.sent, &replayed.sent)?;
            Some(DifferenceKind::Sent { recorded, replayed })
        };
        let found = update.or_else(violated);
        found.or_else(extended).or_else(sent)
    }

    /// Returns the first difference in what the step depended on, for an equal specification.
    pub fn causes(&self) -> Option<DifferenceKind> {
        let (recorded, replayed) = (self.recorded, self.replayed);
        if recorded.number != replayed.number {
            let replayed = replayed.number;
            return Some(DifferenceKind::Number { replayed });
        }
        if let Some((recorded, replayed)) = first_pair(&recorded.read, &replayed.read) {
            return Some(DifferenceKind::Read { recorded, replayed });
        }
        let (recorded, replayed) = first_pair(&recorded.choices, &replayed.choices)?;
        Some(DifferenceKind::Choice { recorded, replayed })
    }

    fn update(&self, new: &BTreeSet<String>, is_same: bool) -> Option<DifferenceKind> {
        let by_location = |updates: &[UpdateRecord]| -> BTreeMap<String, UpdateRecord> {
            let updates = updates.iter();
            updates
                .map(|it| (it.location.clone(), it.clone()))
                .collect()
        };
        if self.recorded.updates == self.replayed.updates {
            return None;
        }
        let recorded = by_location(&self.recorded.updates);
        let replayed = by_location(&self.replayed.updates);
        let locations: BTreeSet<_> = recorded.keys().chain(replayed.keys()).collect();
        let differs = |location: &&&String| {
            let (one, other) = (recorded.get(**location), replayed.get(**location));
            let is_equal = match (one, other) {
                (Some(one), Some(other)) if is_same => one == other,
                (Some(one), Some(other)) => {
                    (&one.before, &one.after) == (&other.before, &other.after)
                }
                (Some(_), None) => false,
                (None, Some(_)) => new.contains(function(location)),
                (None, None) => true,
            };
            !is_equal
        };
        let location = locations.iter().find(differs)?;
        let of_recorded = recorded.get(*location);
        let of_replayed = replayed.get(*location);
        Some(DifferenceKind::Update {
            location: (*location).clone(),
            recorded: of_recorded.map(|it| written(it, self.recorded_specification)),
            replayed: of_replayed.map(|it| written(it, Some(self.replayed_specification))),
        })
    }
}

/// A violation as text; of another specification only what is violated.
fn violation(record: &ViolationRecord, is_same: bool) -> String {
    if is_same {
        return record.to_string();
    }
    let ViolationRecord { kind, property, .. } = record;
    match &record.name {
        Some(name) => format!("{kind} {name}"),
        None => format!("{kind} `{property}`"),
    }
}

fn written(update: &UpdateRecord, specification: Option<&Specification>) -> WrittenValue {
    WrittenValue {
        before: update.before.clone(),
        after: update.after.clone(),
        place: update.place.clone(),
        rule: specification.and_then(|it| rule_at(it, &update.place)),
    }
}

/// The function of a location as text.
pub(super) fn function(location: &str) -> &str {
    location.split('(').next().unwrap_or_default()
}

/// The rule declaration around a place, as in `navigate.asm:42`.
pub(super) fn rule_at(specification: &Specification, place: &str) -> Option<String> {
    let (name, line) = place.rsplit_once(':')?;
    let line = line.parse::<usize>().ok()?;
    let sources = &specification.sources;
    let found = specification.model.rules.iter().find(|rule| {
        let Some(span) = rule.body.as_ref().map(|body| body.root.span) else {
            return false;
        };
        let path = sources.path(span.file);
        let (first, _) = sources.position(span.file, span.start);
        let (last, _) = sources.position(span.file, span.end);
        path.rsplit('/').next() == Some(name) && (first..=last).contains(&line)
    });
    found.map(|rule| rule.name.to_string())
}

/// Returns the first elements at which two lists differ.
fn first_pair<T: Clone + PartialEq>(one: &[T], other: &[T]) -> Option<(Option<T>, Option<T>)> {
    let length = one.len().max(other.len());
    let mut pairs = (0..length).map(|index| (one.get(index), other.get(index)));
    let (one, other) = pairs.find(|(one, other)| one != other)?;
    Some((one.cloned(), other.cloned()))
}
