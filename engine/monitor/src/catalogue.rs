//! The fixed part of what a dashboard shows: names, topics, and the texts of the specifications.

use asmotion_component::Time;
use asmotion_coordinator::CONTROL_STATES;
use asmotion_lang::simulate;
use asmotion_lang::{ControlDiagram, FunctionKind, Loader, Specification};
use asmotion_plan::{Implementation, Part, Plan};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

#[cfg(feature = "recording")]
use crate::recording_description::RecordingDescription;

use crate::step_guards::SpecificationTexts;

/// The description of a system; by default, of an empty one.
#[derive(Clone, Debug, Default, Serialize)]
pub struct SystemDescription {
    /// Name of the composite.
    pub name: String,
    /// Selected profile.
    pub profile: Option<String>,
    /// Clock of the run, for example `wall clock`.
    pub clock: String,
    /// Components of this process.
    components: Vec<DescribedComponent>,
    topics: Vec<DescribedTopic>,
    specifications: Vec<DescribedSpecification>,
    /// What only a recording has; `None` for a running system.
    #[cfg(feature = "recording")]
    pub(crate) recording: Option<RecordingDescription>,
}

/// Initial state and control state of an added specification, for the reader of a recording.
#[cfg(feature = "recording")]
pub(crate) struct AddedSpecification {
    /// The initial state, as pairs of location and value.
    pub initial: Vec<(String, String)>,
    /// The location of the control state; `None` without one.
    pub control: Option<String>,
}

/// A component and its implementation.
#[derive(Clone, Debug, Serialize)]
struct DescribedComponent {
    name: String,
    implementation: String,
}

/// A topic, with the inputs that subscribe to it in this process.
#[derive(Clone, Debug, Serialize)]
struct DescribedTopic {
    name: String,
    kind: Option<String>,
    subscribers: Vec<String>,
}

/// A specification that a component executes.
#[derive(Clone, Debug, Serialize)]
struct DescribedSpecification {
    component: String,
    /// Time from which this version runs, in seconds of the run; greater than 0 only for a later version in a recording.
    from: f64,
    /// The files, the main one first.
    files: Vec<DescribedFile>,
    /// The control-state diagram; `None` without a control state.
    diagram: Option<DescribedDiagram>,
    /// The initial state, as pairs of location and value.
    initial: Vec<(String, String)>,
    /// Names of the monitored functions, which are unknown before a step reads them.
    monitored: Vec<String>,
    /// Names of all functions of the specification and its modules.
    #[serde(skip)]
    functions: BTreeSet<String>,
    /// Names of the invariants and properties, as in the text.
    properties: Vec<DescribedProperty>,
}

#[derive(Clone, Debug, Serialize)]
struct DescribedFile {
    name: String,
    text: Arc<str>,
    #[serde(skip)]
    path: String,
}

#[derive(Clone, Debug, Serialize)]
struct DescribedDiagram {
    location: String,
    states: Vec<String>,
    initial: Option<String>,
    transitions: Vec<DescribedTransition>,
}

#[derive(Clone, Debug, Serialize)]
struct DescribedTransition {
    from: Vec<String>,
    to: String,
    guards: Vec<String>,
    line: usize,
}

#[derive(Clone, Debug, Serialize)]
struct DescribedProperty {
    line: usize,
    text: String,
}

impl SystemDescription {
    /// Describes the part of a plan that runs in this process. The specifications are read with the loader; one that cannot be
    /// opened is left out.
    pub fn of(plan: &Plan, part: &Part, clock: String, loader: &dyn Loader) -> Self {
        let here = || plan.components.iter().filter(|it| part.has(&it.name));
        let components = here().map(|it| DescribedComponent {
            name: it.name.clone(),
            implementation: it.implementation.words().join(" "),
        });
        let topics = plan.topics.iter().map(|topic| {
            let subscribers = topic.subscribers.iter();
            let subscribers = subscribers.filter(|end| part.has(&end.component));
            DescribedTopic {
                name: topic.name.clone(),
                kind: topic.kind.clone(),
                subscribers: subscribers.map(ToString::to_string).collect(),
            }
        });
        // many components have the same specification
        let mut known: BTreeMap<&str, Option<DescribedSpecification>> = BTreeMap::new();
        let specifications = here().filter_map(|component| {
            let Implementation::Asm { file, .. } = &component.implementation else {
                return None;
            };
            let described = || DescribedSpecification::of(&component.name, file, loader);
            let described = known.entry(file).or_insert_with(described).as_ref()?;
            Some(DescribedSpecification {
                component: component.name.clone(),
                ..described.clone()
            })
        });
        Self {
            name: plan.name.clone(),
            profile: plan.profile.clone(),
            clock,
            components: components.collect(),
            topics: topics.collect(),
            specifications: specifications.collect(),
            #[cfg(feature = "recording")]
            recording: None,
        }
    }

