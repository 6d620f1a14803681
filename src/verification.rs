//! Verifies specifications of composites: each together with its environment.

use crate::build::Build;
use crate::files::DiskLoader;
use asmotion_composite::model::PlannedVerify;
use asmotion_lang::hir::PropertyLogic;
use asmotion_lang::value::Atom;
use asmotion_lang::{Loader, ReadOptions, Report, Sources, Span, Style, Value, render_all};
use asmotion_plan::{Component, Implementation, Plan};
use asmotion_verification::{
    ComponentModel, ModelContext, ModelError, ModelledEnvironment, canonical_model, component_model,
};
use asmotion_verify::{
    Limits, MessageLink, Note, Options, PropertyKind, Run, SystemSpecification, Verdict,
    Verification, state_constraints, verify,
};
use std::collections::{BTreeMap, BTreeSet};
use std::time::{Duration, Instant};

/// Returns the specification of a component together with its environment.
///
/// # Errors
/// A specification or protocol has errors, or the values of an input cannot be listed.
pub fn model(
    build: &Build,
    plan: &Plan,
    component: &str,
    loader: &dyn Loader,
    options: ReadOptions,
) -> Result<ComponentModel, ModelError> {
    let catalogue = build.catalogue();
    let context = ModelContext {
        plan,
        loader,
        protocols: &|name| catalogue.protocol(name),
        options,
    };
    component_model(&context, component)
}

/// Components that need one verification, because they and their environments differ in names of components only: the instances of an
/// element, usually.
pub struct AlikeComponents<'p> {
    /// The first of them, which is verified.
    pub component: &'p str,
    /// Those for which its results hold as well.
    pub others: Vec<&'p str>,
}

