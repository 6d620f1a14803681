//! Resolves connections, wires and promotions to running components.

use crate::codes::c054::PollTooSlow;
use crate::codes::c156::QueueNeeded;
use asmotion_diagnostics::Span;

use super::{Flattener, endpoint};
use crate::joint::{Connection, Promoted};
use crate::plan::{End, Policy, Terminal};
use asmotion_composite::finding::Findings;
use asmotion_composite::model::{self, ConnectionType, Delivery, Sharing, Transport};
use asmotion_composite::table::Resolver;
use asmotion_composite::{At, check};
use asmotion_coordinator::{Monitored, Receive, Source};

impl Flattener<'_, '_> {
    /// Adds the connections and wires of a composite instance.
    pub(super) fn join(&mut self, index: usize) {
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

    fn connection(&mut self, index: usize, connection: &model::Connection) {
        let Some(policy) = self.policy(index, &connection.policy) else {
            return;
        };
        let ends = |terminals: &[model::Terminal]| -> Vec<Terminal> {
            let ends = terminals.iter();
            ends.filter_map(|end| self.terminal(index, end)).collect()
        };
        let (from, to) = (ends(&connection.from), ends(&connection.to));
        if policy.kind == ConnectionType::Data {
            for end in &connection.to {
                self.queue_needed(index, end);
            }
        }
        let shared = policy.buffer == Sharing::Shared;
        let queue = shared.then(|| format!("{} -> {}", listed(&from), listed(&to)));
        for from in &from {
            for to in &to {
                self.poll(from, to, &policy, connection.policy.span);
                self.plan.connections.push(Connection {
                    from: from.clone(),
                    to: to.clone(),
                    policy: policy.clone(),
                    queue: queue.clone(),
                });
            }
        }
    }

    /// Warns if a connection that holds one message ends at an input of which a specification reads all.
    fn queue_needed(&mut self, index: usize, to: &model::Terminal) {
        let Some(Terminal::Port(end)) = self.terminal(index, to) else {
            return;
        };
        let component = self.plan.component(&end.component);
        let Some(binding) = component.and_then(|it| it.binding.as_ref()) else {
            return;
        };
        let reads_all = |it: &&Monitored| {
            let is_of_port = matches!(&it.from, Source::Port(port) if *port == end.name);
            is_of_port && (it.receive == Receive::All || !it.key.is_empty())
        };
        if let Some(bound) = binding.monitored.iter().find(reads_all) {
            self.notes.found(QueueNeeded {
                function: bound.location.to_string(),
                to: end.to_string(),
                at: to.span(),
            });
        }
    }

    /// Warns if the polling interval exceeds half the period of the writer. A reader with a period of its own does not poll.
    fn poll(&mut self, from: &Terminal, to: &Terminal, policy: &Policy, at: Span) {
        let (Terminal::Port(end), Some(poll_ms)) = (from, policy.poll_ms) else {
            return;
        };
        let writer = self.plan.component(&end.component);
        let period_ms = writer.map_or(0, |component| component.pace.period_ms);
        let Terminal::Port(reader) = to else {
            return;
        };
        let reader = self.plan.component(&reader.component);
        if reader.is_some_and(|it| it.pace.period_ms > 0 || it.pace.master.is_some()) {
            return;
        }
        if policy.delivery == Delivery::Poll && period_ms > 0 && poll_ms * 2 > period_ms {
            let (from, to) = (from.to_string(), to.to_string());
            self.notes.found(PollTooSlow {
                from,
                to,
                poll_ms,
                period_ms,
                at,
            });
        }
    }

    fn terminal(&self, index: usize, terminal: &model::Terminal) -> Option<Terminal> {
        match terminal {
            model::Terminal::Topic(topic) => Some(Terminal::Topic(self.topic(index, topic))),
            model::Terminal::Mqueue(name) => Some(Terminal::Mqueue(name.value.clone())),
            model::Terminal::Port(end) => self.inside(index, end, "port").map(Terminal::Port),
        }
    }

    fn wire(&mut self, index: usize, wire: &model::Wire) {
        let Some(reference) = self.inside(index, &wire.reference, "reference") else {
            return;
        };
        let mut services = Vec::new();
        for written in &wire.services {
            if let Some(service) = self.inside(index, written, "service") {
                self.compare_operations(wire, &reference, (written, &service));
                services.push(service);
            }
        }
        if services.is_empty() && wire.url.is_none() {
            return;
        }
        if let Some(token) = &wire.token {
            endpoint::token(token, "SERVICE_TOKEN_FILE", self.notes);
        }
        let Some(mut made) = self.resolver(index).and_then(|mut to| to.of(wire)) else {
            return;
        };
        made.reference = reference;
        made.services = services;
        made.broker = self.broker(index, made.binding, wire.broker.as_ref());
        made.oneway = !check::waits(wire);
        if let (Some(written), Some(url)) = (&wire.url, &made.url) {
            endpoint::service_url(&made, url, written.span, self.notes);
            if let Some(token) = &wire.token {
                endpoint::token_in_clear(&made, token, written.span, self.notes);
            }
            if let Some(ca) = &wire.ca {
                endpoint::authority_without_tls(&made, (ca.span, written.span), self.notes);
            }
            endpoint::own_robot(&made, &self.plan.name, written.span, self.notes);
        }
        let instance = self.instances.get(index);
        let resolved = |file: &String| instance?.member.path(file).map(str::to_owned);
        made.ca = made.ca.as_ref().and_then(resolved);
        self.plan.wires.push(made);
    }

    /// Returns the resolver for values of a composite instance.
    fn resolver(&mut self, index: usize) -> Option<Resolver<'_>> {
        let instance = self.instances.get(index)?;
        Some(Resolver::new(&instance.scope, &instance.prefix, self.notes))
    }

