//! The specification of a component together with its environment in a composite.

use crate::actor::{Actor, InputOrigin, OutputEffect, ReadFiles, read};
use crate::bound::BindingReader;
use crate::currency::Currency;
use crate::environment::{EnvironmentWriter, MAX_WAITING, senders};
use crate::error::ModelError;
use crate::glue::Glue;
use crate::merge::merge;
use crate::network::providers;
use crate::origin::ValueOrigin;
use crate::protocol::{ComponentNames, ends};
use asmotion_diagnostics::{Loader, Sources};
use asmotion_lang::hir::ReadOptions;
use asmotion_lang::{MemoryFiles, Specification};
use asmotion_plan::{Component, End, Implementation, Plan};
use std::collections::{BTreeMap, BTreeSet};

/// The composite, and where the protocols of its components come from.
pub struct ModelContext<'a> {
    /// The composite.
    pub plan: &'a Plan,
    /// Reads specifications and protocols.
    pub loader: &'a dyn Loader,
    /// Returns the text of the protocol that comes with a component of the catalogue.
    pub protocols: &'a dyn Fn(&str) -> Option<String>,
    /// Initial state of the specification.
    pub options: ReadOptions,
}

/// The specification of a component together with its environment.
#[derive(Debug)]
pub struct ComponentModel {
    /// Both, as one specification.
    pub specification: Specification,
    /// What the environment consists of.
    pub environment: ModelledEnvironment,
}

/// The environment of a component's specification.
#[derive(Clone, Debug)]
pub struct ModelledEnvironment {
    /// Name of the component.
    pub component: String,
    /// Path of its specification.
    pub file: String,
    /// Text of the environment, for readers.
    pub text: String,
    /// Components whose specification or protocol determines what the component receives, each with the path of it.
    pub others: Vec<(String, String)>,
    /// Components without a protocol, from which anything may come at any time.
    pub open: Vec<String>,
    /// Inputs for which messages may come from outside of the composite at any time.
    pub outside: Vec<String>,
    /// What is assumed beyond the bindings and protocols.
    pub assumptions: Vec<String>,
    /// Functions of other components' specifications: name in the whole, component, and name as declared.
    pub names: BTreeMap<String, (String, String)>,
    /// Functions that the specification itself declares.
    pub functions: BTreeSet<String>,
    /// Inputs of the specification that the environment sets, with their values in a step without a message.
    pub inputs: BTreeMap<String, String>,
    /// Where the values of each input come from.
    pub origins: BTreeMap<String, Vec<ValueOrigin>>,
}

impl ModelledEnvironment {
    /// Returns where a value of an input comes from; empty for the value without a message.
    pub fn origin(&self, input: &str, value: &str) -> Vec<&str> {
        if self.inputs.get(input).is_some_and(|none| none == value) || value == "false" {
            return Vec::new();
        }
        let origins = self.origins.get(input).into_iter().flatten();
        let fits = origins.filter(|it| {
            it.values
                .as_ref()
                .is_none_or(|known| known.iter().any(|it| it == value))
        });
        fits.map(|it| it.from.as_str()).collect()
    }
}

/// Returns the names of the components with a specification.
pub fn specified_components(plan: &Plan) -> Vec<&str> {
    let specified = plan.components.iter().filter(|it| file_of(it).is_some());
    specified.map(|it| it.name.as_str()).collect()
}

fn file_of(component: &Component) -> Option<&str> {
    match &component.implementation {
        Implementation::Asm { file, .. } => Some(file),
        Implementation::Rust(_)
        | Implementation::Builtin { .. }
        | Implementation::Process { .. }
        | Implementation::Ros { .. }
        | Implementation::Orocos { .. } => None,
    }
}

