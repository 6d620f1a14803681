//! The steps of other components between two steps of the verified one, and messages from anywhere.

use super::EnvironmentWriter;
use crate::actor::{Actor, ActorInput, InputOrigin, word};
use crate::error::ModelError;
use crate::glue::sequence;
use crate::message::{FieldVariable, SentMessage};
use crate::rename::label;
use asmotion_coordinator::Receive;
use std::collections::{BTreeMap, BTreeSet};

impl EnvironmentWriter<'_> {
    /// The rule for the steps of an actor between two steps of the verified specification.
    pub(super) fn steps(
        &mut self,
        at: usize,
        receive: &[String],
        effects: &[String],
    ) -> Result<String, ModelError> {
        let Some(actor) = self.actor(at) else {
            return Ok("skip".to_owned());
        };
        let mut cycle = self.open_inputs(at, actor)?;
        cycle.extend_from_slice(receive);
        cycle.push(format!("{}[]", actor.main));
        // inputs are part of the state only while they wait
        let resets = actor.inputs.iter().filter_map(|input| match input.receive {
            Receive::Edge => Some(format!("{} := false", input.location)),
            Receive::All => {
                let none = input.none.as_deref().unwrap_or("undef");
                Some(format!("{} := {none}", input.location))
            }
            // the field of a message is known while the message is new
            Receive::Last => {
                let same =
                    |it: &&ActorInput| it.origin == input.origin && it.receive == Receive::Edge;
                let of_arrival = actor.is_protocol && actor.inputs.iter().any(|it| same(&it));
                of_arrival.then(|| format!("{} := undef", input.location))
            }
        });
        cycle.extend(resets);
        cycle.extend_from_slice(effects);
        if actor.is_protocol {
            // the value is that of the message
            cycle.extend(
                actor
                    .outputs
                    .iter()
                    .map(|it| format!("{} := undef", it.location)),
            );
        }
        let cycle = self
            .named(actor, "cycle", "a step", &cycle)
            .unwrap_or_else(|| "skip".to_owned());
        let (least, most) = actor.steps;
        if actor.is_protocol {
            let waits =
                actor
                    .inputs
                    .iter()
                    .filter_map(|input| match (&input.origin, input.receive) {
                        (InputOrigin::Port(_) | InputOrigin::Request { .. }, Receive::Edge) => {
                            Some(format!("arrived_{}", word(actor, input)))
                        }
                        (InputOrigin::Port(_) | InputOrigin::Request { .. }, Receive::All) => {
                            Some(format!("length(waiting_{}) > 0", word(actor, input)))
                        }
                        (_, _) => None,
                    });
            let waits: Vec<String> = waits.collect();
            // a slower component may not have read its messages yet
            if least == 0 && !waits.is_empty() {
                return Ok(format!(
                    "if {} then choose $steps in Boolean do if $steps then {cycle} endif else {cycle} endif",
                    waits.join(" or ")
                ));
            }
            // several steps would multiply the states
            if most > 1 {
                self.notes.insert(format!(
                    "{} sends one message of a kind between two steps, although it is faster",
                    actor.component
                ));
            }
            return Ok(cycle);
        }
        if least == 0 {
            return Ok(repeated(&cycle, least, most));
        }
        // which of the components steps first, and when, depends on their start
        let flag = format!("steps_{}", label(&actor.component));
        self.glue.declare(
            &format!("{} has had time for all its steps", actor.component),
            format!("controlled {flag}: Boolean"),
        );
        self.glue.start(&flag, "false");
        let first = sequence(&[repeated(&cycle, 0, most), format!("{flag} := true")]);
        let later = repeated(&cycle, least, most);
        Ok(format!("if {flag} then {later} else {first} endif"))
    }

    /// Rules for messages to an actor from components without a protocol.
    pub(super) fn open_inputs(
        &mut self,
        at: usize,
        actor: &Actor,
    ) -> Result<Vec<String>, ModelError> {
        let mut rules = Vec::new();
        for input in &actor.inputs {
            let has_port = matches!(
                input.origin,
                InputOrigin::Port(_) | InputOrigin::Request { .. }
            );
            if !has_port || !self.is_open(at, input) {
                continue;
            }
            let none = BTreeMap::new();
            if let Some(rule) = self.deliver(at, actor, input, &SentMessage::Any(&none), None)? {
                rules.push(format!(
                    "choose $sends in Boolean do if $sends then {rule} endif"
                ));
            }
        }
        Ok(rules)
    }

    /// Rules for messages to the verified specification from components without a protocol, and from outside. Inputs that
    /// read the same messages get the same one.
    pub(super) fn external_deliveries(&mut self) -> Result<Vec<String>, ModelError> {
        let Some(actor) = self.actor(0) else {
            return Ok(Vec::new());
        };
        let mut groups: Vec<(&InputOrigin, Vec<&ActorInput>)> = Vec::new();
        for input in &actor.inputs {
            let has_port = matches!(
                input.origin,
                InputOrigin::Port(_) | InputOrigin::Request { .. }
            );
            if !has_port || !self.is_set(0, &input.function) || !self.is_open(0, input) {
                continue;
            }
            match groups
                .iter_mut()
                .find(|(origin, _)| **origin == input.origin)
            {
                Some((_, group)) => group.push(input),
                None => groups.push((&input.origin, vec![input])),
            }
        }
        let mut rules = Vec::new();
        for (number, (_, group)) in groups.iter().enumerate() {
            let fields = self.fields(number, actor, group)?;
            let mut deliveries = Vec::new();
            for input in group {
                deliveries.extend(self.deliver(
                    0,
                    actor,
                    input,
                    &SentMessage::Any(&fields),
                    None,
                )?);
            }
            let mut rule = sequence(&deliveries);
            if !fields.is_empty() {
                let binders = fields
                    .values()
                    .map(|it| format!("{} in {}", it.variable, it.domain));
                rule = format!(
                    "choose {} do {rule}",
                    binders.collect::<Vec<_>>().join(", ")
                );
            }
            rules.push(format!(
                "choose $sends in Boolean do if $sends then {rule} endif"
            ));
        }
        Ok(rules)
    }

    /// Variables for the fields of a message with any content.
    pub(super) fn fields(
        &mut self,
        number: usize,
        actor: &Actor,
        group: &[&ActorInput],
    ) -> Result<BTreeMap<Option<String>, FieldVariable>, ModelError> {
        let mut fields: BTreeMap<Option<String>, FieldVariable> = BTreeMap::new();
        let mut texts: BTreeMap<Option<String>, BTreeSet<String>> = BTreeMap::new();
        for input in group {
            if !input.is.is_empty() {
                texts
                    .entry(input.field.clone())
                    .or_default()
                    .extend(input.is.iter().cloned());
            }
        }
        for input in group {
            let needs_value = input.receive != Receive::Edge || !input.is.is_empty();
            if !needs_value || fields.contains_key(&input.field) {
                continue;
            }
            let variable = format!("$field{}", fields.len());
            let mut field = FieldVariable {
                variable,
                domain: String::new(),
                texts: Vec::new(),
            };
            match texts.get_mut(&input.field) {
                None => field.domain = self.listed(actor, input)?,
                Some(texts) => {
                    let same = group
                        .iter()
                        .filter(|it| it.field == input.field && it.is.is_empty());
                    let literals = same.flat_map(|it| it.codomain.elements.iter().flatten());
                    texts.extend(literals.map(|it| it.declared.clone()));
                    field.domain = format!("Texts_{number}_{}", fields.len());
                    let literal =
                        |text: &String| format!("TEXT_{number}_{}_{}", fields.len(), label(text));
                    field.texts = texts
                        .iter()
                        .map(|text| (text.clone(), literal(text)))
                        .collect();
                    let mut literals: Vec<&str> =
                        field.texts.iter().map(|(_, it)| it.as_str()).collect();
                    let other = format!("OTHER_TEXT_{number}_{}", fields.len());
                    literals.push(&other);
                    self.glue.declare(
                        "texts of a field, as far as they make a difference",
                        format!(
                            "enum domain {} = {{{}}}",
                            field.domain,
                            literals.join(" | ")
                        ),
                    );
                }
            }
            fields.insert(input.field.clone(), field);
        }
        Ok(fields)
    }
}

/// A rule from `least` to `most` times in sequence.
fn repeated(rule: &str, least: u32, most: u32) -> String {
    let mut rules = vec![rule.to_owned(); least as usize];
    let more = (least..most).fold(None, |inner: Option<String>, _| {
        let rules: Vec<String> = std::iter::once(rule.to_owned()).chain(inner).collect();
        Some(format!(
            "choose $steps in Boolean do if $steps then {} endif",
            sequence(&rules)
        ))
    });
    rules.extend(more);
    sequence(&rules)
}