    /// Adds a component, unless it is known.
    #[cfg(feature = "recording")]
    pub(crate) fn add_component(&mut self, name: &str) {
        if name.is_empty() || self.components.iter().any(|it| it.name == name) {
            return;
        }
        self.components.push(DescribedComponent {
            name: name.to_owned(),
            implementation: String::new(),
        });
    }

    /// Adds a component with its implementation, unless it is known with one.
    #[cfg(feature = "recording")]
    pub(crate) fn describe_component(&mut self, name: &str, implementation: &str) {
        self.add_component(name);
        let known = self.components.iter_mut().find(|it| it.name == name);
        if let Some(known) = known.filter(|it| it.implementation.is_empty()) {
            implementation.clone_into(&mut known.implementation);
        }
    }

    /// Adds the specification that a component executes from a time on, whose texts the loader has.
    #[cfg(feature = "recording")]
    pub(crate) fn add_specification(
        &mut self,
        component: &str,
        from: Time,
        main: &str,
        loader: &dyn Loader,
    ) -> AddedSpecification {
        let mut described = match asmotion_lang::open(main, loader) {
            Ok(opened) => DescribedSpecification::opened(component, &opened, main),
            // written for another version: its text says more than nothing
            Err(_) => DescribedSpecification::of_text(component, main, loader),
        };
        described.from = from.seconds();
        let control = described.diagram.as_ref();
        let added = AddedSpecification {
            initial: described.initial.clone(),
            control: control.map(|diagram| diagram.location.clone()),
        };
        self.specifications.push(described);
        added
    }

    /// The texts of the specification of a component.
    pub(crate) fn texts(&self, component: &str) -> Vec<&str> {
        let files = self
            .specification(component)
            .into_iter()
            .flat_map(|it| &it.files);
        files.map(|file| &*file.text).collect()
    }

    /// The names of the functions of a component's specification.
    pub(crate) fn functions(&self, component: &str) -> Option<&BTreeSet<String>> {
        Some(&self.specification(component)?.functions)
    }

    /// The texts of the specification that a component executes at a time.
    pub(crate) fn texts_at(&self, component: &str, at: Time) -> SpecificationTexts {
        let mut versions = self.specifications.iter();
        let version = versions.rfind(|it| it.component == component && it.from <= at.seconds());
        let files = version.into_iter().flat_map(|it| &it.files);
        files
            .map(|it| (it.path.clone(), Arc::clone(&it.text)))
            .collect()
    }

    fn specification(&self, component: &str) -> Option<&DescribedSpecification> {
        self.specifications
            .iter()
            .find(|it| it.component == component)
    }

    /// The control states of the specifications: component and location.
    pub(crate) fn control_states(&self) -> Vec<(String, String)> {
        let specifications = self.specifications.iter();
        let known = specifications.filter_map(|it| {
            let diagram = it.diagram.as_ref()?;
            Some((it.component.clone(), diagram.location.clone()))
        });
        known.collect()
    }

    /// The initial states of the specifications: components, with pairs of location and value.
    pub(crate) fn initial_states(&self) -> Vec<(String, Vec<(String, String)>)> {
        let specifications = self.specifications.iter();
        let initial = specifications.map(|it| (it.component.clone(), it.initial.clone()));
        initial.collect()
    }

    /// The inputs that subscribe to a topic; `None` for an unknown topic.
    pub(crate) fn subscribers(&self, topic: &str) -> Option<&[String]> {
        let topic = self.topics.iter().find(|known| known.name == topic)?;
        Some(&topic.subscribers)
    }
}

impl DescribedSpecification {
    fn of(component: &str, file: &str, loader: &dyn Loader) -> Option<Self> {
        let specification = asmotion_lang::open(file, loader).ok()?;
        Some(Self::opened(component, &specification, file))
    }

