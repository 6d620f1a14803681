//! The environment of a component's specification: what its inputs can be, according to the bindings of the composite and the
//! specifications and protocols of the other components.
//!
//! A step of the whole is a step of the verified specification, and then: its messages and calls take effect, the other
//! components make their steps, and the inputs of the next step are determined.

use crate::actor::{
    Actor, ActorInput, ActorOutput, InputOrigin, OutputEffect, qualified_word, word,
};
use crate::currency::Currency;
use crate::error::ModelError;
use crate::glue::{Glue, parameters, sequence};
use crate::message::{FieldVariable, SentMessage, TakenValue};
use crate::network::{Senders, callers, providers, writers};
use crate::origin::ValueOrigin;
use crate::rename::label;
use asmotion_coordinator::{Action, Call, PublishWhen, Receive};
use asmotion_plan::{End, Plan};
use std::collections::{BTreeMap, BTreeSet};

/// Number of messages that can wait for an input.
pub(crate) const MAX_WAITING: usize = 2;

/// Writes the environment of the first of several actors.
pub(crate) struct EnvironmentWriter<'a> {
    pub plan: &'a Plan,
    pub actors: &'a [Actor],
    /// Answers that the protocols of service providers allow, by component, service and operation.
    pub answers: &'a BTreeMap<(String, String, String), Vec<String>>,
    pub glue: Glue,
    /// What the environment assumes beyond the bindings.
    pub notes: BTreeSet<String>,
    pub currency: Currency,
}

/// A call that a location of an out function makes.
struct LocationCall<'a> {
    /// Literal of the call's state.
    state: String,
    call: &'a Call,
}

impl<'a> EnvironmentWriter<'a> {
    /// Writes the whole environment.
    ///
    /// # Errors
    /// The values of an input cannot be listed.
    pub fn write(&mut self) -> Result<(), ModelError> {
        let mut phases = Vec::new();
        for at in 0..self.actors.len() {
            self.declare_inputs(at);
        }
        self.declare_currency();
        for (at, actor) in self.actors.iter().enumerate() {
            let effects = self.effects(at)?;
            if at == 0 {
                phases.extend(self.named(actor, "effects", "effects of its last step", &effects));
                continue;
            }
            let receive = self.receive(at)?;
            phases.push(self.steps(at, &receive, &effects)?);
        }
        phases.extend(self.external_deliveries()?);
        let first = self.actors.first();
        if let Some(actor) = first {
            let receive = self.receive(0)?;
            phases.extend(self.named(actor, "receive", "inputs of its next step", &receive));
        }
        self.glue.rule(
            "all that happens between two steps",
            "r_environment",
            &sequence(&phases),
        );
        Ok(())
    }

    /// Adds a rule of an actor, and returns a call of it.
    fn named(
        &mut self,
        actor: &Actor,
        what: &str,
        comment: &str,
        body: &[String],
    ) -> Option<String> {
        if body.is_empty() {
            return None;
        }
        let name = format!("r_{what}_{}", label(&actor.component));
        let comment = format!("{}: {comment}", actor.component);
        self.glue.rule(&comment, &name, &sequence(body));
        Some(format!("{name}[]"))
    }

