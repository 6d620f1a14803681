//! Changes of a running system to another plan.

use std::collections::BTreeMap;
use std::sync::Arc;

use asmotion_datum::Datum;
use asmotion_diagnostics::Loader;
use asmotion_runtime::{Change, Replacement, Run};

use crate::start;
use asmotion_plan::{
    Component, Connection, End, Endpoint, Implementation, Part, Plan, PropertyValues, Terminal,
    Wire,
};

/// A version of a system: a plan, and the texts of its specifications.
#[derive(Clone)]
pub struct Version {
    /// The plan of the version.
    pub plan: Plan,
    loader: Arc<dyn Loader + Send + Sync>,
    seed: u64,
    /// The texts of each component's specification and its imports, in the order in which they are loaded.
    texts: BTreeMap<String, Vec<Arc<str>>>,
}

impl Version {
    /// Reads the specifications of a part of a plan. The seed is that of [`Standard`](crate::Standard).
    pub fn new(plan: Plan, part: &Part, loader: Arc<dyn Loader + Send + Sync>, seed: u64) -> Self {
        let here = plan.components.iter().filter(|it| part.has(&it.name));
        let texts = here.filter_map(|component| {
            let file = specification(component)?;
            let texts = start::specification_texts(file, &*loader);
            Some((component.name.clone(), texts))
        });
        Self {
            texts: texts.collect(),
            plan,
            loader,
            seed,
        }
    }
}

/// A difference between two plans that requires a restart.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum FixedPart {
    /// A table of the composite.
    #[error("{0} of the composite")]
    Table(&'static str),
    /// A new component.
    #[error("`{0}` is new")]
    Added(String),
    /// A removed component.
    #[error("`{0}` is removed")]
    Removed(String),
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

/// Returns the changes that turn a running part of a plan into that of another plan.
///
/// # Errors
///
/// All differences that require a restart.
pub fn changes(
    running: &Version,
    wanted: &Version,
    part: &Part,
    run: &dyn Run,
) -> Result<Vec<Change>, Vec<FixedPart>> {
    let versions = (running, wanted);
    let (running, wanted) = (&running.plan, &wanted.plan);
    let mut difference = Difference {
        part,
        run,
        versions,
        ends: Vec::new(),
        begins: Vec::new(),
        fixed: tables(running, wanted),
    };
    difference.components(running, wanted);
    difference.connections(&running.connections, &wanted.connections);
    difference.wires(&running.wires, &wanted.wires);
    if difference.fixed.is_empty() {
        Ok([difference.ends, difference.begins].concat())
    } else {
        Err(difference.fixed)
    }
}

/// Returns the tables that differ but cannot be changed at run time.
fn tables(running: &Plan, wanted: &Plan) -> Vec<FixedPart> {
    let placed = |plan: &Plan| (plan.processes.clone(), plan.restart.clone());
    let same = [
        ("the name", running.name == wanted.name),
        ("the profile", running.profile == wanted.profile),
        ("`brokers`", running.brokers == wanted.brokers),
        ("`bridges`", running.bridges == wanted.bridges),
        ("`gateways`", running.gateways == wanted.gateways),
        ("`topics`", running.topics == wanted.topics),
        ("`promote`", running.promoted == wanted.promoted),
        ("`deploy`", placed(running) == placed(wanted)),
    ];
    let differs = same.into_iter().filter(|(_, same)| !same);
    differs.map(|(table, _)| FixedPart::Table(table)).collect()
}

struct Difference<'p> {
    part: &'p Part,
    run: &'p dyn Run,
    /// The running and the wanted version.
    versions: (&'p Version, &'p Version),
    /// Removals, applied before any addition.
    ends: Vec<Change>,
    begins: Vec<Change>,
    fixed: Vec<FixedPart>,
}

impl Difference<'_> {
    fn components(&mut self, running: &Plan, wanted: &Plan) {
        for before in &running.components {
            match wanted.component(&before.name) {
                Some(after) if self.part.has(&before.name) => {
                    self.component((before, running), (after, wanted));
                }
                Some(_) => {}
                None => self.fixed.push(FixedPart::Removed(before.name.clone())),
            }
        }
        let new = |it: &&Component| running.component(&it.name).is_none();
        let new = wanted.components.iter().filter(new);
        self.fixed
            .extend(new.map(|it| FixedPart::Added(it.name.clone())));
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

    /// Returns the replacement of a coordinator whose specification or bindings differ.
    fn replacement(&self, before: &Component, after: &Component) -> Option<Change> {
        let file = specification(after)?;
        let (running, wanted) = self.versions;
        let name = &after.name;
        let has_same_text = running.texts.get(name) == wanted.texts.get(name);
        if has_same_text && before.binding == after.binding {
            return None;
        }
        let (_, shown) = file.rsplit_once('/').unwrap_or(("", file));
        let description = if has_same_text {
            format!("`{shown}` with other bindings")
        } else {
            format!("another version of `{shown}`")
        };
        let (version, component) = (wanted.clone(), after.clone());
        let construct = start::coordinator(component, version.plan, version.loader, version.seed);
        Some(Change::Replace {
            component: name.clone(),
            by: Replacement::new(description, construct),
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
            Terminal::Port(end) => self.part.has(&end.component),
            Terminal::Topic(_) | Terminal::Mqueue(_) => false,
        };
        match (from, to) {
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

    fn wires(&mut self, before: &[Wire], after: &[Wire]) {
        let (before, after) = (joints(before, self.part), joints(after, self.part));
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
        if !self.part.has(&reference.component) {
            return None;
        }
        let (from, to) = (reference.to_string(), joint.service.clone());
        if !joint.stays_here {
            let (reference, service) = (from, to);
            self.fixed.push(FixedPart::Wire { reference, service });
            return None;
        }
        let declared = self.run.declaration(&reference.component)?;
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
    how: asmotion_component::Wire,
    /// `true` if both ends run in this part and the call does not go over a bus.
    stays_here: bool,
}

fn joints<'p>(wires: &'p [Wire], part: &Part) -> Vec<WiredService<'p>> {
    let mut joints = Vec::new();
    for wire in wires {
        joints.extend(wire.services.iter().map(|service| WiredService {
            reference: &wire.reference,
            service: service.to_string(),
            token: None,
            how: start::how(wires, wire),
            stays_here: start::stays_here(wire, service, part),
        }));
        joints.extend(wire.url.iter().map(|url| WiredService {
            reference: &wire.reference,
            service: url.shown().to_owned(),
            token: wire.token.as_ref(),
            how: start::how(wires, wire),
            stays_here: false,
        }));
    }
    joints
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
    }
    component.properties = PropertyValues::default();
    component.pace = asmotion_plan::Pace {
        period_ms: 0,
        ..component.pace
    };
    component
}
