//! Messages that an actor receives: the rules that determine the inputs of its next step.

use super::EnvironmentWriter;
use super::calls::{self, call_state, is_location};
use crate::actor::{Actor, ActorInput, InputOrigin, word};
use crate::error::ModelError;
use asmotion_coordinator::Receive;
use std::collections::BTreeSet;

impl EnvironmentWriter<'_> {
    /// The rules that determine the inputs of the next step of an actor.
    pub(super) fn receive(&mut self, at: usize) -> Result<Vec<String>, ModelError> {
        let Some(actor) = self.actor(at) else {
            return Ok(Vec::new());
        };
        let mut rules = Vec::new();
        for input in &actor.inputs {
            if self.is_set(at, &input.function) && !self.glue.fixed.contains(&input.function) {
                rules.extend(self.receive_input(actor, input));
            }
        }
        Ok(rules)
    }

    fn receive_input(&mut self, actor: &Actor, input: &ActorInput) -> Option<String> {
        let (x, word) = (&input.location, word(actor, input));
        match (&input.origin, input.receive) {
            (InputOrigin::Value(_), _) => None,
            (InputOrigin::Timer(condition), _) => Some(format!(
                "if {condition} then if not {x} then choose $late in Boolean do {x} := $late endif else {x} := false endif"
            )),
            (InputOrigin::Losses, _) => {
                let counts = if input.codomain.is_boolean() {
                    "Boolean"
                } else {
                    self.notes
                        .insert("at most 2 messages are lost between two steps".to_owned());
                    "{0, 1, 2}"
                };
                Some(format!("choose $lost in {counts} do {x} := $lost"))
            }
            (_, Receive::Edge) => Some(format!(
                "par {x} := arrived_{word} arrived_{word} := false endpar"
            )),
            (_, Receive::Last) => input.stale.as_ref().map(|stale| {
                format!("choose $stale in Boolean do if $stale then {x} := {stale} endif")
            }),
            (origin, Receive::All) => {
                Some(self.next_event(actor, input, *origin != InputOrigin::Calls))
            }
        }
    }

    /// The rule that takes the next event of an input: a waiting message or the outcome of a call.
    fn next_event(&mut self, actor: &Actor, input: &ActorInput, has_queue: bool) -> String {
        let (x, word) = (&input.location, word(actor, input));
        let none = input.none.as_deref().unwrap_or("undef");
        let nothing = format!("{x} := {none}");
        let mut taken = vec![
            format!("{x} := first(waiting_{word})"),
            format!("waiting_{word} := tail(waiting_{word})"),
        ];
        let mut sources = Vec::new();
        for output in &actor.outputs {
            let calls = calls::calls(actor, output);
            let mut cases = Vec::new();
            for call in &calls {
                let Some(event) = &call.call.event else {
                    continue;
                };
                if !is_location(actor, event, input) {
                    continue;
                }
                let values: Vec<String> = self
                    .outcomes(actor, call.call)
                    .into_iter()
                    .flatten()
                    .map(|text| crate::bound::literal(&text, &input.codomain).name)
                    .collect::<BTreeSet<_>>()
                    .into_iter()
                    .collect();
                if !values.is_empty() {
                    let choice = format!(
                        "choose $outcome in {{{}}} do {x} := $outcome",
                        values.join(", ")
                    );
                    cases.push((call.state.clone(), choice));
                }
            }
            if !cases.is_empty() {
                let state = call_state(actor, output);
                // events wait in order of arrival, whether they are messages or outcomes
                let is_ordered = has_queue && calls::has_queue(actor, output);
                if is_ordered {
                    let ahead = format!("ahead_{state}");
                    taken.push(format!("if {ahead} > 0 then {ahead} := {ahead} - 1 endif"));
                }
                sources.push((state, is_ordered, cases));
            }
        }
        let pop = format!("par {} endpar", taken.join(" "));
        if sources.is_empty() {
            return if has_queue {
                format!("if length(waiting_{word}) > 0 then {pop} else {nothing} endif")
            } else {
                nothing
            };
        }
        let mut literals = vec![format!("NOTHING_FOR_{word}")];
        let mut guards = Vec::new();
        let mut branches = vec![format!("case NOTHING_FOR_{word}: {nothing}")];
        if has_queue {
            literals.push(format!("MESSAGE_FOR_{word}"));
            guards.push(format!(
                "($from = NOTHING_FOR_{word} and length(waiting_{word}) = 0)"
            ));
            guards.push(format!(
                "($from = MESSAGE_FOR_{word} and length(waiting_{word}) > 0)"
            ));
            branches.push(format!("case MESSAGE_FOR_{word}: {pop}"));
        } else {
            guards.push(format!("$from = NOTHING_FOR_{word}"));
        }
        for (number, (state, is_ordered, cases)) in sources.iter().enumerate() {
            let literal = format!("OUTCOME_{number}_FOR_{word}");
            let called: Vec<String> = cases
                .iter()
                .map(|(it, _)| format!("{state} = {it}"))
                .collect();
            let first = if *is_ordered {
                format!("ahead_{state} = 0 and ")
            } else {
                String::new()
            };
            guards.push(format!(
                "($from = {literal} and {first}({}))",
                called.join(" or ")
            ));
            let cases: Vec<String> = cases
                .iter()
                .map(|(it, rule)| format!("case {it}: {rule}"))
                .collect();
            branches.push(format!(
                "case {literal}: par switch {state} {} endswitch {state} := NO_{} endpar",
                cases.join(" "),
                state.to_uppercase()
            ));
            literals.push(literal);
        }
        self.glue.declare(
            &format!("origin of the next `{x}`"),
            format!("enum domain OriginOf_{word} = {{{}}}", literals.join(" | ")),
        );
        format!(
            "choose $from in OriginOf_{word} with {} do switch $from {} endswitch",
            guards.join(" or "),
            branches.join(" ")
        )
    }
}