    /// A specification without an analysis.
    #[cfg(feature = "recording")]
    fn of_text(component: &str, main: &str, loader: &dyn Loader) -> Self {
        let text = loader.read(main).map(|text| text.to_string());
        Self {
            component: component.to_owned(),
            from: 0.0,
            files: vec![DescribedFile {
                name: main.rsplit('/').next().unwrap_or(main).to_owned(),
                text: text.unwrap_or_default().into(),
                path: main.to_owned(),
            }],
            diagram: None,
            initial: Vec::new(),
            monitored: Vec::new(),
            functions: BTreeSet::new(),
            properties: Vec::new(),
        }
    }

    fn opened(component: &str, specification: &Specification, main: &str) -> Self {
        let functions = || specification.model.own_functions();
        let monitored = functions().filter(|(_, it)| it.kind == FunctionKind::Monitored);
        Self {
            component: component.to_owned(),
            from: 0.0,
            files: files(specification, main),
            diagram: diagram(specification),
            initial: initial(specification),
            monitored: monitored.map(|(_, it)| it.name.to_string()).collect(),
            functions: functions().map(|(_, it)| it.name.to_string()).collect(),
            properties: properties(specification),
        }
    }
}

/// The texts of a specification without standard libraries, the main one first.
fn files(specification: &Specification, main: &str) -> Vec<DescribedFile> {
    let sources = &specification.sources;
    let own = |path: &&str| {
        let rules = specification
            .model
            .rules
            .iter()
            .map(|it| (it.span, it.library));
        let functions = specification
            .model
            .functions
            .iter()
            .map(|it| (it.span, it.library));
        let mut declared = rules.chain(functions);
        **path == *main
            || declared.any(|(span, library)| !library && sources.path(span.file) == *path)
    };
    let mut paths: Vec<&str> = sources.paths().filter(own).collect();
    paths.sort_by_key(|path| *path != main);
    let described = paths.into_iter().filter_map(|path| {
        let file = sources.find(path)?;
        Some(DescribedFile {
            name: path.rsplit('/').next().unwrap_or(path).to_owned(),
            text: sources.text(file).into(),
            path: path.to_owned(),
        })
    });
    described.collect()
}

/// The diagram of the control state: of the function with a usual name, or of the only one.
fn diagram(specification: &Specification) -> Option<DescribedDiagram> {
    let mut all = specification.control_diagrams();
    let mut names = CONTROL_STATES.iter();
    let named = names.find_map(|name| all.iter().position(|it| it.location == *name));
    let index = named.or_else(|| (all.len() == 1).then_some(0))?;
    let ControlDiagram {
        location,
        states,
        initial,
        transitions,
    } = all.swap_remove(index);
    let transitions = transitions.into_iter().map(|it| DescribedTransition {
        from: it.from,
        to: it.to,
        guards: it.guards,
        line: it.line,
    });
    Some(DescribedDiagram {
        location,
        states,
        initial,
        transitions: transitions.collect(),
    })
}

/// The locations of the initial state that rules can update.
fn initial(specification: &Specification) -> Vec<(String, String)> {
    let Ok(machine) = specification.machine() else {
        return Vec::new();
    };
    let (state, program) = (machine.state(), machine.program());
    let locations = state.locations(program).into_iter();
    let is_read_only = |kind| matches!(kind, FunctionKind::Monitored);
    let known = locations.filter(|(function, ..)| {
        let function = specification.model.functions.get(function.0 as usize);
        function.is_some_and(|it| !is_read_only(it.kind))
    });
    let shown = known.map(|(function, arguments, slot)| {
        let value = state.get(slot).show(&machine.naming()).to_string();
        (simulate::applied(&machine, function, &arguments), value)
    });
    shown.collect()
}

fn properties(specification: &Specification) -> Vec<DescribedProperty> {
    let model = &specification.model;
    let spans = model.invariants.iter().map(|it| it.span);
    let spans = spans.chain(model.properties.iter().map(|it| it.span));
    let property = |span: asmotion_lang::diagnostics::Span| {
        let (line, _) = specification.sources.position(span.file, span.start);
        let text = specification.sources.snippet(span).split_whitespace();
        DescribedProperty {
            line,
            text: text.collect::<Vec<_>>().join(" "),
        }
    };
    spans.map(property).collect()
}
