//! The specification of a component together with its environment in a composite.

use crate::actor::{Actor, ReadFiles, declared_names, read};
use crate::bound::BindingReader;
use crate::canonical::CanonicalNames;
use crate::context::ModelContext;
use crate::currency::Currency;
use crate::environment::{EnvironmentWriter, senders};
use crate::error::ModelError;
use crate::glue::Glue;
use crate::merge::merge;
use crate::origin::ValueOrigin;
use crate::own_messages::OwnMessages;
use crate::protocol_text::specification_of;
use crate::search::{ActorSearch, uses_time};
use asmotion_diagnostics::Sources;
use asmotion_lang::Specification;
use asmotion_plan::{End, Plan};
use std::collections::{BTreeMap, BTreeSet};

/// The specification of a component together with its environment.
#[derive(Debug)]
pub struct ComponentModel {
    /// Both, as one specification.
    pub specification: Specification,
    /// The parts of the environment.
    pub environment: ModelledEnvironment,
}

/// The specification of a component and its environment, not yet put together.
struct ModelParts {
    environment: ModelledEnvironment,
    verified: ReadFiles,
    actors: Vec<Actor>,
    glue: Glue,
    /// Text of the environment without the specifications of other components.
    text: String,
    uses_time: bool,
    sources: Sources,
}

/// The environment of a component's specification.
#[derive(Clone, Debug)]
pub struct ModelledEnvironment {
    /// Name of the component.
    pub component: String,
    /// Path of its specification.
    pub file: String,
    /// Paths of the specification and of the files that it imports, without libraries.
    pub own_files: BTreeSet<String>,
    /// Text of the environment, for readers.
    pub text: String,
    /// Components whose specification or protocol determines what the component receives, each with the path of it.
    pub others: Vec<(String, String)>,
    /// Components without a protocol, and ports that the protocol of their component does not mention: anything may come from
    /// them at any time.
    pub open: Vec<String>,
    /// Components with a protocol of the catalogue that receive nothing from modelled components: anything may come from them at
    /// any time, too.
    pub independent: Vec<String>,
    /// Inputs for which messages may come from outside of the composite at any time.
    pub outside: Vec<String>,
    /// Assumptions beyond the bindings and protocols.
    pub assumptions: Vec<String>,
    /// Functions of other components' specifications: name in the whole, component, and name as declared.
    pub names: BTreeMap<String, (String, String)>,
    /// Functions that the specification itself declares.
    pub functions: BTreeSet<String>,
    /// Inputs of the specification that the environment sets, with their values in a step without a message.
    pub inputs: BTreeMap<String, String>,
    /// Sources of the values of each input.
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
    let specified = plan
        .components
        .iter()
        .filter(|it| specification_of(it).is_some());
    specified.map(|it| it.name.as_str()).collect()
}

/// Returns the component of an end that no actor stands for, or the end of an actor whose protocol says nothing about it.
fn uncovered(actors: &[Actor], end: &End) -> Option<String> {
    match actors.iter().find(|it| it.component == end.component) {
        Some(actor) if actor.covers(&end.name) => None,
        Some(_) => Some(end.to_string()),
        None => Some(end.component.clone()),
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
    let parts = model_parts(context, component)?;
    let specification = merge(
        parts.verified,
        parts.actors,
        &parts.glue,
        &parts.text,
        parts.uses_time,
        parts.sources,
        &context.options,
    )?;
    Ok(ComponentModel {
        specification,
        environment: parts.environment,
    })
}

/// Returns the specification of a component and its environment as text, with positions in place of components. If it is equal for two
/// components, a verification has the same results and assumptions for both, up to names of components. `terms` are those of its options,
/// which can contain names of the environment.
///
/// # Errors
/// A specification or protocol has errors, or the values of an input cannot be listed.
pub fn canonical_model(
    context: &ModelContext<'_>,
    component: &str,
    terms: &[String],
) -> Result<String, ModelError> {
    Ok(model_parts(context, component)?.canonical(terms))
}

fn model_parts(context: &ModelContext<'_>, component: &str) -> Result<ModelParts, ModelError> {
    let plan = context.plan;
    let missing = || ModelError::NoComponent(component.to_owned());
    let planned = plan.component(component).ok_or_else(missing)?;
    let path = specification_of(planned).ok_or_else(missing)?;
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
        own_messages: OwnMessages::default(),
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
        covered: BTreeMap::new(),
        independent: BTreeSet::new(),
    };
    finding.search(planned)?;
    let ActorSearch {
        sources,
        actors,
        uses_time,
        answers,
        independent,
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
    for (at, actor) in actors.iter().enumerate() {
        for input in &actor.inputs {
            let from = senders(plan, actor, input);
            open.extend(from.ends.iter().filter_map(|end| uncovered(&actors, end)));
            if at == 0 && from.outside {
                outside.insert(input.location.clone());
            }
        }
    }
    let independent: Vec<String> = open.intersection(&independent).cloned().collect();
    open.retain(|it| !independent.contains(it));
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
    let own = verified.loaded.units.iter().filter(|it| !it.library);
    let environment = ModelledEnvironment {
        component: component.to_owned(),
        file: path.to_owned(),
        own_files: own.map(|it| it.path.clone()).collect(),
        text: environment,
        others,
        open: open.into_iter().collect(),
        independent,
        outside: outside.into_iter().collect(),
        assumptions: notes.into_iter().collect(),
        names,
        functions,
        inputs,
        origins,
    };
    Ok(ModelParts {
        environment,
        verified,
        actors,
        glue,
        text,
        uses_time,
        sources,
    })
}

impl ModelParts {
    /// The parts as text, with positions in place of components.
    fn canonical(&self, terms: &[String]) -> String {
        let own = self.verified.loaded.units.iter().filter(|it| !it.library);
        let own: Vec<_> = own.map(|it| &it.tree).collect();
        let declared = declared_names(&own).into_iter().collect();
        let components = self.actors.iter().map(|it| it.component.as_str());
        let names = CanonicalNames::of(components, declared);
        let environment = &self.environment;
        let mut lines = vec![
            environment.file.clone(),
            names.text(&environment.text),
            names.text(&self.glue.functions()),
            // the same functions can get any value for different reasons
            format!(
                "{} open, {} independent, outside {:?}",
                environment.open.len(),
                environment.independent.len(),
                environment.outside
            ),
        ];
        lines.extend(environment.assumptions.iter().map(|it| names.prose(it)));
        lines.extend(terms.iter().map(|it| names.text(it)));
        lines.join("\n")
    }
}
