//! Changes of a running system to another plan.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use asmotion_component::{Declaration, Interface};
use asmotion_composite::Catalogue;
use asmotion_datum::Datum;
use asmotion_diagnostics::Loader;
use asmotion_runtime::{Change, ComponentAddition, Replacement, Run};

use crate::start::{self, CoordinatorOptions, Standard, Workshop};
use asmotion_plan::{
    Component, Connection, End, Endpoint, Implementation, Part, Plan, Process, PropertyValues,
    Terminal, Topic, Wire,
};

/// A version of a part of a system: its plan, and what its components are created from.
#[derive(Clone)]
pub struct Version {
    /// The plan of the version.
    pub plan: Plan,
    /// The part of the plan that runs in this process.
    pub part: Part,
    catalogue: Arc<dyn Catalogue + Send + Sync>,
    loader: Arc<dyn Loader + Send + Sync>,
    coordinators: CoordinatorOptions,
    /// The texts of each component's specification and its imports, in the order in which they are loaded.
    texts: BTreeMap<String, Vec<Arc<str>>>,
}

impl Version {
    /// Reads the specifications of a part of a plan. Catalogue, loader and options are those of [`Standard`].
    pub fn new(
        plan: Plan,
        part: Part,
        catalogue: Arc<dyn Catalogue + Send + Sync>,
        loader: Arc<dyn Loader + Send + Sync>,
        coordinators: CoordinatorOptions,
    ) -> Self {
        let here = plan.components.iter().filter(|it| part.has(&it.name));
        let texts = here.filter_map(|component| {
            let file = specification(component)?;
            let texts = start::specification_texts(file, &*loader);
            Some((component.name.clone(), texts))
        });
        Self {
            texts: texts.collect(),
            plan,
            part,
            catalogue,
            loader,
            coordinators,
        }
    }

    /// Returns the constructor of a component. It loads its specification at each call.
    fn constructor(
        &self,
        component: &Component,
    ) -> impl Fn(&mut Interface) -> Result<Box<dyn asmotion_component::Component>, String>
    + Send
    + Sync
    + 'static {
        let (version, component) = (self.clone(), component.clone());
        move |interface| {
            let mut workshop = Standard {
                catalogue: &*version.catalogue,
                loader: &*version.loader,
                coordinators: version.coordinators,
                builtins: &mut |_, _| None,
            };
            workshop.make(&component, &version.plan)?(interface)
        }
    }
}

/// A difference between two plans that requires a restart.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum FixedPart {
    /// A table of the composite.
    #[error("{0} of the composite")]
    Table(&'static str),
    /// A new component that runs in the thread of another one.
    #[error("`{component}` is new and runs in the thread of `{master}`")]
    Slave {
        /// Name of the component.
        component: String,
        /// Name of the other component.
        master: String,
    },
    /// A topic of a new or removed component that leaves the process.
    #[error("`{component}` is {change}, and its topic `{topic}` leaves the process")]
    Topic {
        /// Name of the component.
        component: String,
        /// Name of the topic.
        topic: String,
        /// `new` or `removed`.
        change: &'static str,
    },
    /// A service of a new or removed component that is offered to other processes.
    #[error("`{component}` is {change}, and its service `{service}` is offered to other processes")]
    Service {
        /// Name of the component.
        component: String,
        /// Name of the service in the component.
        service: String,
        /// `new` or `removed`.
        change: &'static str,
    },
    /// A component that differs in more than properties and period.
    #[error("`{0}` differs in more than its properties, its period and its specification")]
    Component(String),
    /// A connection that leaves the process.
    #[error("the connection from `{from}` to `{to}` leaves the process")]
    Connection {
        /// Writing end.
        from: String,
        /// Reading end.
        to: String,
    },
    /// A wire that leaves the process.
    #[error("the wire of `{reference}` to `{service}` leaves the process")]
    Wire {
        /// Reference of the wire.
        reference: String,
        /// Service of the wire.
        service: String,
    },
}