impl<'p> AlikeComponents<'p> {
    /// Groups components in the order of the first of each group. A component without a model is alone. `terms` are those of the options of
    /// the verification, which can name functions of other components.
    pub fn among(
        build: &Build,
        plan: &Plan,
        components: &[&'p str],
        terms: &[String],
        loader: &dyn Loader,
    ) -> Vec<Self> {
        let catalogue = build.catalogue();
        let context = ModelContext {
            plan,
            loader,
            protocols: &|name| catalogue.protocol(name),
            options: ReadOptions::default(),
        };
        let mut groups: Vec<Self> = Vec::new();
        let mut known: BTreeMap<String, usize> = BTreeMap::new();
        for component in components {
            let canonical = match components {
                [_] => None,
                _ => canonical_model(&context, component, terms).ok(),
            };
            let next = groups.len();
            let group = canonical.map_or(next, |it| *known.entry(it).or_insert(next));
            match groups.get_mut(group) {
                Some(group) => group.others.push(component),
                None => groups.push(Self {
                    component,
                    others: Vec::new(),
                }),
            }
        }
        groups
    }

    /// The others in a few words, with a quotation mark around each name; `None` if there are none.
    pub fn others_in_words(&self, quote: &str) -> Option<String> {
        let shown = self.others.get(..MOST_NAMED).unwrap_or(&self.others);
        let names = shown.iter().map(|it| format!("{quote}{it}{quote}"));
        let names = names.collect::<Vec<_>>().join(", ");
        match self.others.len() - shown.len() {
            0 if names.is_empty() => None,
            0 => Some(names),
            more => Some(format!("{names} and {more} more")),
        }
    }
}

/// Most names that are written out; further ones are only counted.
const MOST_NAMED: usize = 3;

/// Describes the reason for which there is no model of a component.
pub fn describe(error: &ModelError) -> String {
    match error {
        ModelError::Specification { sources, report } => rendered(report, sources),
        ModelError::NoMainRule(_)
        | ModelError::NoComponent(_)
        | ModelError::NoFunction { .. }
        | ModelError::OutcomesBesideValues { .. }
        | ModelError::Annotation { .. }
        | ModelError::Unbounded { .. }
        | ModelError::UpdatedParameter { .. }
        | ModelError::Messages(_) => error.to_string(),
    }
}

/// Renders findings without colour.
pub fn rendered(report: &Report, sources: &Sources) -> String {
    render_all(report, sources, Style::Plain)
}

/// Returns the components whose specifications state properties; all with a specification, if none does.
pub fn components_with_properties(plan: &Plan) -> Vec<&Component> {
    let specified = || {
        let components = plan.components.iter();
        components.filter(|it| matches!(it.implementation, Implementation::Asm { .. }))
    };
    // many components have the same specification
    let mut known: BTreeMap<&str, bool> = BTreeMap::new();
    let mut with_properties = Vec::new();
    for component in specified() {
        if let Implementation::Asm { file, .. } = &component.implementation
            && *known.entry(file).or_insert_with(|| has_properties(file))
        {
            with_properties.push(component);
        }
    }
    if with_properties.is_empty() {
        specified().collect()
    } else {
        with_properties
    }
}

fn has_properties(file: &str) -> bool {
    let opened = asmotion_lang::open(file, &DiskLoader);
    opened.is_ok_and(|it| !it.model.invariants.is_empty() || !it.model.properties.is_empty())
}

/// Puts the results for a component in terms of its composite: locations of other components get the names of these, and
/// rules of other components that never run are no violation.
pub fn in_terms_of_composite(verification: &mut Verification, environment: &ModelledEnvironment) {
    let sources = verification.machines.first();
    let sources = sources.map(|it| &it.specification.sources);
    for property in &mut verification.properties {
        if property.kind == PropertyKind::RulesRun {
            let own = format!("({}:", environment.file);
            for note in &mut property.notes {
                if let Note::Also(rules) = note {
                    rules.retain(|rule| rule.contains(&own));
                }
            }
            property.notes.retain(|note| match note {
                Note::Also(rules) => !rules.is_empty(),
                Note::Undefined(_)
                | Note::Fails(_)
                | Note::Unmet(_)
                | Note::Irrelevant(_)
                | Note::Unfair { .. }
                | Note::Undecided(_)
                | Note::Unexamined(_)
                | Note::FailingSteps => true,
            });
            if property.notes.is_empty() && !matches!(property.verdict, Verdict::Unknown) {
                property.verdict = Verdict::Holds(None);
            }
        }
        match &mut property.verdict {
            Verdict::Holds(Some(run)) | Verdict::Violated(Some(run)) => {
                rewrite(run, environment);
                for step in &mut run.steps {
                    // those of the environment show in its messages
                    step.choices.retain(|it| {
                        sources.is_some_and(|known| is_own(it.place, known, environment))
                    });
                }
            }
            Verdict::Holds(None) | Verdict::Violated(None) | Verdict::Unknown => {}
        }
    }
}

/// Returns `true` if a place is in a file of the verified specification, not in its environment.
pub fn is_own(place: Span, sources: &Sources, environment: &ModelledEnvironment) -> bool {
    environment.own_files.contains(sources.path(place.file))
}

/// The name of a location in the composite; `None` if it is part of the environment's own state.
fn name_in_composite(location: &str, environment: &ModelledEnvironment) -> Option<String> {
    let (function, arguments) = match location.find('(') {
        Some(at) => location.split_at(at),
        None => (location, ""),
    };
    if environment.functions.contains(function) {
        return Some(location.to_owned());
    }
    let (component, declared) = environment.names.get(function)?;
    Some(format!("{component}.{declared}{arguments}"))
}

/// The value of a location of another component, as its specification declares it.
fn value_in_composite(value: &mut String, environment: &ModelledEnvironment) {
    if let Some((_, declared)) = environment.names.get(value) {
        value.clone_from(declared);
    }
}

/// Shows inputs that the environment sets as inputs of the step that reads them.
fn rewrite(run: &mut Run, environment: &ModelledEnvironment) {
    let is_input = |location: &str| environment.inputs.contains_key(location);
    let mut inputs: Vec<(String, String)> = Vec::new();
    let initial = std::mem::take(&mut run.initial);
    for (location, mut value) in initial {
        if is_input(&location) {
            inputs.push((location, value));
        } else if let Some(name) = name_in_composite(&location, environment) {
            value_in_composite(&mut value, environment);
            run.initial.push((name, value));
        }
    }
    for step in &mut run.steps {
        let read = inputs.iter().filter(|(location, value)| {
            environment
                .inputs
                .get(location)
                .is_some_and(|none| none != value)
        });
        let read: Vec<(String, String)> = read.cloned().collect();
        step.inputs.splice(0..0, read);
        let updates = std::mem::take(&mut step.updates);
        for mut update in updates {
            if is_input(&update.location) {
                let known = inputs
                    .iter_mut()
                    .find(|(location, _)| *location == update.location);
                match known {
                    Some((_, value)) => *value = update.after,
                    None => inputs.push((update.location, update.after)),
                }
            } else if let Some(name) = name_in_composite(&update.location, environment) {
                update.location = name;
                value_in_composite(&mut update.before, environment);
                value_in_composite(&mut update.after, environment);
                step.updates.push(update);
            }
        }
    }
    let last = inputs.into_iter().filter(|(location, value)| {
        environment
            .inputs
            .get(location)
            .is_some_and(|none| none != value)
    });
    if run.cycle.is_none() {
        run.inputs.splice(0..0, last);
    }
}

/// Adds the origin to the values of inputs in a run, for readers.
pub fn with_origins(verification: &mut Verification, environment: &ModelledEnvironment) {
    for property in &mut verification.properties {
        let (Verdict::Holds(Some(run)) | Verdict::Violated(Some(run))) = &mut property.verdict
        else {
            continue;
        };
        let steps = run.steps.iter_mut().flat_map(|step| &mut step.inputs);
        for (location, value) in steps.chain(&mut run.inputs) {
            let origins = environment.origin(location, value);
            if !origins.is_empty() {
                value.push_str(&format!(" (from {})", origins.join(" or ")));
            }
        }
    }
}

/// The result of a verification before the start of a composite.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StartVerification {
    /// Properties that are violated, not known or not possible; empty if all hold.
    pub findings: Vec<String>,
}

