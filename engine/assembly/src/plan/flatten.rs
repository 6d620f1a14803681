//! Opens nested composites, follows promotions and renames down to the components that run.

use std::collections::BTreeMap;

use source::{Diagnostic, Sources, Span};

use super::{
    Bridge, Broker, Connection, End, Endpoint, Plan, Policy, Promoted, Settings, Terminal, Topic,
    Wire, order, part, place,
};
use crate::At;
use crate::check::{self, Faces};
use crate::context::Context;
use crate::family::{Family, Member};
use crate::finding::{Finding, Findings};
use crate::model::{self, Amount, Composite, Delivery, Flow, Template, Transport};
use crate::scope::{Notes, Scope, SettingError, from_text};
use crate::types::Types;
use crate::value::Value;

/// More components are the work of a mistake, or of somebody unkind.
const MAX_COMPONENTS: usize = 10_000;

#[derive(Debug, thiserror::Error)]
pub(crate) enum FlattenError {
    #[error("opened up, this composite has more than {MAX_COMPONENTS} components")]
    TooMany { at: Span },
    #[error("`{to}` looks every {poll_ms} ms, but `{from}` writes every {period_ms} ms")]
    PollTooSlow { from: String, to: String, poll_ms: u64, period_ms: u64, at: Span },
}

impl Finding for FlattenError {
    fn diagnostic(&self) -> Diagnostic {
        match self {
            Self::TooMany { at } => {
                Diagnostic::error("C082", self).label(*at, "given up here")
            }
            Self::PollTooSlow { poll_ms, period_ms, at, .. } => {
                let missed = (poll_ms / period_ms).saturating_sub(1);
                let lost = match missed {
                    0 => "some values are seen late".to_owned(),
                    _ => format!("{missed} of {} values are lost", missed + 1),
                };
                Diagnostic::warning("C054", self)
                    .label(*at, lost)
                    .help(format!(
                        "look at least every {} ms, or say `delivery = \"event\"`",
                        (period_ms / 2).max(1)
                    ))
            }
        }
    }
}

/// What the plan is made of.
pub(crate) struct Parts<'p> {
    pub family: &'p Family,
    pub types: &'p BTreeMap<&'p str, Types<'p>>,
    pub faces: &'p BTreeMap<String, Faces>,
    pub context: &'p Context<'p>,
    pub sources: &'p Sources,
    pub profile: Option<&'p str>,
}

/// Flattens a composite in one profile. What is wrong goes to the notes; the plan is then of use
/// only to those who look at it.
pub(crate) fn flatten(parts: &Parts<'_>, notes: &mut Notes) -> Option<Plan> {
    let member = parts.family.member(&parts.family.root)?;
    let plan = blank(&member.composite, parts.profile);
    let mut flattener = Flattener { parts, notes, plan, instances: Vec::new(), full: false };
    let set = flattener.settings(&member.composite);
    flattener.instance(&parts.family.root, member, None, set);
    for index in 0..flattener.instances.len() {
        flattener.join(index);
    }
    flattener.finish(member)
}

fn blank(composite: &Composite, profile: Option<&str>) -> Plan {
    Plan {
        name: composite.name.value.clone(),
        version: composite.version.as_ref().map(|version| version.value.clone()),
        profile: profile.map(str::to_owned),
        missing: Vec::new(),
        start_order: Vec::new(),
        properties: Settings::default(),
        brokers: Vec::new(),
        bridges: Vec::new(),
        components: Vec::new(),
        topics: Vec::new(),
        connections: Vec::new(),
        wires: Vec::new(),
        promoted: Vec::new(),
        processes: Vec::new(),
        restart: None,
        record: None,
    }
}

/// Values set from outside a composite: by name, `None` where the value is not known.
type Set = BTreeMap<String, (Option<Value>, Option<Span>)>;

/// A composite at one place of the system.
pub(super) struct Instance<'p> {
    /// The names of the composites it is nested in: `Driver/`; empty for the outermost.
    pub prefix: String,
    /// The path of its file.
    path: &'p str,
    member: &'p Member,
    /// Which instance it is nested in, and as which component.
    parent: Option<(usize, &'p model::Component)>,
    /// Its nested composites.
    children: BTreeMap<&'p str, usize>,
    scope: Scope<'p>,
    /// Promoted properties of its components that were set from outside.
    overrides: BTreeMap<(String, String), (Option<Value>, Option<Span>)>,
}

