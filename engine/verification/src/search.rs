//! The components that determine what the inputs of a specification can be.

use crate::actor::{Actor, InputOrigin, OutputEffect, ReadFiles, covers, read};
use crate::bound::BindingReader;
use crate::context::ModelContext;
use crate::environment::{senders, senders_of};
use crate::error::ModelError;
use crate::network::{Senders, providers};
use crate::own_messages::OwnMessages;
use crate::protocol::ends;
use crate::protocol_text::{ProtocolText, names_of, protocol_of, specification_of};
use asmotion_coordinator::Action;
use asmotion_diagnostics::Sources;
use asmotion_plan::{Component, End, Plan};
use std::collections::{BTreeMap, BTreeSet};

/// Finds the components that determine what the first one receives.
pub(crate) struct ActorSearch<'a> {
    pub context: &'a ModelContext<'a>,
    pub sources: Sources,
    pub actors: Vec<Actor>,
    /// Components without a specification or protocol.
    pub refused: BTreeSet<String>,
    pub uses_time: bool,
    /// Components with a protocol of the catalogue that no message of a modelled component reaches. What they send does not depend
    /// on the verified specification, so anything may come from them, at the cost of fewer states.
    pub independent: BTreeSet<String>,
    /// Whether a specification or protocol says what is sent through a port or a reference.
    pub covered: BTreeMap<End, bool>,
    pub answers: BTreeMap<(String, String, String), Vec<String>>,
}

impl ActorSearch<'_> {
    /// Finds them, beginning with the verified component.
    pub fn search(&mut self, verified: &Component) -> Result<(), ModelError> {
        let plan = self.context.plan;
        self.find_independent()?;
        let mut at = 0;
        while at < self.actors.len() {
            let mut wanted: Vec<String> = Vec::new();
            let received = self
                .actors
                .get(at)
                .map_or_else(Vec::new, |it| received(plan, it));
            for (from, alone) in received {
                // a component without a protocol makes the others irrelevant
                let mut is_open = from.outside;
                for end in &from.ends {
                    is_open |= !self.covers(end)?;
                }
                if is_open && alone && at == 0 {
                    continue;
                }
                wanted.extend(from.ends.into_iter().map(|end| end.component));
            }
            let called = self.actors.get(at).map_or_else(Vec::new, called);
            for component in wanted {
                self.add(&component, verified)?;
            }
            for reference in called {
                for provider in providers(plan, &reference).ends {
                    self.note_answers(&provider)?;
                }
            }
            at += 1;
        }
        self.order();
        Ok(())
    }

    /// Finds the components of the catalogue that no message of a specification, or of a protocol that the composite names, reaches
    /// through other protocols.
    fn find_independent(&mut self) -> Result<(), ModelError> {
        let plan = self.context.plan;
        let mut unreached: Vec<(String, Vec<Senders>)> = Vec::new();
        for component in &plan.components {
            let Some(protocol) = self.protocol(component) else {
                continue;
            };
            if !protocol.is_of_catalogue() {
                continue;
            }
            let files = self.read_protocol(&component.name, &protocol)?;
            let found = ends(&component.name, &names_of(component), &files)?;
            let inputs = found.inputs.iter();
            let senders = inputs.map(|it| senders_of(plan, &component.name, &it.origin));
            unreached.push((component.name.clone(), senders.collect()));
        }
        loop {
            let names: BTreeSet<String> = unreached.iter().map(|(name, _)| name.clone()).collect();
            let mut rest = Vec::new();
            for (component, senders) in unreached {
                let mut is_reached = false;
                for end in senders.iter().flat_map(|it| &it.ends) {
                    is_reached |= !names.contains(&end.component) && self.covers(end)?;
                }
                if !is_reached {
                    rest.push((component, senders));
                }
            }
            if rest.len() == names.len() {
                self.independent = names;
                return Ok(());
            }
            unreached = rest;
        }
    }

    /// Puts components that send before those that receive from them, as far as possible, so that a message can pass several
    /// components between two steps.
    fn order(&mut self) {
        let mut rest: Vec<Actor> = self.actors.drain(1.min(self.actors.len())..).collect();
        while !rest.is_empty() {
            let sends_to = |from: &Actor, to: &Actor| {
                let mut inputs = to.inputs.iter();
                inputs.any(|input| {
                    let senders = senders(self.context.plan, to, input);
                    senders
                        .ends
                        .iter()
                        .any(|end| end.component == from.component)
                })
            };
            let is_first = |at: &usize| {
                let to = rest.get(*at);
                let others = rest.iter().enumerate().filter(|(other, _)| other != at);
                to.is_some_and(|to| !others.into_iter().any(|(_, from)| sends_to(from, to)))
            };
            let first = (0..rest.len()).find(is_first).unwrap_or(0);
            self.actors.push(rest.remove(first));
        }
    }

    /// Returns `true` if the specification or protocol of a component says what it sends through a port or a reference.
    fn covers(&mut self, end: &End) -> Result<bool, ModelError> {
        if self.independent.contains(&end.component) {
            return Ok(false);
        }
        if let Some(known) = self.covered.get(end) {
            return Ok(*known);
        }
        let Some(planned) = self.context.plan.component(&end.component) else {
            return Ok(false);
        };
        let is_covered = match self.protocol(planned) {
            Some(protocol) => {
                let files = self.read_protocol(&end.component, &protocol)?;
                let found = ends(&end.component, &names_of(planned), &files)?;
                covers(&found.outputs, &end.name)
            }
            None => specification_of(planned).is_some(),
        };
        self.covered.insert(end.clone(), is_covered);
        Ok(is_covered)
    }

    /// The path or text of a component's protocol.
    fn protocol(&self, component: &Component) -> Option<ProtocolText> {
        protocol_of(component, self.context.protocols)
    }

    fn read_protocol(
        &mut self,
        component: &str,
        protocol: &ProtocolText,
    ) -> Result<ReadFiles, ModelError> {
        let (path, files) = protocol.files(self.context.loader);
        read(&path, &files, &mut self.sources, Some(component))
    }

    fn add(&mut self, component: &str, verified: &Component) -> Result<(), ModelError> {
        let is_known = self.actors.iter().any(|it| it.component == component)
            || self.independent.contains(component);
        if is_known || self.refused.contains(component) {
            return Ok(());
        }
        let Some(planned) = self.context.plan.component(component) else {
            return Ok(());
        };
        let protocol = self.protocol(planned);
        let (files, is_protocol) = match (&protocol, specification_of(planned)) {
            (Some(protocol), _) => (self.read_protocol(component, protocol)?, true),
            (None, Some(path)) => {
                let files = read(
                    path,
                    self.context.loader,
                    &mut self.sources,
                    Some(component),
                )?;
                (files, false)
            }
            (None, None) => {
                self.refused.insert(component.to_owned());
                return Ok(());
            }
        };
        self.uses_time |= uses_time(&files);
        let (inputs, outputs, echoes) = if is_protocol {
            let found = ends(component, &names_of(planned), &files)?;
            (found.inputs, found.outputs, found.echoes)
        } else {
            let reader = BindingReader {
                component,
                files: &files,
            };
            let (inputs, outputs) = reader.read(&planned.binding.clone().unwrap_or_default())?;
            (inputs, outputs, Vec::new())
        };
        let binding = planned.binding.as_deref().filter(|_| is_protocol);
        let own_messages = binding.map(OwnMessages::of).unwrap_or_default();
        self.actors.push(Actor {
            component: component.to_owned(),
            is_protocol,
            trees: files.trees,
            main: files.main,
            names: files.names,
            functions: files.functions,
            inputs,
            outputs,
            echoes,
            own_messages,
            steps: steps(verified, planned),
            texts: files.texts,
        });
        Ok(())
    }

    /// Notes the answers that the protocol of a service provider allows.
    fn note_answers(&mut self, provider: &End) -> Result<(), ModelError> {
        let Some(planned) = self.context.plan.component(&provider.component) else {
            return Ok(());
        };
        let Some(protocol) = self.protocol(planned) else {
            return Ok(());
        };
        let files = self.read_protocol(&provider.component, &protocol)?;
        let found = ends(&provider.component, &names_of(planned), &files)?;
        for output in &found.outputs {
            let OutputEffect::Reply { service, operation } = &output.effect else {
                continue;
            };
            let Some(elements) = &output.codomain.elements else {
                continue;
            };
            let answers = elements.iter().map(|it| it.declared.clone()).collect();
            let key = (
                provider.component.clone(),
                service.clone(),
                operation.clone(),
            );
            self.answers.insert(key, answers);
        }
        // a protocol of the inputs only says nothing about answers
        debug_assert!(
            found
                .inputs
                .iter()
                .all(|it| it.origin != InputOrigin::Calls)
        );
        Ok(())
    }
}