    fn actor(&self, at: usize) -> Option<&'a Actor> {
        self.actors.get(at)
    }

    /// The senders of an input's messages.
    fn senders(&self, at: usize, input: &ActorInput) -> Senders {
        let Some(actor) = self.actor(at) else {
            return Senders::default();
        };
        senders(self.plan, actor, input)
    }

    /// Returns `true` if messages for an input can come from components that have no protocol, or from outside.
    fn is_open(&self, at: usize, input: &ActorInput) -> bool {
        let senders = self.senders(at, input);
        let is_actor = |end: &End| self.actors.iter().any(|it| it.component == end.component);
        senders.outside || senders.ends.iter().any(|end| !is_actor(end))
    }

    /// Returns `true` if the environment sets an input of the verified specification; otherwise it has any value.
    fn is_set(&self, at: usize, function: &str) -> bool {
        at > 0 || self.glue.controlled.contains(function)
    }

    /// Declares what the environment remembers for the inputs of an actor.
    fn declare_inputs(&mut self, at: usize) {
        let Some(actor) = self.actor(at) else { return };
        self.glue.heading(&format!("inputs of {}", actor.component));
        let functions: BTreeSet<&String> = actor
            .functions
            .iter()
            .filter(|(_, facts)| facts.kind == asmotion_lang::syntax::ast::FunctionKind::Monitored)
            .map(|(name, _)| name)
            .collect();
        for function in functions {
            let bound = || actor.inputs.iter().filter(|it| it.function == *function);
            let facts = actor.functions.get(function);
            let locations = facts.map_or(Some(0), |facts| {
                let counts = facts.elements.iter();
                counts
                    .map(|it| it.as_ref().map(Vec::len))
                    .product::<Option<usize>>()
            });
            let is_complete = locations.is_some_and(|count| bound().count() == count);
            if let ([only], 0) = (bound().collect::<Vec<_>>().as_slice(), at)
                && let InputOrigin::Value(value) = &only.origin
                && only.location == *function
            {
                self.glue.fixed.insert(function.clone());
                self.glue.define(format!("function {function} = {value}"));
                continue;
            }
            let is_free = at == 0 && is_complete && bound().all(|it| self.can_be_free(actor, it));
            if !is_free {
                self.glue.controlled.insert(function.clone());
            }
        }
        for input in &actor.inputs {
            if self.is_set(at, &input.function) {
                self.declare_input(actor, input);
            }
        }
    }

    /// Returns `true` if an input can have any value in any step, whatever happened before.
    fn can_be_free(&self, actor: &Actor, input: &ActorInput) -> bool {
        if let InputOrigin::Losses = input.origin {
            return input.codomain.is_boolean();
        }
        let alone = actor
            .inputs
            .iter()
            .filter(|it| it.origin == input.origin)
            .count()
            == 1;
        let has_port = match &input.origin {
            InputOrigin::Port(_) | InputOrigin::Request { .. } => true,
            InputOrigin::Calls
            | InputOrigin::Timer(_)
            | InputOrigin::Losses
            | InputOrigin::Value(_) => false,
        };
        let is_defined = input.receive == Receive::Edge
            || input.none.is_some() && input.stale.as_deref() != Some("undef");
        let takes_outcomes = outputs_with_calls(actor).any(|(_, call)| {
            call.event
                .as_deref()
                .is_some_and(|it| is_location(actor, it, input))
        });
        has_port
            && alone
            && is_defined
            && input.key.is_empty()
            && !takes_outcomes
            && self.is_open(0, input)
    }

    fn declare_input(&mut self, actor: &Actor, input: &ActorInput) {
        let word = word(actor, input);
        let none = input.none.as_deref();
        match (&input.origin, input.receive) {
            (InputOrigin::Value(value), _) => self.start(actor, input, value),
            (InputOrigin::Timer(_), _) => self.start(actor, input, "false"),
            (InputOrigin::Losses, _) => {
                let value = if input.codomain.is_boolean() {
                    "false"
                } else {
                    "0"
                };
                self.start(actor, input, value);
            }
            (_, Receive::Edge) => {
                let text = format!("controlled arrived_{word}: Boolean");
                self.glue.declare(
                    &format!("a message for `{}` has arrived", input.location),
                    text,
                );
                self.glue.start(&format!("arrived_{word}"), "false");
                self.start(actor, input, "false");
            }
            (_, Receive::Last) => {
                let value = input.stale.as_deref().or(none);
                if let Some(value) = value.filter(|it| *it != "undef") {
                    self.start(actor, input, value);
                }
            }
            (origin, Receive::All) => {
                if *origin != InputOrigin::Calls {
                    let text = format!("controlled waiting_{word}: Seq({})", input.codomain.text);
                    self.glue.declare(
                        &format!("messages that wait for `{}`", input.location),
                        text,
                    );
                    self.glue.start(&format!("waiting_{word}"), "[]");
                }
                if let Some(value) = none {
                    self.start(actor, input, value);
                }
            }
        }
    }

    /// Sets the initial value of an input.
    fn start(&mut self, actor: &Actor, input: &ActorInput, value: &str) {
        let facts = actor.functions.get(&input.function);
        let domain = facts.map_or("", |it| it.domain.as_str());
        self.glue
            .start_at(&input.function, domain, &input.location, value);
    }

    // ---- what an actor receives ----------------------------------------------------------------

    /// The rules that determine the inputs of the next step of an actor.
    fn receive(&mut self, at: usize) -> Result<Vec<String>, ModelError> {
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
        let pop = format!(
            "par {x} := first(waiting_{word}) waiting_{word} := tail(waiting_{word}) endpar"
        );
        let mut sources = Vec::new();
        for output in &actor.outputs {
            let calls = calls(actor, output);
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
                sources.push((call_state(actor, output), cases));
            }
        }
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
        for (number, (state, cases)) in sources.iter().enumerate() {
            let literal = format!("OUTCOME_{number}_FOR_{word}");
            let called: Vec<String> = cases
                .iter()
                .map(|(it, _)| format!("{state} = {it}"))
                .collect();
            guards.push(format!("($from = {literal} and ({}))", called.join(" or ")));
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

    /// The literals with which a call can end; `None` for an end without an event.
    fn outcomes(&self, actor: &Actor, call: &Call) -> BTreeSet<Option<String>> {
        let reference = End {
            component: actor.component.clone(),
            name: call.operation.service.clone(),
        };
        let providers = providers(self.plan, &reference);
        let mut ends = BTreeSet::new();
        let is_open = providers.outside || providers.ends.is_empty();
        let mut any_fault = is_open;
        let mut replies = is_open;
        for end in &providers.ends {
            let key = (
                end.component.clone(),
                end.name.clone(),
                call.operation.operation.clone(),
            );
            match self.answers.get(&key) {
                None => (any_fault, replies) = (true, true),
                Some(answers) => {
                    for answer in answers {
                        if answer == "OK" {
                            replies = true;
                            continue;
                        }
                        let named = call.faults.iter().find(|(code, _)| code == answer);
                        ends.insert(
                            named
                                .map(|(_, it)| it.clone())
                                .or_else(|| call.failed.clone()),
                        );
                    }
                }
            }
        }
        if any_fault {
            ends.extend(call.faults.iter().map(|(_, literal)| Some(literal.clone())));
            ends.insert(call.failed.clone());
        }
        if replies {
            ends.insert(call.ok.clone());
        }
        ends.insert(call.timeout.clone().or_else(|| call.failed.clone()));
        ends.insert(call.unavailable.clone().or_else(|| call.failed.clone()));
        ends
    }

    // ---- what an actor sends -------------------------------------------------------------------

    /// The rules for the effects of an actor's last step.
    fn effects(&mut self, at: usize) -> Result<Vec<String>, ModelError> {
        let Some(actor) = self.actor(at) else {
            return Ok(Vec::new());
        };
        let mut rules = Vec::new();
        if at == 0 {
            let calling = actor
                .outputs
                .iter()
                .filter(|output| !calls(actor, output).is_empty());
            rules.extend(
                calling.map(|output| format!("renewed_{} := false", call_state(actor, output))),
            );
        }
        for output in &actor.outputs {
            let (function, x) = (&output.function, &output.location);
            let arguments = x.strip_prefix(function.as_str()).unwrap_or_default();
            let given = format!("given_{function}{arguments}");
            let mut when = PublishWhen::OnUpdate;
            let effect = match &output.effect {
                OutputEffect::Publish {
                    port,
                    field,
                    key,
                    when: at_steps,
                } => {
                    when = *at_steps;
                    let message = SentMessage::Value {
                        is_complete: !actor.is_protocol,
                        field: field.as_deref(),
                        term: x,
                        codomain: &output.codomain,
                        key,
                    };
                    self.publish(at, port, &message)?
                }
                OutputEffect::Send {
                    reference,
                    operation,
                    field,
                } => {
                    let message = SentMessage::Value {
                        is_complete: !actor.is_protocol,
                        field: field.as_deref(),
                        term: x,
                        codomain: &output.codomain,
                        key: &[],
                    };
                    self.request(at, reference, operation, &message)?
                }
                OutputEffect::Reply { .. } => Vec::new(),
                OutputEffect::Cases(cases) => self.cases(at, actor, output, cases)?,
            };
            if effect.is_empty() {
                continue;
            }
            if when == PublishWhen::EveryStep {
                rules.extend(effect);
                continue;
            }
            self.declare_given(actor, output, when == PublishWhen::OnChange);
            let mut given_effects = vec![format!("{given} := false")];
            given_effects.extend(effect);
            rules.push(format!(
                "if {given} then {} endif",
                sequence(&given_effects)
            ));
        }
        for output in &actor.outputs {
            rules.extend(self.silent_ends(actor, output));
        }
        Ok(rules)
    }

    /// Declares that updates of an out function are noted.
    fn declare_given(&mut self, actor: &Actor, output: &ActorOutput, only_changes: bool) {
        let function = &output.function;
        let known = self.glue.given.get(function).copied();
        self.glue
            .given
            .insert(function.clone(), known.unwrap_or(true) && only_changes);
        if known.is_some() {
            return;
        }
        let domain = actor
            .functions
            .get(function)
            .map_or("", |it| it.domain.as_str());
        let (arrow, parameters) = match domain {
            "" => (String::new(), String::new()),
            domain => (format!("{domain} -> "), parameters(domain)),
        };
        self.glue.declare(
            &format!("the last step of {} updated `{function}`", actor.component),
            format!("controlled given_{function}: {arrow}Boolean"),
        );
        self.glue
            .start(&format!("given_{function}{parameters}"), "false");
    }

    /// The effects of the literals of an out function.
    fn cases(
        &mut self,
        at: usize,
        actor: &Actor,
        output: &ActorOutput,
        cases: &[(crate::actor::ElementName, Vec<Action>)],
    ) -> Result<Vec<String>, ModelError> {
        let calls = calls(actor, output);
        let mut rules = Vec::new();
        if !calls.is_empty() {
            let state = call_state(actor, output);
            let mut literals = vec![format!("NO_{}", state.to_uppercase())];
            literals.extend(calls.iter().map(|it| it.state.clone()));
            self.glue.declare(
                &format!(
                    "the call that `{}` of {} makes",
                    output.location, actor.component
                ),
                format!("enum domain Calls_{state} = {{{}}}", literals.join(" | ")),
            );
            self.glue
                .declare("", format!("controlled {state}: Calls_{state}"));
            self.glue
                .start(&state, &format!("NO_{}", state.to_uppercase()));
            // a later update cancels the call
            rules.push(format!("{state} := NO_{}", state.to_uppercase()));
            if at == 0 {
                self.glue
                    .declare("", format!("controlled renewed_{state}: Boolean"));
                self.glue.start(&format!("renewed_{state}"), "false");
                self.glue.justice(
                    "a call ends, by an answer or by its timeout, unless another one takes its place",
                    &format!("{state} = NO_{} or renewed_{state}", state.to_uppercase()),
                );
            }
        }
        let mut branches = Vec::new();
        for (literal, actions) in cases {
            let mut effects = Vec::new();
            for action in actions {
                match action {
                    Action::Call(call) => {
                        let made = calls.iter().find(|it| std::ptr::eq(it.call, call));
                        if let Some(made) = made {
                            let state = call_state(actor, output);
                            effects.push(format!("{state} := {}", made.state));
                            if at == 0 {
                                effects.push(format!("renewed_{state} := true"));
                            }
                        }
                        let message = SentMessage::Built(&call.with);
                        let operation = &call.operation;
                        effects.extend(self.request(
                            at,
                            &operation.service,
                            &operation.operation,
                            &message,
                        )?);
                    }
                    Action::Publish { port, value } => {
                        effects.extend(self.publish(at, port, &SentMessage::Built(value))?);
                    }
                }
            }
            if !effects.is_empty() {
                branches.push(format!("case {}: {}", literal.name, sequence(&effects)));
            }
        }
        if !branches.is_empty() {
            let x = &output.location;
            rules.push(format!("switch {x} {} endswitch", branches.join("\n")));
        }
        Ok(rules)
    }

    /// A rule for calls that can end without an event.
    fn silent_ends(&self, actor: &Actor, output: &ActorOutput) -> Option<String> {
        let calls = calls(actor, output);
        let silent = calls
            .iter()
            .filter(|it| it.call.event.is_none() || self.outcomes(actor, it.call).contains(&None));
        let state = call_state(actor, output);
        let silent: Vec<String> = silent.map(|it| format!("{state} = {}", it.state)).collect();
        if silent.is_empty() {
            return None;
        }
        Some(format!(
            "if {} then choose $ends in Boolean do if $ends then {state} := NO_{} endif endif",
            silent.join(" or "),
            state.to_uppercase()
        ))
    }

    /// The rules for a message on an output port.
    fn publish(
        &mut self,
        at: usize,
        port: &str,
        message: &SentMessage<'_>,
    ) -> Result<Vec<String>, ModelError> {
        let Some(actor) = self.actor(at) else {
            return Ok(Vec::new());
        };
        let end = End {
            component: actor.component.clone(),
            name: port.to_owned(),
        };
        let mut rules = Vec::new();
        if at == 0 {
            rules.extend(self.currency.forget(port, actor));
        }
        for (to, receiver) in self.actors.iter().enumerate() {
            let mut marked = BTreeSet::new();
            for input in &receiver.inputs {
                let InputOrigin::Port(name) = &input.origin else {
                    continue;
                };
                if !self.is_set(to, &input.function) || !self.senders(to, input).ends.contains(&end)
                {
                    continue;
                }
                if marked.insert(name.clone()) {
                    rules.extend(self.currency.pass_on(actor, at, port, receiver, name));
                }
                rules.extend(self.deliver(to, receiver, input, message, Some((actor, port)))?);
            }
        }
        Ok(rules)
    }

    /// The rules for a request.
    fn request(
        &mut self,
        at: usize,
        reference: &str,
        operation: &str,
        message: &SentMessage<'_>,
    ) -> Result<Vec<String>, ModelError> {
        let Some(actor) = self.actor(at) else {
            return Ok(Vec::new());
        };
        let end = End {
            component: actor.component.clone(),
            name: reference.to_owned(),
        };
        let mut rules = Vec::new();
        for (to, receiver) in self.actors.iter().enumerate() {
            for input in &receiver.inputs {
                let InputOrigin::Request {
                    operation: requested,
                    ..
                } = &input.origin
                else {
                    continue;
                };
                let is_it = requested == operation && self.senders(to, input).ends.contains(&end);
                if is_it && self.is_set(to, &input.function) {
                    rules.extend(self.deliver(
                        to,
                        receiver,
                        input,
                        message,
                        Some((actor, reference)),
                    )?);
                }
            }
        }
        Ok(rules)
    }

    /// The rule that hands a message to an input; `None` if it cannot be for it.
    fn deliver(
        &self,
        to: usize,
        receiver: &Actor,
        input: &ActorInput,
        message: &SentMessage<'_>,
        from: Option<(&Actor, &str)>,
    ) -> Result<Option<String>, ModelError> {
        let selected = message.selects(input);
        if selected == Some(false) {
            return Ok(None);
        }
        let word = word(receiver, input);
        let needs_value = input.receive != Receive::Edge || !input.is.is_empty();
        let (value, misfits, choice) = match message.value(input) {
            TakenValue::Term(text, misfits) => (text, misfits, None),
            TakenValue::Unknown if needs_value => {
                let domain = self.listed(receiver, input)?;
                ("$unknown".to_owned(), false, Some(domain))
            }
            TakenValue::Unknown => ("true".to_owned(), false, None),
        };
        let mut rule = match input.receive {
            Receive::Edge if needs_value => format!("if {value} then arrived_{word} := true endif"),
            Receive::Edge => format!("arrived_{word} := true"),
            Receive::Last => format!("{} := {value}", input.location),
            Receive::All => format!(
                "if length(waiting_{word}) < {MAX_WAITING} then waiting_{word} := append(waiting_{word}, {value}) endif"
            ),
        };
        if misfits && needs_value {
            rule = format!("if isDef({value}) then {rule} endif");
        }
        if let Some(domain) = choice {
            rule = format!("choose $unknown in {domain} do {rule}");
        }
        let condition = self.currency.condition(to, input, from);
        if let Some(term) = condition.term {
            rule = format!("if {term} then {rule} endif");
        }
        if condition.is_uncertain || selected.is_none() {
            rule = format!("choose $fits in Boolean do if $fits then {rule} endif");
        }
        Ok(Some(rule))
    }

    /// The domain of an input, if its values can be listed.
    fn listed(&self, actor: &Actor, input: &ActorInput) -> Result<String, ModelError> {
        let text = &input.codomain.text;
        let is_listed = input.codomain.is_boolean() || input.codomain.elements.is_some();
        let is_named = text
            .chars()
            .all(|sign| sign.is_alphanumeric() || sign == '_');
        let is_basic =
            ["Integer", "Natural", "Real", "String", "Char", "Complex"].contains(&text.as_str());
        if is_listed || is_named && !is_basic {
            return Ok(text.clone());
        }
        Err(ModelError::Unbounded {
            component: actor.component.clone(),
            input: input.location.clone(),
        })
    }

    // ---- other components, and outside -----------------------------------------------------------

    /// The rule for the steps of an actor between two steps of the verified specification.
    fn steps(
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
            if waits.is_empty() || least > 0 {
                return Ok(cycle);
            }
            // a slower component may not have read its messages yet
            return Ok(format!(
                "if {} then choose $steps in Boolean do if $steps then {cycle} endif else {cycle} endif",
                waits.join(" or ")
            ));
        }
        let mut rules = vec![cycle.clone(); least as usize];
        let more = (least..most).fold(None, |inner: Option<String>, _| {
            let rules: Vec<String> = std::iter::once(cycle.clone()).chain(inner).collect();
            Some(format!(
                "choose $steps in Boolean do if $steps then {} endif",
                sequence(&rules)
            ))
        });
        rules.extend(more);
        Ok(sequence(&rules))
    }

    /// Rules for messages to an actor from components without a protocol.
    fn open_inputs(&mut self, at: usize, actor: &Actor) -> Result<Vec<String>, ModelError> {
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
    fn external_deliveries(&mut self) -> Result<Vec<String>, ModelError> {
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
    fn fields(
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

    /// Where the values of each input of the verified specification come from.
    pub fn origins(&self) -> BTreeMap<String, Vec<ValueOrigin>> {
        let Some(actor) = self.actor(0) else {
            return BTreeMap::new();
        };
        let inputs = actor.inputs.iter();
        inputs
            .map(|input| (input.location.clone(), self.origins_of(actor, input)))
            .collect()
    }

    fn origins_of(&self, actor: &Actor, input: &ActorInput) -> Vec<ValueOrigin> {
        let mut origins = Vec::new();
        let senders = self.senders(0, input);
        let through = match &input.origin {
            InputOrigin::Port(port) => format!("input {port}"),
            InputOrigin::Request { service, operation } => format!("{service}.{operation}"),
            InputOrigin::Timer(condition) => format!("timer: {condition}"),
            InputOrigin::Losses => "lost messages".to_owned(),
            InputOrigin::Calls | InputOrigin::Value(_) => String::new(),
        };
        for end in &senders.ends {
            let sender = self
                .actors
                .iter()
                .skip(1)
                .find(|it| it.component == end.component);
            let outputs = sender.into_iter().flat_map(|it| &it.outputs);
            let sent = outputs.filter(|it| match &it.effect {
                OutputEffect::Publish { port, .. } => *port == end.name,
                OutputEffect::Send { reference, .. } => *reference == end.name,
                OutputEffect::Reply { .. } | OutputEffect::Cases(_) => false,
            });
            let elements = sent.flat_map(|it| it.codomain.elements.iter().flatten());
            let values: Vec<String> = elements
                .filter_map(|it| Some(input.codomain.named(&it.declared)?.name.clone()))
                .collect();
            origins.push(ValueOrigin {
                values: (!values.is_empty()).then_some(values),
                from: end.to_string(),
            });
        }
        if senders.outside {
            origins.push(ValueOrigin {
                values: None,
                from: format!("outside, {through}"),
            });
        }
        if senders.ends.is_empty() && !senders.outside && !through.is_empty() {
            origins.push(ValueOrigin {
                values: None,
                from: through,
            });
        }
        for (_, call) in outputs_with_calls(actor) {
            if call
                .event
                .as_deref()
                .is_some_and(|it| is_location(actor, it, input))
            {
                let outcomes = self.outcomes(actor, call).into_iter().flatten();
                origins.push(ValueOrigin {
                    values: Some(outcomes.collect()),
                    from: format!("call {}", call.operation),
                });
            }
        }
        origins
    }

    fn declare_currency(&mut self) {
        for flag in self.currency.flags() {
            self.glue.declare(
                "the newest message of this input belongs to the last one that was published",
                format!("controlled {flag}: Boolean"),
            );
            self.glue.start(&flag, "false");
        }
    }
}

/// The senders of an input's messages.
pub(crate) fn senders(plan: &Plan, actor: &Actor, input: &ActorInput) -> Senders {
    let end = |name: &str| End {
        component: actor.component.clone(),
        name: name.to_owned(),
    };
    match &input.origin {
        InputOrigin::Port(port) => writers(plan, &end(port)),
        InputOrigin::Request { service, .. } => callers(plan, &end(service)),
        InputOrigin::Calls
        | InputOrigin::Timer(_)
        | InputOrigin::Losses
        | InputOrigin::Value(_) => Senders::default(),
    }
}

/// The function that tells which call an out location has made.
fn call_state(actor: &Actor, output: &ActorOutput) -> String {
    format!("call_{}", qualified_word(actor, &output.word))
}

/// The calls that the literals of an out location make.
fn calls<'a>(actor: &Actor, output: &'a ActorOutput) -> Vec<LocationCall<'a>> {
    let OutputEffect::Cases(cases) = &output.effect else {
        return Vec::new();
    };
    let state = call_state(actor, output).to_uppercase();
    let calls = cases.iter().flat_map(|(literal, actions)| {
        let calls = actions.iter().filter_map(|action| match action {
            Action::Call(call) => Some(call),
            Action::Publish { .. } => None,
        });
        calls
            .enumerate()
            .map(move |(number, call)| (literal, number, call))
    });
    calls
        .map(|(literal, number, call)| LocationCall {
            state: match number {
                0 => format!("{state}_{}", label(&literal.declared)),
                more => format!("{state}_{}_{more}", label(&literal.declared)),
            },
            call,
        })
        .collect()
}

/// The calls of an actor.
fn outputs_with_calls(actor: &Actor) -> impl Iterator<Item = (&ActorOutput, &Call)> {
    actor.outputs.iter().flat_map(|output| {
        let calls = calls(actor, output).into_iter();
        calls.map(move |it| (output, it.call))
    })
}

/// Returns `true` if the name of an event, as written in a binding, is that of an input.
fn is_location(actor: &Actor, event: &str, input: &ActorInput) -> bool {
    let renamed = crate::rename::renamed(event, &actor.names);
    let without_spaces = |text: &str| text.replace(' ', "");
    without_spaces(&renamed) == without_spaces(&input.location)
}