/// Returns the changes that turn a running system into another version: removed connections and wires, removed and added
/// components, then everything else.
///
/// # Errors
///
/// All differences that require a restart.
pub fn changes(
    running: &Version,
    wanted: &Version,
    run: &dyn Run,
) -> Result<Vec<Change>, Vec<FixedPart>> {
    let versions = (running, wanted);
    let (running, wanted) = (&running.plan, &wanted.plan);
    let mut difference = Difference {
        run,
        versions,
        declared: BTreeMap::new(),
        ends: Vec::new(),
        members: Vec::new(),
        begins: Vec::new(),
        fixed: tables(running, wanted),
    };
    difference.components(running, wanted);
    difference.connections(&running.connections, &wanted.connections);
    difference.wires(running, wanted);
    if difference.fixed.is_empty() {
        Ok([difference.ends, difference.members, difference.begins].concat())
    } else {
        Err(difference.fixed)
    }
}

/// Returns the tables that differ but cannot be changed at run time.
fn tables(running: &Plan, wanted: &Plan) -> Vec<FixedPart> {
    let names = |plan: &Plan| -> BTreeSet<String> {
        let names = plan.components.iter().map(|it| it.name.clone());
        names.collect()
    };
    let kept: BTreeSet<String> = &names(running) & &names(wanted);
    let placed = |plan: &Plan| (processes(plan, &kept), plan.restart.clone());
    let same = [
        ("the name", running.name == wanted.name),
        ("the profile", running.profile == wanted.profile),
        ("`brokers`", running.brokers == wanted.brokers),
        ("`bridges`", running.bridges == wanted.bridges),
        ("`gateways`", running.gateways == wanted.gateways),
        ("`topics`", topics(running, &kept) == topics(wanted, &kept)),
        ("`promote`", running.promoted == wanted.promoted),
        ("`deploy`", placed(running) == placed(wanted)),
    ];
    let differs = same.into_iter().filter(|(_, same)| !same);
    differs.map(|(table, _)| FixedPart::Table(table)).collect()
}

/// The processes of a plan with those of their components that are kept.
fn processes(plan: &Plan, kept: &BTreeSet<String>) -> Vec<Process> {
    let mut processes = plan.processes.clone();
    for process in &mut processes {
        process.components.retain(|name| kept.contains(name));
    }
    processes
}

/// The topics of a plan with those of their ends whose components are kept.
fn topics(plan: &Plan, kept: &BTreeSet<String>) -> Vec<Topic> {
    let topics = plan.topics.iter().map(|topic| {
        let ends = |ends: &[End]| {
            let ends = ends.iter().filter(|end| kept.contains(&end.component));
            ends.cloned().collect::<Vec<_>>()
        };
        Topic {
            // follows from the types of the ports, which are compared with their components
            kind: None,
            publishers: ends(&topic.publishers),
            subscribers: ends(&topic.subscribers),
            ..topic.clone()
        }
    });
    topics
        .filter(|topic| !topic.publishers.is_empty() || !topic.subscribers.is_empty())
        .collect()
}

struct Difference<'p> {
    run: &'p dyn Run,
    /// The running and the wanted version.
    versions: (&'p Version, &'p Version),
    /// Declarations of new components.
    declared: BTreeMap<String, Declaration>,
    /// Removed connections and wires.
    ends: Vec<Change>,
    /// Removed and added components.
    members: Vec<Change>,
    begins: Vec<Change>,
    fixed: Vec<FixedPart>,
}