struct Flattener<'p, 'n> {
    parts: &'p Parts<'p>,
    notes: &'n mut Notes,
    plan: Plan,
    instances: Vec<Instance<'p>>,
    /// There are too many components.
    full: bool,
}

impl<'p> Flattener<'p, '_> {
    /// The properties that are set from outside all files.
    fn settings(&mut self, composite: &Composite) -> Set {
        let mut set = Set::new();
        for (name, text) in self.parts.context.settings {
            let Some(property) = composite.properties.iter().find(|it| it.name.value == *name)
            else {
                let known = composite.properties.iter().map(|it| it.name.value.as_str());
                let nearest = crate::nearest::nearest_name(name, known);
                self.notes.found(SettingError::Unknown { name: name.clone(), at: None, nearest });
                continue;
            };
            let value = from_text(text, property.kind.value);
            let value = value.unwrap_or_else(|| Value::Text(text.clone()));
            set.insert(name.clone(), (Some(value), None));
        }
        set
    }

    /// Adds a composite and everything in it.
    fn instance(
        &mut self,
        path: &'p str,
        member: &'p Member,
        parent: Option<(usize, &'p model::Component)>,
        set: Set,
    ) -> usize {
        let composite = &member.composite;
        let prefix = parent.map_or(String::new(), |(parent, component)| {
            let outer = self.instances.get(parent).map_or("", |parent| &parent.prefix);
            format!("{outer}{}/", component.name.value)
        });
        let (own, overrides) = split(composite, set);
        let scope = Scope::new(
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
            self.plan.properties = Settings(known.collect());
        }
        let index = self.instances.len();
        let children = BTreeMap::new();
        self.instances.push(Instance { prefix, path, member, parent, children, scope, overrides });
        self.endpoints(index, composite);
        for component in &composite.components {
            if check::takes_part(&component.profiles, self.parts.profile) {
                self.component(index, member, component);
            }
        }
        index
    }

    fn component(&mut self, index: usize, member: &'p Member, component: &'p model::Component) {
        if self.plan.components.len() >= MAX_COMPONENTS {
            if !self.full {
                self.notes.found(FlattenError::TooMany { at: component.name.span });
            }
            self.full = true;
            return;
        }
        let Some(instance) = self.instances.get(index) else {
            return;
        };
        let mut set = Set::new();
        for setting in &component.properties {
            let value = instance.scope.node(&setting.value, self.notes);
            set.insert(setting.name.value.clone(), (value, Some(setting.value.span)));
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
        let source = part::Source {
            member,
            component,
            face,
            types,
            prefix: &instance.prefix,
            scope: &instance.scope,
            catalogue: self.parts.context.catalogue,
        };
        let mut made = part::component(&source, set, self.notes);
        for port in made.inputs.iter_mut().chain(&mut made.outputs) {
            port.topic = port.topic.take().map(|topic| self.topic(index, &topic));
        }
        self.plan.components.push(made);
    }

    fn endpoints(&mut self, index: usize, composite: &Composite) {
        let Some(instance) = self.instances.get(index) else {
            return;
        };
        for broker in &composite.brokers {
            secret(&broker.url, self.notes);
            let reconnect = broker.reconnect.as_ref();
            self.plan.brokers.push(Broker {
                name: format!("{}{}", instance.prefix, broker.name.value),
                url: endpoint(&instance.scope, &broker.url, self.notes),
                exchange: broker
                    .exchange
                    .as_ref()
                    .map_or_else(|| composite.name.value.clone(), |name| name.value.clone()),
                codec: given(&broker.codec),
                tls: given(&broker.tls),
                reconnect_first_ms: reconnect.and_then(|it| number(&it.first_ms)).unwrap_or(100),
                reconnect_max_ms: reconnect.and_then(|it| number(&it.max_ms)).unwrap_or(5000),
                reconnect_jitter: reconnect
                    .and_then(|it| it.jitter.as_ref())
                    .map_or(0.2, |jitter| jitter.value),
            });
        }
        for bridge in &composite.bridges {
            let url = bridge.master.as_ref().or(bridge.url.as_ref());
            self.plan.bridges.push(Bridge {
                name: format!("{}{}", instance.prefix, bridge.name.value),
                kind: bridge.kind.value,
                url: url.and_then(|url| endpoint(&instance.scope, url, self.notes)),
                domain: number(&bridge.domain),
                node: bridge.node.as_ref().map(|node| node.value.clone()),
            });
        }
    }

    /// Adds the connections and wires of a composite.
    fn join(&mut self, index: usize) {
        let Some(composite) = self.composite(index) else {
            return;
        };
        for connection in &composite.connections {
            if check::takes_part(&connection.profiles, self.parts.profile) {
                self.connection(index, connection);
            }
        }
        for wire in &composite.wires {
            if check::takes_part(&wire.profiles, self.parts.profile) {
                self.wire(index, wire);
            }
        }
    }

    fn composite(&self, index: usize) -> Option<&'p Composite> {
        self.instances.get(index).map(|instance| &instance.member.composite)
    }

    fn connection(&mut self, index: usize, connection: &model::Connection) {
        let policy = policy(&connection.policy);
        for from in &connection.from {
            for to in &connection.to {
                let source = self.terminal(index, from);
                let target = self.terminal(index, to);
                if let (Some(source), Some(target)) = (source, target) {
                    let (from, to) = (source, target);
                    self.poll(&from, &to, &policy, connection.policy.span);
                    let policy = policy.clone();
                    self.plan.connections.push(Connection { from, to, policy });
                }
            }
        }
    }

    /// Whoever polls must look at least twice as often as somebody writes.
    fn poll(&mut self, from: &Terminal, to: &Terminal, policy: &Policy, at: Span) {
        let (Terminal::Port(end), Some(poll_ms)) = (from, policy.poll_ms) else {
            return;
        };
        let writer = self.plan.component(&end.component);
        let period_ms = writer.map_or(0, |component| component.pace.period_ms);
        if policy.delivery == Delivery::Poll && period_ms > 0 && poll_ms * 2 > period_ms {
            let (from, to) = (from.to_string(), to.to_string());
            self.notes.found(FlattenError::PollTooSlow { from, to, poll_ms, period_ms, at });
        }
    }

    fn terminal(&self, index: usize, terminal: &model::Terminal) -> Option<Terminal> {
        match terminal {
            model::Terminal::Topic(topic) => Some(Terminal::Topic(self.topic(index, topic))),
            model::Terminal::Port(end) => {
                let port = |what: &'p model::Promoted| match what {
                    model::Promoted::Port(end) => Some(end),
                    _ => None,
                };
                self.inside(index, end, &port).map(Terminal::Port)
            }
        }
    }

    fn wire(&mut self, index: usize, wire: &'p model::Wire) {
        let reference = |what: &'p model::Promoted| match what {
            model::Promoted::Reference(end) => Some(end),
            _ => None,
        };
        let service = |what: &'p model::Promoted| match what {
            model::Promoted::Service(end) => Some(end),
            _ => None,
        };
        let Some(reference) = self.inside(index, &wire.reference, &reference) else {
            return;
        };
        let services: Vec<End> =
            wire.services.iter().filter_map(|end| self.inside(index, end, &service)).collect();
        if services.is_empty() {
            return;
        }
        let binding = given(&wire.binding);
        let interface = self.plan.component(&reference.component).and_then(|component| {
            component.references.iter().find(|known| known.name == reference.name)
        });
        let retry = wire.retry.as_ref();
        self.plan.wires.push(Wire {
            interface: interface.map_or(String::new(), |known| known.interface.clone()),
            reference,
            services,
            binding,
            broker: self.broker(index, binding, wire.broker.as_ref()),
            timeout_ms: number(&wire.timeout_ms).unwrap_or(check::DEFAULT_TIMEOUT_MS),
            retry_attempts: retry.and_then(|retry| number(&retry.attempts)).unwrap_or(0),
            retry_backoff_ms: retry.and_then(|retry| number(&retry.backoff_ms)).unwrap_or(0),
            cancel: given(&wire.cancel),
            oneway: !check::waits(wire),
        });
    }

    /// The broker that something goes over.
    fn broker(
        &self,
        index: usize,
        binding: Transport,
        named: Option<&At<String>>,
    ) -> Option<String> {
        let instance = self.instances.get(index)?;
        let only = || match instance.member.composite.brokers.as_slice() {
            [only] if binding == Transport::Amqp => Some(&only.name),
            _ => None,
        };
        let name = named.or_else(only)?;
        Some(format!("{}{}", instance.prefix, name.value))
    }

    /// The component that runs, and its part, behind a name that may be promoted.
    fn inside(
        &self,
        index: usize,
        end: &model::End,
        select: &impl Fn(&'p model::Promoted) -> Option<&'p model::End>,
    ) -> Option<End> {
        let instance = self.instances.get(index)?;
        if let Some(child) = instance.children.get(end.component.value.as_str()) {
            let promotions = &self.composite(*child)?.promotions;
            let promotion = promotions.iter().find(|promotion| {
                promotion.name.value == end.name.value
                    && select(&promotion.what).is_some()
                    && check::takes_part(&promotion.profiles, self.parts.profile)
            })?;
            return self.inside(*child, select(&promotion.what)?, select);
        }
        let component = format!("{}{}", instance.prefix, end.component.value);
        self.plan.component(&component)?;
        Some(End { component, name: end.name.value.clone() })
    }

    /// What a topic is called in the whole system: a nested composite keeps its topics to itself,
    /// unless it promotes them.
    fn topic(&self, index: usize, name: &str) -> String {
        let Some(instance) = self.instances.get(index) else {
            return name.to_owned();
        };
        let Some((parent, component)) = instance.parent else {
            return name.to_owned();
        };
        let promotion = instance.member.composite.promotions.iter().find(|promotion| {
            check::takes_part(&promotion.profiles, self.parts.profile)
                && matches!(&promotion.what, model::Promoted::Topic(topic) if topic.value == name)
        });
        match promotion {
            Some(promotion) => {
                self.topic(parent, &check::topic(component, &promotion.name.value))
            }
            None => format!("{}{name}", instance.prefix),
        }
    }

    fn finish(mut self, member: &'p Member) -> Option<Plan> {
        let composite = &member.composite;
        for promotion in &composite.promotions {
            if check::takes_part(&promotion.profiles, self.parts.profile) {
                self.promotion(promotion);
            }
        }
        self.topics(composite);
        place::place(composite, &self.instances_by_name(), &mut self.plan);
        self.plan.start_order = order::start_order(&self.plan);
        self.plan.missing = self.notes.missing.clone();
        Some(self.plan)
    }

    /// The components of each nested composite of the outermost one.
    fn instances_by_name(&self) -> BTreeMap<&'p str, String> {
        let outermost = self.instances.first();
        let children = outermost.into_iter().flat_map(|instance| &instance.children);
        children
            .filter_map(|(name, child)| Some((*name, self.instances.get(*child)?.prefix.clone())))
            .collect()
    }

    fn promotion(&mut self, promotion: &'p model::Promotion) {
        use crate::model::Promoted as What;
        let own = |what: &'p What| match what {
            What::Service(end) | What::Reference(end) | What::Property(end) | What::Port(end) => {
                Some(end)
            }
            What::Topic(_) => None,
        };
        let kind = promotion.what.kind();
        let same = |what: &'p What| own(what).filter(|_| what.kind() == kind);
        let inside = match &promotion.what {
            What::Topic(topic) => Some(topic.value.clone()),
            what => own(what)
                .and_then(|end| self.inside(0, end, &same))
                .map(|end| end.to_string()),
        };
        let Some(inside) = inside else {
            return;
        };
        let binding = given(&promotion.binding);
        self.plan.promoted.push(Promoted {
            what: promotion.what.kind(),
            name: promotion.name.value.clone(),
            inside,
            binding,
            broker: self.broker(0, binding, promotion.broker.as_ref()),
        });
    }

    /// Collects the topics out of ports and connections.
    fn topics(&mut self, composite: &Composite) {
        let mut topics: BTreeMap<String, Topic> = BTreeMap::new();
        let mut roles: Vec<(String, End, bool)> = Vec::new();
        for component in &self.plan.components {
            for (ports, writes) in [(&component.inputs, false), (&component.outputs, true)] {
                for port in ports {
                    if let Some(topic) = &port.topic {
                        let (component, name) = (component.name.clone(), port.name.clone());
                        roles.push((topic.clone(), End { component, name }, writes));
                    }
                }
            }
        }
        for connection in &self.plan.connections {
            match (&connection.from, &connection.to) {
                (Terminal::Port(end), Terminal::Topic(topic)) => {
                    roles.push((topic.clone(), end.clone(), true));
                }
                (Terminal::Topic(topic), Terminal::Port(end)) => {
                    roles.push((topic.clone(), end.clone(), false));
                }
                (Terminal::Port(_), Terminal::Port(_))
                | (Terminal::Topic(_), Terminal::Topic(_)) => {}
            }
        }
        for (name, end, writes) in roles {
            let kind = self.kind(&end, writes);
            let topic = topics.entry(name.clone()).or_insert_with(|| Topic {
                name: name.clone(),
                kind: None,
                promoted: false,
                publishers: Vec::new(),
                subscribers: Vec::new(),
            });
            topic.kind = topic.kind.take().or(kind);
            match writes {
                true => topic.publishers.push(end),
                false => topic.subscribers.push(end),
            }
        }
        for promotion in &composite.promotions {
            if let model::Promoted::Topic(topic) = &promotion.what
                && check::takes_part(&promotion.profiles, self.parts.profile)
                && let Some(topic) = topics.get_mut(&topic.value)
            {
                topic.promoted = true;
            }
        }
        self.plan.topics = topics.into_values().collect();
    }

    fn kind(&self, end: &End, writes: bool) -> Option<String> {
        let component = self.plan.component(&end.component)?;
        let ports = if writes { &component.outputs } else { &component.inputs };
        let port = ports.iter().find(|port| port.name == end.name)?;
        (!port.kind.is_empty()).then(|| port.kind.clone())
    }
}

