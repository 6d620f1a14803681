//! Comparison of two normalised traces.

use std::collections::BTreeSet;

/// The parts of a step in which two traces must agree.
#[derive(Debug, Default)]
pub struct Facts {
    pub outcome: String,
    pub updates: BTreeSet<String>,
    pub state: BTreeSet<String>,
}

/// Returns whether two runs are equal: step by step the same outcome, the same update set, and a state that contains
/// the reference's. If the reference crashed, any failure is accepted, and missing facts are no difference.
pub fn agree(reference: &str, ours: &str) -> bool {
    let (theirs, ours) = (facts(reference), facts(ours));
    for (theirs, ours) in theirs.iter().zip(&ours) {
        if theirs.outcome.starts_with("EXC") {
            return true;
        }
        if theirs.outcome != ours.outcome {
            return false;
        }
        if !theirs.outcome.is_empty() {
            return true;
        }
        if theirs.updates != ours.updates || !theirs.state.is_subset(&ours.state) {
            return false;
        }
    }
    theirs.len() == ours.len()
}

pub fn facts(trace: &str) -> Vec<Facts> {
    let mut steps: Vec<Facts> = Vec::new();
    for line in trace.lines() {
        if line.starts_with("@step") {
            steps.push(Facts::default());
        }
        let (Some(step), Some((word, fact))) = (steps.last_mut(), line.split_once(' ')) else {
            continue;
        };
        // the reference stores `result`, and appends the domains of a rule to its name
        if fact.starts_with("result = ") {
            continue;
        }
        let fact = fact.split_once("= rule ").map_or(fact, |_| {
            fact.split_once('(').map_or(fact, |(rule, _)| rule)
        });
        match word {
            "U" | "UD" => drop(step.updates.insert(canonical(fact))),
            "S" => drop(step.state.insert(canonical(fact))),
            "@error" => step.outcome = fact.split(' ').next().unwrap_or_default().to_owned(),
            // only the time of the check differs; that the invariant is violated does not
            "@invariant" => step.outcome = "INV".to_owned(),
            _ => {}
        }
    }
    steps
}

/// A fact with real numbers in a canonical form.
fn canonical(fact: &str) -> String {
    let mut text = String::new();
    let mut rest = fact;
    while let Some(letter) = rest.chars().next() {
        let length = word(rest).max(letter.len_utf8());
        let (word, after) = rest.split_at(length);
        match word.parse::<f64>() {
            Ok(number) if word.contains('.') => text.push_str(&format!("{number:?}")),
            _ => text.push_str(word),
        }
        rest = after;
    }
    text
}

/// The length of the word at the start of a text; a number may have a negative exponent.
fn word(text: &str) -> usize {
    let mut before = ' ';
    let is_inside = |(_, letter): &(usize, char)| {
        let exponent = *letter == '-' && before == 'E';
        before = *letter;
        letter.is_alphanumeric() || "._!".contains(*letter) || exponent
    };
    let inside = text.char_indices().take_while(is_inside).last();
    inside.map_or(0, |(at, letter)| at + letter.len_utf8())
}
