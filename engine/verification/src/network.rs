//! Senders and receivers, callers and providers, according to a plan.

use asmotion_plan::{End, Plan, Terminal};

/// The senders of the messages of an input.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Senders {
    /// Ports, or references, of components.
    pub ends: Vec<End>,
    /// `true` if messages can come from outside of the composite.
    pub outside: bool,
}

fn add(ends: &mut Vec<End>, end: &End) {
    if !ends.contains(end) {
        ends.push(end.clone());
    }
}

/// The ports that write to an input port.
pub(crate) fn writers(plan: &Plan, port: &End) -> Senders {
    let mut senders = Senders::default();
    let mut topics: Vec<&str> = Vec::new();
    for connection in &plan.connections {
        if connection.to != Terminal::Port(port.clone()) {
            continue;
        }
        match &connection.from {
            Terminal::Port(from) => add(&mut senders.ends, from),
            Terminal::Topic(topic) => topics.push(topic),
            Terminal::Mqueue(_) => senders.outside = true,
        }
    }
    let subscribed = plan
        .topics
        .iter()
        .filter(|it| it.subscribers.contains(port));
    topics.extend(subscribed.map(|it| it.name.as_str()));
    for name in topics {
        for topic in plan.topics.iter().filter(|it| it.name == name) {
            topic
                .publishers
                .iter()
                .for_each(|end| add(&mut senders.ends, end));
            senders.outside |= topic.promoted;
        }
        for connection in &plan.connections {
            if connection.to == Terminal::Topic(name.to_owned()) {
                match &connection.from {
                    Terminal::Port(from) => add(&mut senders.ends, from),
                    Terminal::Topic(_) => {}
                    Terminal::Mqueue(_) => senders.outside = true,
                }
            }
        }
    }
    let is_promoted =
        |it: &asmotion_plan::Promoted| it.what == "port" && it.inside == port.to_string();
    senders.outside |= plan.promoted.iter().any(is_promoted);
    senders
}

/// The references through which a service is called.
pub(crate) fn callers(plan: &Plan, service: &End) -> Senders {
    let mut senders = Senders::default();
    for wire in plan.wires.to_service(service) {
        add(&mut senders.ends, &wire.reference);
    }
    let is_promoted =
        |it: &asmotion_plan::Promoted| it.what == "service" && it.inside == service.to_string();
    senders.outside = plan.promoted.iter().any(is_promoted);
    senders
}

/// The services that calls through a reference go to; other systems are not among them.
pub(crate) fn providers(plan: &Plan, reference: &End) -> Senders {
    let mut senders = Senders::default();
    for wire in plan.wires.of_reference(reference) {
        wire.services
            .iter()
            .for_each(|end| add(&mut senders.ends, end));
        senders.outside |= wire.url.is_some();
    }
    senders
}
