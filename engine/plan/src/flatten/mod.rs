//! Flattens nested composites, resolving promotions and renames to running components.

mod component;
mod endpoint;
mod join;
mod late_reader;
mod operations;
mod order;
mod place;
mod proxy_target;
mod topic;

use std::collections::BTreeMap;
use std::sync::Arc;

use asmotion_coordinator::Binding;
use asmotion_diagnostics::{Sources, Span};

use crate::codes::c082::{MAX_COMPONENTS, TooManyComponents};
use crate::connection_list::ConnectionList;
use crate::plan::{Plan, PropertyValues};
use crate::wire_list::WireList;
use asmotion_composite::check::endpoints::Endpoints;
use asmotion_composite::check::{self, Faces};
use asmotion_composite::family::{Family, Member};
use asmotion_composite::finding::Findings;
use asmotion_composite::model::{self, Composite};
use asmotion_composite::property;
use asmotion_composite::scope::{OutsideSettings, PropertyScope, SubstitutionNotes};
use asmotion_composite::table::Resolver;
use asmotion_composite::types::Types;
use asmotion_composite::value::SettingValue;
use asmotion_composite::{Context, NamedList};

/// Inputs of the planner.
pub(crate) struct Parts<'p> {
    pub family: &'p Family,
    pub types: &'p BTreeMap<&'p str, Types<'p>>,
    pub faces: &'p BTreeMap<String, Faces>,
    pub context: &'p Context<'p>,
    pub sources: &'p Sources,
    pub profile: Option<&'p str>,
}

/// Flattens a composite in one profile. Errors are added to the notes; a plan with errors must not be started.
pub(crate) fn flatten(parts: &Parts<'_>, notes: &mut SubstitutionNotes) -> Option<Plan> {
    let member = parts.family.member(&parts.family.root)?;
    let plan = blank(&member.composite, parts.profile);
    let mut flattener = Flattener {
        parts,
        notes,
        plan,
        instances: Vec::new(),
        resolved: None,
        full: false,
    };
    let set =
        property::outside_settings(&member.composite, parts.context.settings, flattener.notes);
    flattener.instance(&parts.family.root, member, None, set);
    for index in 0..flattener.instances.len() {
        flattener.join(index);
    }
    flattener.finish(member)
}

fn blank(composite: &Composite, profile: Option<&str>) -> Plan {
    Plan {
        name: composite.name().value,
        version: composite.head.version.as_ref().map(|it| it.value.clone()),
        profile: profile.map(str::to_owned),
        missing: Vec::new(),
        start_order: Vec::new(),
        properties: PropertyValues::default(),
        brokers: Vec::new(),
        gateways: Vec::new(),
        bridges: Vec::new(),
        components: NamedList::default(),
        topics: Vec::new(),
        connections: ConnectionList::default(),
        wires: WireList::default(),
        process_positions: BTreeMap::new(),
        has_component_broker: false,
        promoted: Vec::new(),
        processes: Vec::new(),
        restart: None,
        record: None,
        types: BTreeMap::new(),
        interfaces: BTreeMap::new(),
    }
}

/// Externally set properties by component and property.
type Overrides = BTreeMap<(String, String), (Option<SettingValue>, Option<Span>)>;

/// An instance of a composite.
pub(super) struct Instance<'p> {
    /// Qualified name of the instance with a trailing slash, such as `Driver/`; empty for the outermost composite.
    pub prefix: String,
    /// Path of the composite file.
    path: &'p str,
    pub member: &'p Member,
    /// Index of the enclosing instance and the component implemented by this one; `None` for the outermost composite.
    pub parent: Option<(usize, &'p model::Component)>,
    /// Indices of nested instances by component name.
    pub children: BTreeMap<&'p str, usize>,
    pub scope: PropertyScope<'p>,
    /// Values set from outside for promoted properties of its components.
    overrides: Overrides,
}

pub(super) struct Flattener<'p, 'n> {
    pub parts: &'p Parts<'p>,
    pub notes: &'n mut SubstitutionNotes,
    pub plan: Plan,
    pub instances: Vec<Instance<'p>>,
    /// The last component whose bindings have been resolved without a note.
    resolved: Option<ResolvedBinding<'p>>,
    /// Set once the maximum number of components is exceeded.
    full: bool,
}

/// The bindings of a component.
struct ResolvedBinding<'p> {
    /// Index of the instance of the composite that contains the component.
    index: usize,
    component: &'p model::Component,
    face: &'p Endpoints,
    binding: Arc<Binding>,
}

impl ResolvedBinding<'_> {
    /// Returns the bindings if those of another component are the same: instances of one component often differ in names only.
    fn of(
        &self,
        index: usize,
        component: &model::Component,
        face: &Endpoints,
    ) -> Option<Arc<Binding>> {
        let is_same = self.index == index
            && Arc::ptr_eq(&self.component.bind, &component.bind)
            && self.component.implementation == component.implementation
            && self.face.differs_in_topics_only(face);
        is_same.then(|| Arc::clone(&self.binding))
    }
}