impl Difference<'_> {
    fn components(&mut self, running: &Plan, wanted: &Plan) {
        for before in &running.components {
            if !self.is_here(&before.name) {
                continue;
            }
            match wanted.component(&before.name) {
                Some(after) => self.component((before, running), (after, wanted)),
                None => self.remove(before),
            }
        }
        let new = |it: &&Component| running.component(&it.name).is_none();
        for component in wanted.components.iter().filter(new) {
            if self.is_here(&component.name) {
                self.add(component);
            }
        }
    }

    /// Returns whether a component runs in this process. None moves to another one.
    fn is_here(&self, component: &str) -> bool {
        let (running, wanted) = self.versions;
        running.part.has(component) || wanted.part.has(component)
    }

    fn remove(&mut self, component: &Component) {
        self.leaving(component, self.versions.0, "removed");
        self.members.push(Change::Remove {
            component: component.name.clone(),
        });
    }

    fn add(&mut self, component: &Component) {
        let wanted = self.versions.1;
        self.leaving(component, wanted, "new");
        if let Some(master) = &component.pace.master {
            self.fixed.push(FixedPart::Slave {
                component: component.name.clone(),
                master: master.clone(),
            });
        }
        let construct = wanted.constructor(component);
        let mut interface = Interface::new();
        // a component that cannot be created is refused by the run
        let declared = construct(&mut interface).map(|_| interface.declaration().clone());
        let declared = declared.unwrap_or_default();
        let activity = start::activity(component, &wanted.plan);
        let mut by = ComponentAddition::new(implementation(component), activity, construct);
        for (name, value) in &component.properties.0 {
            by = by.property(name, value.datum());
        }
        for (output, sample) in &component.lifecycle.safe {
            by = by.safe_sample(output, sample.datum());
        }
        by = on_topics(by, component, &declared, &wanted.plan);
        self.declared.insert(component.name.clone(), declared);
        self.members.push(Change::Add {
            component: component.name.clone(),
            by,
        });
    }

    /// Records the topics and services of a new or removed component that leave the process.
    fn leaving(&mut self, component: &Component, version: &Version, change: &'static str) {
        if version.part.is_alone() {
            return;
        }
        let name = &component.name;
        for topic in &version.plan.topics {
            let mut ends = topic.publishers.iter().chain(&topic.subscribers);
            if ends.any(|end| end.component == *name) {
                self.fixed.push(FixedPart::Topic {
                    component: name.clone(),
                    topic: topic.name.clone(),
                    change,
                });
            }
        }
        let services = component.services.iter().map(|it| FixedPart::Service {
            component: name.clone(),
            service: it.name.clone(),
            change,
        });
        self.fixed.extend(services);
    }

    fn component(&mut self, before: (&Component, &Plan), after: (&Component, &Plan)) {
        let name = &before.0.name;
        if steady(before.0) != steady(after.0) || !has_same_queues(before, after) {
            self.fixed.push(FixedPart::Component(name.clone()));
            return;
        }
        self.begins.extend(self.replacement(before.0, after.0));
        let values = self.values(name, &before.0.properties, &after.0.properties);
        if !values.is_empty() {
            let component = name.clone();
            self.begins.push(Change::Set { component, values });
        }
        let drive = |(it, plan)| start::activity(it, plan).drive;
        let own_pace = after.0.pace.master.is_none();
        if own_pace && drive(before) != drive(after) {
            self.begins.push(Change::SetPeriod {
                component: name.clone(),
                period: drive(after).period().unwrap_or_default(),
            });
        }
    }

    /// Returns the replacement of a coordinator whose specification, bindings or watched properties differ.
    fn replacement(&self, before: &Component, after: &Component) -> Option<Change> {
        let file = specification(after)?;
        let (running, wanted) = self.versions;
        let name = &after.name;
        let has_same_text = running.texts.get(name) == wanted.texts.get(name);
        let has_same_bindings = before.binding == after.binding;
        if has_same_text && has_same_bindings && before.special.watch == after.special.watch {
            return None;
        }
        let (_, shown) = file.rsplit_once('/').unwrap_or(("", file));
        let description = match (has_same_text, has_same_bindings) {
            (false, _) => format!("another version of `{shown}`"),
            (true, false) => format!("`{shown}` with other bindings"),
            (true, true) => format!("`{shown}` with another `watch`"),
        };
        Some(Change::Replace {
            component: name.clone(),
            by: Replacement::new(description, wanted.constructor(after)),
        })
    }

    /// Returns the changed property values; properties no longer set return to their default.
    fn values(
        &self,
        component: &str,
        before: &PropertyValues,
        after: &PropertyValues,
    ) -> Vec<(String, Datum)> {
        let declared = self.run.declaration(component).unwrap_or_default();
        let set = after
            .0
            .iter()
            .filter(|(name, value)| before.get(name) != Some(value));
        let unset = before
            .0
            .iter()
            .filter(|(name, _)| after.get(name).is_none());
        let default = |(name, _): &(String, _)| {
            let default = declared.property(name)?.default.clone();
            Some((name.clone(), default))
        };
        set.map(|(name, value)| (name.clone(), value.datum()))
            .chain(unset.filter_map(default))
            .collect()
    }

    fn connections(&mut self, before: &[Connection], after: &[Connection]) {
        for it in before.iter().filter(|it| !after.contains(it)) {
            if let Some((from, to)) = self.ports(it) {
                let (from, to) = (from.to_string(), to.to_string());
                self.ends.push(Change::Disconnect { from, to });
            }
        }
        for it in after.iter().filter(|it| !before.contains(it)) {
            if let Some((from, to)) = self.ports(it) {
                self.begins.push(Change::Connect {
                    from: from.to_string(),
                    to: to.to_string(),
                    policy: start::policy(it),
                });
            }
        }
    }

    /// Returns the ends of a connection within this part. Records a connection that crosses its boundary as fixed;
    /// connections of other parts are ignored.
    fn ports<'c>(&mut self, connection: &'c Connection) -> Option<(&'c End, &'c End)> {
        let Connection { from, to, .. } = connection;
        let here = |terminal: &Terminal| match terminal {
            Terminal::Port(end) => self.is_here(&end.component),
            Terminal::Topic(_) | Terminal::Mqueue(_) => false,
        };
        match (from, to) {
            // topics of new and removed components are part of these
            (Terminal::Port(end), Terminal::Topic(_))
            | (Terminal::Topic(_), Terminal::Port(end))
                if !self.is_kept(&end.component) =>
            {
                None
            }
            (Terminal::Port(one), Terminal::Port(other)) if here(from) && here(to) => {
                Some((one, other))
            }
            _ => {
                if here(from) || here(to) {
                    let (from, to) = (from.to_string(), to.to_string());
                    self.fixed.push(FixedPart::Connection { from, to });
                }
                None
            }
        }
    }

    /// Returns whether a component is neither new nor removed.
    fn is_kept(&self, component: &str) -> bool {
        let (running, wanted) = self.versions;
        let mut plans = [&running.plan, &wanted.plan].into_iter();
        plans.all(|plan| plan.component(component).is_some())
    }

    fn wires(&mut self, before: &Plan, after: &Plan) {
        let (running, wanted) = self.versions;
        let (before, after) = (joints(before, &running.part), joints(after, &wanted.part));
        for it in before.iter().filter(|it| !after.contains(it)) {
            if let Some((reference, service)) = self.ends_of(it) {
                self.ends.push(Change::Unwire { reference, service });
            }
        }
        for it in after.iter().filter(|it| !before.contains(it)) {
            if let Some((reference, service)) = self.ends_of(it) {
                self.begins.push(Change::Wire {
                    reference,
                    service,
                    wire: it.how,
                });
            }
        }
    }

    /// Returns the ends of a wire within this part if the component declares the reference.
    fn ends_of(&mut self, joint: &WiredService<'_>) -> Option<(String, String)> {
        let reference = joint.reference;
        if !self.is_here(&reference.component) {
            return None;
        }
        let (from, to) = (reference.to_string(), joint.service.clone());
        if !joint.stays_here {
            let (reference, service) = (from, to);
            self.fixed.push(FixedPart::Wire { reference, service });
            return None;
        }
        let new = self.declared.get(&reference.component).cloned();
        let declared = new.or_else(|| self.run.declaration(&reference.component))?;
        declared.reference(&reference.name)?;
        Some((from, to))
    }
}