/// Returns the specification of a component together with its environment.
///
/// # Errors
/// A specification or protocol has errors, or the values of an input cannot be listed.
pub fn component_model(
    context: &ModelContext<'_>,
    component: &str,
) -> Result<ComponentModel, ModelError> {
    let plan = context.plan;
    let missing = || ModelError::NoComponent(component.to_owned());
    let planned = plan.component(component).ok_or_else(missing)?;
    let path = file_of(planned).ok_or_else(missing)?;
    let mut sources = Sources::new();
    let mut verified = read(path, context.loader, &mut sources, None)?;
    let reader = BindingReader {
        component,
        files: &verified,
    };
    let (inputs, outputs) = reader.read(&planned.binding.clone().unwrap_or_default())?;
    let first = Actor {
        component: component.to_owned(),
        is_protocol: false,
        trees: Vec::new(),
        main: verified.main.clone(),
        names: BTreeMap::new(),
        functions: std::mem::take(&mut verified.functions),
        inputs,
        outputs,
        echoes: Vec::new(),
        steps: (1, 1),
        texts: Vec::new(),
    };
    let mut finding = ActorSearch {
        context,
        sources,
        actors: vec![first],
        refused: BTreeSet::new(),
        uses_time: uses_time(&verified),
        answers: BTreeMap::new(),
    };
    finding.search(planned)?;
    let ActorSearch {
        sources,
        actors,
        uses_time,
        answers,
        ..
    } = finding;
    let currency = Currency::of(&actors);
    let mut writer = EnvironmentWriter {
        plan,
        actors: &actors,
        answers: &answers,
        glue: Glue::default(),
        notes: BTreeSet::new(),
        currency,
    };
    writer.write()?;
    let origins = writer.origins();
    let (glue, mut notes) = (writer.glue, writer.notes);
    let (mut open, mut outside) = (BTreeSet::new(), BTreeSet::new());
    for input in actors.iter().take(1).flat_map(|it| &it.inputs) {
        for actor in actors.iter().take(1) {
            let from = senders(plan, actor, input);
            let others = from.ends.iter().map(|end| &end.component);
            open.extend(
                others
                    .filter(|it| !actors.iter().any(|known| known.component == **it))
                    .cloned(),
            );
            if from.outside {
                outside.insert(input.location.clone());
            }
        }
    }
    if glue.text("").contains("waiting_") {
        notes.insert(format!("at most {MAX_WAITING} messages wait for an input"));
    }
    if uses_time {
        notes.insert("a timer of TimeLibrary may have expired in any step".to_owned());
    }
    let comment = format!(
        "The environment of {component} in {}: what its inputs can be, after each of its steps.",
        plan.name
    );
    let raw = glue.text(&comment);
    let text = asmotion_lang::syntax::format(Default::default(), &raw).unwrap_or(raw);
    let mut environment = text.clone();
    let mut others = Vec::new();
    let mut names = BTreeMap::new();
    for actor in actors.iter().skip(1) {
        for (path, text) in &actor.texts {
            environment.push_str(&format!("\n// ---- {}: {path}\n{text}", actor.component));
        }
        let path = actor.texts.last().map(|(path, _)| path.clone());
        others.push((actor.component.clone(), path.unwrap_or_default()));
        names.extend(
            actor.names.iter().map(|(declared, name)| {
                (name.clone(), (actor.component.clone(), declared.clone()))
            }),
        );
    }
    let mut inputs = BTreeMap::new();
    let mut functions = BTreeSet::new();
    for actor in actors.iter().take(1) {
        functions.extend(actor.functions.keys().cloned());
        let set = actor
            .inputs
            .iter()
            .filter(|it| glue.controlled.contains(&it.function));
        inputs.extend(set.map(|it| {
            let none = it.none.clone().unwrap_or_else(|| {
                let none = if it.codomain.is_boolean() {
                    "false"
                } else {
                    "undef"
                };
                none.to_owned()
            });
            (it.location.clone(), none)
        }));
    }
    let environment = ModelledEnvironment {
        component: component.to_owned(),
        file: path.to_owned(),
        text: environment,
        others,
        open: open.into_iter().collect(),
        outside: outside.into_iter().collect(),
        assumptions: notes.into_iter().collect(),
        names,
        functions,
        inputs,
        origins,
    };
    let specification = merge(
        verified,
        actors,
        &glue,
        &text,
        uses_time,
        sources,
        &context.options,
    )?;
    Ok(ComponentModel {
        specification,
        environment,
    })
}