/// Verifies the properties of components that their key `verify`, which is the same for all of them, selects.
pub fn before_start(
    build: &Build,
    plan: &Plan,
    components: &AlikeComponents<'_>,
    keys: &PlannedVerify,
    loader: &dyn Loader,
) -> StartVerification {
    let name = |before_others: &str| match components.others_in_words("`") {
        None => format!("`{}`", components.component),
        Some(others) => format!("`{}` ({before_others} {others})", components.component),
    };
    let not_possible = |reason: String| StartVerification {
        findings: vec![format!("{} cannot be verified: {reason}", name("and"))],
    };
    let options = ReadOptions::default();
    let found = model(build, plan, components.component, loader, options);
    let ComponentModel {
        mut specification,
        environment,
    } = match found {
        Ok(model) => model,
        Err(error) => return not_possible(describe(&error)),
    };
    let selects_all = !(keys.ctl || keys.ltl || keys.invariants);
    let is_selected = |kind: PropertyKind| match kind {
        PropertyKind::Invariant => selects_all || keys.invariants,
        PropertyKind::Ctl => selects_all || keys.ctl,
        PropertyKind::Ltl => selects_all || keys.ltl,
        // all others are only true under it
        PropertyKind::Constraint | PropertyKind::NoFault => true,
        PropertyKind::Possible | PropertyKind::NotStuck | PropertyKind::RulesRun => false,
    };
    let logic = |logic: PropertyLogic| match logic {
        PropertyLogic::Ctl => is_selected(PropertyKind::Ctl),
        PropertyLogic::Ltl => is_selected(PropertyKind::Ltl),
        PropertyLogic::Constraint | PropertyLogic::Justice | PropertyLogic::Compassion => true,
    };
    let stated = &mut specification.model;
    stated.properties.retain(|it| logic(it.logic));
    let options = Options {
        checked_constraints: constraints_on_state(&environment.file, loader),
        limits: Limits {
            states: keys.states,
            depth: keys.bound.and_then(|bound| u32::try_from(bound).ok()),
            memory: Some(MEMORY),
            reserve: Some(RESERVE),
        },
        ..Options::default()
    };
    let begun = Instant::now();
    let time = Duration::from_secs_f64(keys.time_s);
    let verified = verify(specification, &options, &mut |_| begun.elapsed() < time);
    let mut verification = match verified {
        Ok(verification) => verification,
        Err(refusal) => {
            return not_possible(rendered(&refusal.report, &refusal.specification.sources));
        }
    };
    in_terms_of_composite(&mut verification, &environment);
    with_origins(&mut verification, &environment);
    let name = name("and of");
    let checked = verification
        .properties
        .iter()
        .filter(|it| is_selected(it.kind));
    let findings = checked.filter_map(|it| match &it.verdict {
        Verdict::Holds(_) => None,
        Verdict::Violated(run) => Some(format!(
            "`{}` of {name} is violated{}",
            it.text,
            run.as_ref().map_or_else(String::new, |run| in_lines(run))
        )),
        Verdict::Unknown => Some(format!(
            "`{}` of {name} is not known to hold: {} within the limits of `verify`",
            it.text,
            if it
                .notes
                .iter()
                .any(|note| matches!(note, Note::Undecided(_)))
            {
                "it was not decided"
            } else {
                "not all states were explored"
            }
        )),
    });
    StartVerification {
        findings: findings.collect(),
    }
}