/// One service of a wire.
#[derive(PartialEq)]
struct WiredService<'p> {
    reference: &'p End,
    /// A service of the plan, or a URL.
    service: String,
    token: Option<&'p Endpoint>,
    /// File with the certificate authorities.
    authorities: Option<&'p str>,
    /// Broker of a call that leaves the part.
    broker: Option<&'p str>,
    how: asmotion_component::Wire,
    /// `true` if both ends run in this part and the call does not go over a bus.
    stays_here: bool,
}

fn joints<'p>(plan: &'p Plan, part: &Part) -> Vec<WiredService<'p>> {
    let wires: &'p [Wire] = &plan.wires;
    let mut joints = Vec::new();
    for wire in wires {
        let broker = plan.broker_of_wire(wire);
        joints.extend(wire.services.iter().map(|service| {
            let stays_here = start::stays_here(wire, service, part);
            WiredService {
                reference: &wire.reference,
                service: service.to_string(),
                token: None,
                authorities: None,
                broker: broker.filter(|_| !stays_here),
                how: start::how(wires, wire),
                stays_here,
            }
        }));
        joints.extend(wire.url.iter().map(|url| WiredService {
            reference: &wire.reference,
            service: url.shown().to_owned(),
            token: wire.token.as_ref(),
            authorities: wire.ca.as_deref(),
            broker,
            how: start::how(wires, wire),
            stays_here: false,
        }));
    }
    joints
}