impl<'p> Flattener<'p, '_> {
    /// Adds an instance of a composite and everything it contains.
    fn instance(
        &mut self,
        path: &'p str,
        member: &'p Member,
        parent: Option<(usize, &'p model::Component)>,
        set: OutsideSettings,
    ) -> usize {
        let composite = &member.composite;
        let prefix = parent.map_or(String::new(), |(parent, component)| {
            let outer = self
                .instances
                .get(parent)
                .map_or("", |parent| &parent.prefix);
            format!("{outer}{}/", component.name.value)
        });
        let (own, overrides) = split(composite, set);
        let scope = property::scope(
            &composite.properties,
            own,
            self.parts.context.environment,
            self.parts.sources,
            self.notes,
        );
        if parent.is_none() {
            let known = composite.properties.iter().filter_map(|property| {
                let name = &property.name.value;
                Some((name.clone(), scope.value(name)?.clone()))
            });
            self.plan.properties = PropertyValues(known.collect());
        }
        let index = self.instances.len();
        let children = BTreeMap::new();
        self.instances.push(Instance {
            prefix,
            path,
            member,
            parent,
            children,
            scope,
            overrides,
        });
        self.endpoints(index, composite);
        for component in &composite.components {
            if check::takes_part(&component.profiles, self.parts.profile) {
                self.component(index, member, component);
            }
        }
        index
    }

    fn component(&mut self, index: usize, member: &'p Member, component: &'p model::Component) {
        // the outermost composite is no component
        let nested = self.instances.len().saturating_sub(1);
        if self.plan.components.len() + nested >= MAX_COMPONENTS {
            if !self.full {
                self.notes.found(TooManyComponents {
                    at: component.name.span,
                });
            }
            self.full = true;
            return;
        }
        let Some(instance) = self.instances.get(index) else {
            return;
        };
        let mut set = OutsideSettings::new();
        for setting in &component.properties {
            let value = instance.scope.node(&setting.value, self.notes);
            set.insert(
                setting.name.value.clone(),
                (value, Some(setting.value.span)),
            );
        }
        for ((owner, property), value) in &instance.overrides {
            if *owner == component.name.value {
                set.insert(property.clone(), value.clone());
            }
        }
        let file = check::nested(component);
        if let Some((path, nested)) = file.and_then(|file| self.parts.family.nested(member, file)) {
            if self.full {
                return;
            }
            let child = self.instance(path, nested, Some((index, component)), set);
            if let Some(instance) = self.instances.get_mut(index) {
                instance.children.insert(&component.name.value, child);
            }
            return;
        }
        if file.is_some() {
            return;
        }
        let faces = self.parts.faces.get(instance.path);
        let Some(face) = faces.and_then(|faces| faces.get(&component.name.value)) else {
            return;
        };
        let Some(types) = self.parts.types.get(instance.path) else {
            return;
        };
        let resolved = self.resolved.as_ref();
        let known = resolved.and_then(|it| it.of(index, component, face));
        let is_known = known.is_some();
        let before = self.notes.report.diagnostics.len();
        let bind = self.parts.family.bind(member, component);
        let source = component::PartSource {
            member,
            path: instance.path,
            component,
            bind: &bind,
            binding: known,
            face,
            types,
            prefix: &instance.prefix,
            scope: &instance.scope,
            catalogue: self.parts.context.catalogue,
        };
        let mut made = component::component(&source, set, self.notes);
        if let Some(binding) = made.binding.as_ref().filter(|_| !is_known)
            && before == self.notes.report.diagnostics.len()
        {
            self.resolved = Some(ResolvedBinding {
                index,
                component,
                face,
                binding: Arc::clone(binding),
            });
        }
        for port in made.inputs.iter_mut().chain(&mut made.outputs) {
            port.topic = port.topic.take().map(|topic| self.topic(index, &topic));
        }
        self.plan.components.push(made);
    }

    /// Returns the composite of an instance.
    pub(super) fn composite(&self, index: usize) -> Option<&'p Composite> {
        self.instances
            .get(index)
            .map(|instance| &instance.member.composite)
    }

    fn finish(mut self, member: &'p Member) -> Option<Plan> {
        let composite = &member.composite;
        self.gateways(composite);
        for promotion in &composite.promotions {
            if check::takes_part(&promotion.profiles, self.parts.profile) {
                self.promotion(promotion);
            }
        }
        self.topics(composite);
        let nested = self.instances_by_name();
        if let Some(outermost) = self.instances.first() {
            let mut to = Resolver::new(&outermost.scope, &outermost.prefix, self.notes);
            place::place(composite, &nested, &mut to, &mut self.plan);
        }
        let mut components = self.plan.components.iter();
        self.plan.has_component_broker = components.any(|it| it.pace.broker.is_some());
        self.late_readers();
        proxy_target::resolve(&mut self.plan);
        self.plan.start_order = order::start_order(&self.plan);
        self.plan.missing = self.notes.missing.clone();
        Some(self.plan)
    }

    /// Returns the name prefixes of the composites nested directly in the outermost one.
    fn instances_by_name(&self) -> BTreeMap<&'p str, String> {
        let outermost = self.instances.first();
        let children = outermost
            .into_iter()
            .flat_map(|instance| &instance.children);
        children
            .filter_map(|(name, child)| Some((*name, self.instances.get(*child)?.prefix.clone())))
            .collect()
    }
}

/// Splits values into those of the composite's own properties and those of promoted properties.
fn split(composite: &Composite, set: OutsideSettings) -> (OutsideSettings, Overrides) {
    let mut own = OutsideSettings::new();
    let mut overrides = Overrides::new();
    for (name, value) in set {
        let promoted = composite
            .promotions
            .iter()
            .filter(|promotion| promotion.name.value == name)
            .find_map(|promotion| {
                if let model::Promoted::Property(end) = &promotion.what {
                    Some(end)
                } else {
                    None
                }
            });
        match promoted {
            Some(end) => {
                let key = (end.component.value.clone(), end.name.value.clone());
                overrides.insert(key, value);
            }
            None => {
                own.insert(name, value);
            }
        }
    }
    (own, overrides)
}