/// The constraints of a specification that are about its state alone.
fn constraints_on_state(file: &str, loader: &dyn Loader) -> Vec<String> {
    // in the model of the composite, inputs are functions that the environment updates
    let opened = asmotion_lang::open(file, loader);
    opened.map_or_else(
        |_| Vec::new(),
        |it| state_constraints(&it.model, &it.sources),
    )
}

/// Memory for a verification before the start, in bytes.
const MEMORY: u64 = 1 << 31;

/// Elements that `extend` may create, for a verification before the start.
const RESERVE: usize = 8;

/// A run, one step on each line.
fn in_lines(run: &Run) -> String {
    let pairs = |pairs: &[(String, String)]| {
        let pairs = pairs
            .iter()
            .map(|(location, value)| format!("{location} = {value}"));
        pairs.collect::<Vec<_>>().join(", ")
    };
    let mut lines = String::new();
    for (number, step) in run.steps.iter().enumerate() {
        if run.cycle == Some(number) {
            lines.push_str("\n  from here on repeated for ever");
        }
        lines.push_str(&format!("\n  step {} {}", number + 1, pairs(&step.inputs)));
        for update in &step.updates {
            let (location, before, after) = (&update.location, &update.before, &update.after);
            lines.push_str(&format!("\n    {location}: {before} → {after}"));
        }
        if let Some(fault) = &step.fault {
            lines.push_str(&format!("\n    fails: {}", fault.message));
        }
    }
    if !run.inputs.is_empty() {
        lines.push_str(&format!("\n  then {}", pairs(&run.inputs)));
    }
    lines
}

/// Returns `true` if specifications of a composite exchange messages with partners.
pub fn exchanges_messages(plan: &Plan) -> bool {
    let files = plan
        .components
        .iter()
        .filter_map(|it| match &it.implementation {
            Implementation::Asm { file, .. } => Some(&**file),
            Implementation::Rust(_)
            | Implementation::Builtin { .. }
            | Implementation::Process { .. }
            | Implementation::Ros { .. }
            | Implementation::Orocos { .. } => None,
        });
    files.collect::<BTreeSet<&str>>().into_iter().any(|file| {
        let opened = asmotion_lang::open(file, &DiskLoader);
        opened.is_ok_and(|it| !asmotion_lang::ir::message_uses(&it.model).is_empty())
    })
}

/// Links partners of specifications to other specifications, by the wires of their composite and not by their names. Requests from outside
/// come to promoted services, and to those that are called by components without a specification or by wires to several services. An
/// input has any value, also if a connection leads to it.
pub fn link_messages(plan: &Plan, system: &mut SystemSpecification) {
    system.ignores_names = true;
    let machines = &system.machines;
    let index_of = |component: &str| machines.iter().position(|it| it.name == component);
    for wire in &plan.wires {
        let providers = wire.services.iter();
        let providers = providers.filter_map(|service| index_of(&service.component));
        let providers: Vec<usize> = providers.collect();
        let link = index_of(&wire.reference.component).and_then(|client| {
            let atoms = &machines.get(client)?.specification.program.symbols.atoms;
            let mut atoms = (0u32..).map(Atom).zip(atoms);
            let (partner, _) = atoms.find(|(_, name)| ***name == *wire.reference.name)?;
            Some((client, Value::Atom(partner)))
        });
        match (link, providers.as_slice()) {
            (Some((client, partner)), [provider]) if wire.services.len() == 1 => {
                system.message_links.push(MessageLink {
                    client,
                    partner,
                    provider: *provider,
                });
            }
            (Some(_) | None, _) => system.open.extend(providers),
        }
    }
    let services = plan.promoted.iter().filter(|it| it.what == "service");
    let components = services.filter_map(|it| it.inside.rsplit_once('.'));
    let promoted = components.filter_map(|(component, _)| index_of(component));
    system.open.extend(promoted);
}