/// Adds the topics of a component within this process, as at its start.
fn on_topics(
    mut by: ComponentAddition,
    component: &Component,
    declared: &Declaration,
    plan: &Plan,
) -> ComponentAddition {
    for port in &component.outputs {
        if let (Some(topic), Some(_)) = (&port.topic, declared.output(&port.name)) {
            by = by.publish(&port.name, topic);
        }
    }
    for port in &component.inputs {
        if let (Some(topic), Some(_)) = (&port.topic, declared.input(&port.name)) {
            let policy = start::subscription_policy(plan, component, &port.name, topic);
            by = by.subscribe(topic, &port.name, policy);
        }
    }
    for connection in &plan.connections {
        match (&connection.from, &connection.to) {
            (Terminal::Port(from), Terminal::Topic(topic)) if from.component == component.name => {
                by = by.publish(&from.name, topic);
            }
            (Terminal::Topic(topic), Terminal::Port(to)) if to.component == component.name => {
                by = by.subscribe(topic, &to.name, start::policy(connection));
            }
            // the others are of other components, or connected as ports
            (Terminal::Port(_) | Terminal::Topic(_) | Terminal::Mqueue(_), _) => {}
        }
    }
    by
}

/// Names the implementation of a component for the operator.
fn implementation(component: &Component) -> String {
    match &component.implementation {
        Implementation::Asm { file, .. } => {
            let (_, shown) = file.rsplit_once('/').unwrap_or(("", file));
            format!("`{shown}`")
        }
        Implementation::Rust(name) | Implementation::Builtin { name, .. } => format!("`{name}`"),
        Implementation::Process { command, .. } => format!("the program `{}`", command.join(" ")),
        Implementation::Ros { .. } => "a ROS node".to_owned(),
        Implementation::Orocos { .. } => "an Orocos component".to_owned(),
    }
}

/// Returns the file of the specification that a component runs.
fn specification(component: &Component) -> Option<&str> {
    match &component.implementation {
        Implementation::Asm { file, .. } => Some(file),
        Implementation::Rust(_)
        | Implementation::Builtin { .. }
        | Implementation::Process { .. }
        | Implementation::Ros { .. }
        | Implementation::Orocos { .. } => None,
    }
}

/// Returns whether the subscriptions of two versions of a component have equal queues, whose sizes depend on the bindings.
fn has_same_queues(before: (&Component, &Plan), after: (&Component, &Plan)) -> bool {
    before.0.inputs.iter().all(|port| {
        let policy = |(component, plan): (&Component, &Plan)| {
            let topic = port.topic.as_ref()?;
            let policy = start::subscription_policy(plan, component, &port.name, topic);
            Some(policy.kind)
        };
        policy(before) == policy(after)
    })
}

/// Returns a component without the values that can be changed at run time.
fn steady(component: &Component) -> Component {
    let mut component = component.clone();
    if let Implementation::Asm { file, main } = &mut component.implementation {
        file.clear();
        *main = None;
        component.binding = None;
        component.special.watch = None;
    }
    component.properties = PropertyValues::default();
    component.pace = asmotion_plan::Pace {
        period_ms: 0,
        ..component.pace
    };
    component
}