/// Which of the values go to properties of the composite, and which to promoted ones.
fn split(
    composite: &Composite,
    set: Set,
) -> (Set, BTreeMap<(String, String), (Option<Value>, Option<Span>)>) {
    let mut own = Set::new();
    let mut overrides = BTreeMap::new();
    for (name, value) in set {
        let promoted = composite.promotions.iter().find_map(|promotion| match &promotion.what {
            model::Promoted::Property(end) if promotion.name.value == name => Some(end),
            _ => None,
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

fn endpoint(scope: &Scope<'_>, url: &At<Template>, notes: &mut Notes) -> Option<Endpoint> {
    scope.fill(url, notes).map(|filled| Endpoint::new(filled.text, filled.shown))
}

/// A password that stands in the file is read by everybody who has the file.
fn secret(url: &At<Template>, notes: &mut Notes) {
    let pieces = url.pieces.iter().map(|piece| match piece {
        model::Piece::Text(text) => text.as_str(),
        model::Piece::Property { .. } | model::Piece::Variable { .. } => SUBSTITUTED,
    });
    let written: String = pieces.collect();
    let password = super::password(&written).and_then(|range| written.get(range));
    if let Some(password) = password
        && !password.is_empty()
        && !password.contains(SUBSTITUTED)
        && password != PUBLIC_PASSWORD
    {
        notes.found(SettingError::SecretInFile { at: url.span });
    }
}

/// Stands for what is not written in the file.
const SUBSTITUTED: &str = "\u{1}";

/// RabbitMQ's password for everybody on the same machine.
const PUBLIC_PASSWORD: &str = "guest";

/// A word, or its default.
pub(super) fn given<T: Copy + Default>(word: &Option<At<T>>) -> T {
    word.as_ref().map(|word| word.value).unwrap_or_default()
}

/// A number that was checked not to be negative.
pub(super) fn number(number: &Option<At<i64>>) -> Option<u64> {
    number.as_ref().and_then(|number| u64::try_from(number.value).ok())
}

/// A number that may come from a property.
pub(super) fn amount(
    scope: &Scope<'_>,
    name: &str,
    amount: &Option<At<Amount>>,
    least: i64,
    notes: &mut Notes,
) -> Option<u64> {
    let range = least..=crate::read::DAY_MS;
    let number = scope.amount(name, amount.as_ref()?, range, notes)?;
    u64::try_from(number).ok()
}

fn policy(policy: &model::Policy) -> Policy {
    let kind = given(&policy.kind);
    Policy {
        kind,
        size: match kind {
            Flow::Data => 1,
            Flow::Buffer | Flow::Circular => number(&policy.size).unwrap_or(1),
        },
        lock: given(&policy.lock),
        init: given(&policy.init),
        pull: given(&policy.pull),
        mandatory: given(&policy.mandatory),
        buffer: given(&policy.buffer),
        max_threads: number(&policy.max_threads).unwrap_or(2),
        max_age_ms: number(&policy.max_age_ms),
        on_stale: given(&policy.on_stale),
        delivery: given(&policy.delivery),
        poll_ms: number(&policy.poll_ms),
    }
}