    fn policy(&mut self, index: usize, written: &model::Policy) -> Option<Policy> {
        let mut policy = self.resolver(index)?.of(written)?;
        // a last value has no capacity
        if policy.kind == ConnectionType::Data {
            policy.size = 1;
        }
        Some(policy)
    }

    /// Returns the broker of a wire or promotion.
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

    /// The component that runs, and its part, behind a name that may be promoted as this kind of thing.
    fn inside(&self, index: usize, end: &model::End, kind: &str) -> Option<End> {
        let instance = self.instances.get(index)?;
        if let Some(child) = instance.children.get(end.component.value.as_str()) {
            let promotions = &self.composite(*child)?.promotions;
            let promotion = promotions.iter().find(|promotion| {
                promotion.name.value == end.name.value
                    && promotion.what.kind() == kind
                    && check::takes_part(&promotion.profiles, self.parts.profile)
            })?;
            return self.inside(*child, promotion.what.end()?, kind);
        }
        let component = format!("{}{}", instance.prefix, end.component.value);
        self.plan.component(&component)?;
        Some(End {
            component,
            name: end.name.value.clone(),
        })
    }

    pub(super) fn promotion(&mut self, promotion: &model::Promotion) {
        let what = &promotion.what;
        let inside = match what {
            model::Promoted::Topic(topic) => Some(topic.value.clone()),
            model::Promoted::Service(end)
            | model::Promoted::Reference(end)
            | model::Promoted::Property(end)
            | model::Promoted::Port(end) => {
                let inside = self.inside(0, end, what.kind());
                inside.map(|end| end.to_string())
            }
        };
        let Some(inside) = inside else {
            return;
        };
        let mut bindings: Vec<Transport> = Vec::new();
        for binding in &promotion.bindings {
            if binding.value != Transport::Local && !bindings.contains(&binding.value) {
                bindings.push(binding.value);
            }
        }
        let over_broker = promotion.over(Transport::Amqp);
        let over_broker = over_broker.map_or(Transport::Local, |it| it.value);
        // on any other transport, `C048` reports it
        let broker = promotion.broker.as_ref();
        let broker = broker.filter(|_| over_broker == Transport::Amqp);
        let called = promotion.over(Transport::Http);
        let timeout_ms = promotion.timeout_ms.as_ref().map(|it| it.value);
        let timeout_ms = timeout_ms.unwrap_or(model::DEFAULT_TIMEOUT_MS);
        self.plan.promoted.push(Promoted {
            what: promotion.what.kind(),
            name: promotion.name.value.clone(),
            inside,
            bindings,
            broker: self.broker(0, over_broker, broker),
            gateway: called.and_then(|_| self.gateway(promotion)),
            timeout_ms: called.map(|_| timeout_ms),
        });
    }

    /// Returns the gateway named by a promotion, or the only gateway.
    fn gateway(&self, promotion: &model::Promotion) -> Option<String> {
        let only = || match &*self.composite(0)?.gateways {
            [only] => Some(&only.name),
            _ => None,
        };
        let name = promotion.gateway.as_ref().or_else(only)?;
        Some(name.value.clone())
    }
}

fn listed(ends: &[Terminal]) -> String {
    let names: Vec<String> = ends.iter().map(Terminal::to_string).collect();
    names.join(", ")
}