/// The senders of each input, and whether no other input reads the same messages.
fn received(plan: &Plan, actor: &Actor) -> Vec<(Senders, bool)> {
    let inputs = actor.inputs.iter();
    let received = inputs.map(|input| {
        let same = actor.inputs.iter().filter(|it| it.origin == input.origin);
        (senders(plan, actor, input), same.count() == 1)
    });
    received.collect()
}

/// The references through which an actor calls.
fn called(actor: &Actor) -> Vec<End> {
    let mut called = Vec::new();
    for output in &actor.outputs {
        let OutputEffect::Cases(cases) = &output.effect else {
            continue;
        };
        for action in cases.iter().flat_map(|(_, actions)| actions) {
            if let Action::Call(call) = action {
                called.push(End {
                    component: actor.component.clone(),
                    name: call.operation.service.clone(),
                });
            }
        }
    }
    called
}

/// The least and the greatest number of steps of a component between two steps of another one.
fn steps(verified: &Component, other: &Component) -> (u32, u32) {
    let period = |component: &Component| component.pace.period_ms;
    let (own, of_other) = (period(verified), period(other));
    if own == 0 || of_other == 0 || of_other > own {
        return (0, 1);
    }
    let most = own.div_ceil(of_other).min(MAX_STEPS);
    let least = (own / of_other).min(MAX_STEPS);
    (
        u32::try_from(least).unwrap_or(1),
        u32::try_from(most).unwrap_or(1),
    )
}

/// Limit for the steps of a component between two steps of the verified one.
const MAX_STEPS: u64 = 4;

/// Returns `true` if a specification imports the library of timers.
pub(crate) fn uses_time(files: &ReadFiles) -> bool {
    files
        .loaded
        .units
        .iter()
        .any(|it| it.path == "<TimeLibrary>")
}