fn uses_time(files: &ReadFiles) -> bool {
    files
        .loaded
        .units
        .iter()
        .any(|it| it.path == "<TimeLibrary>")
}

/// Finds the components that determine what the first one receives.
struct ActorSearch<'a> {
    context: &'a ModelContext<'a>,
    sources: Sources,
    actors: Vec<Actor>,
    /// Components without a specification or protocol.
    refused: BTreeSet<String>,
    uses_time: bool,
    answers: BTreeMap<(String, String, String), Vec<String>>,
}

impl ActorSearch<'_> {
    fn search(&mut self, verified: &Component) -> Result<(), ModelError> {
        let plan = self.context.plan;
        let mut at = 0;
        while let Some(actor) = self.actors.get(at) {
            let mut wanted: Vec<String> = Vec::new();
            let mut called: Vec<End> = Vec::new();
            for input in &actor.inputs {
                let from = senders(plan, actor, input);
                // a component without a protocol makes the others irrelevant
                let is_open = from.outside
                    || from
                        .ends
                        .iter()
                        .any(|it| !self.has_behaviour(&it.component));
                let alone = actor
                    .inputs
                    .iter()
                    .filter(|it| it.origin == input.origin)
                    .count()
                    == 1;
                if is_open && alone && at == 0 {
                    continue;
                }
                wanted.extend(from.ends.into_iter().map(|end| end.component));
            }
            for output in &actor.outputs {
                if let OutputEffect::Cases(cases) = &output.effect {
                    let actions = cases.iter().flat_map(|(_, actions)| actions);
                    for action in actions {
                        if let asmotion_coordinator::Action::Call(call) = action {
                            called.push(End {
                                component: actor.component.clone(),
                                name: call.operation.service.clone(),
                            });
                        }
                    }
                }
            }
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

    fn has_behaviour(&self, component: &str) -> bool {
        let planned = self.context.plan.component(component);
        planned.is_some_and(|it| file_of(it).is_some() || self.protocol(it).is_some())
    }

    /// The path or text of a component's protocol.
    fn protocol(&self, component: &Component) -> Option<ProtocolText> {
        if let Some(path) = &component.special.protocol {
            return Some(ProtocolText::File(path.clone()));
        }
        if let Implementation::Rust(name) = &component.implementation {
            let text = (self.context.protocols)(name)?;
            return Some(ProtocolText::Embedded(format!("{name}/protocol.asm"), text));
        }
        None
    }

    fn read_protocol(
        &mut self,
        component: &str,
        protocol: &ProtocolText,
    ) -> Result<ReadFiles, ModelError> {
        match protocol {
            ProtocolText::File(path) => read(
                path,
                self.context.loader,
                &mut self.sources,
                Some(component),
            ),
            ProtocolText::Embedded(path, text) => {
                let mut files = MemoryFiles::new();
                files.add(path, text.clone());
                read(path, &files, &mut self.sources, Some(component))
            }
        }
    }

    fn add(&mut self, component: &str, verified: &Component) -> Result<(), ModelError> {
        let is_known = self.actors.iter().any(|it| it.component == component);
        if is_known || self.refused.contains(component) {
            return Ok(());
        }
        let Some(planned) = self.context.plan.component(component) else {
            return Ok(());
        };
        let protocol = self.protocol(planned);
        let (files, is_protocol) = match (&protocol, file_of(planned)) {
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

enum ProtocolText {
    File(String),
    Embedded(String, String),
}

/// The names that a protocol can use.
pub(crate) fn names_of(component: &Component) -> ComponentNames {
    let ports = |ports: &[asmotion_plan::Port]| ports.iter().map(|it| it.name.clone()).collect();
    let services = |all: &[asmotion_plan::Service]| all.iter().map(|it| it.name.clone()).collect();
    ComponentNames {
        inputs: ports(&component.inputs),
        outputs: ports(&component.outputs),
        services: services(&component.services),
        references: services(&component.references),
    }
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
