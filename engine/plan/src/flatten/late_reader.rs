//! Warns of values that are published once and read in processes that may start later.

use crate::codes::c157::ChangeLost;
use crate::joint::Connection;
use asmotion_composite::check;
use asmotion_composite::finding::Findings;
use asmotion_composite::model::binding::Effect;
use asmotion_coordinator::PublishWhen;
use asmotion_diagnostics::Span;

use super::Flattener;
use crate::plan::{End, Plan, Terminal};

impl Flattener<'_, '_> {
    /// Checks the specifications of all composites. The plan must be complete.
    pub(super) fn late_readers(&mut self) {
        let mut lost = Vec::new();
        for instance in &self.instances {
            for component in &instance.member.composite.components {
                if !check::takes_part(&component.profiles, self.parts.profile) {
                    continue;
                }
                let name = format!("{}{}", instance.prefix, component.name.value);
                for out in &self.parts.family.bind(instance.member, component).out {
                    let Effect::Publish(published) = &out.effect else {
                        continue;
                    };
                    let Some(when) = &published.when else {
                        continue;
                    };
                    let output = End {
                        component: name.clone(),
                        name: published.port.value.clone(),
                    };
                    if when.value == PublishWhen::OnChange {
                        lost.extend(change_lost(&self.plan, &output, when.span));
                    }
                }
            }
        }
        for finding in lost {
            self.notes.found(finding);
        }
    }
}

/// Returns the finding about the first reader in another process that gets no message from before its start.
fn change_lost(plan: &Plan, output: &End, at: Span) -> Option<ChangeLost> {
    let own = plan.process_of(&output.component);
    let mut readers = readers(plan, output);
    let (reader, process) = readers.find_map(|(reader, has_init)| {
        let process = plan.process_of(&reader.component)?;
        (!has_init && Some(&process.name) != own.map(|own| &own.name)).then_some((reader, process))
    })?;
    Some(ChangeLost {
        output: output.to_string(),
        reader: reader.to_string(),
        process: process.name.clone(),
        at,
    })
}

/// The inputs that read an output, and whether they get its last message from before their start.
fn readers<'p>(plan: &'p Plan, output: &'p End) -> impl Iterator<Item = (&'p End, bool)> {
    let writer = Terminal::Port(output.clone());
    let written: Vec<&Connection> = plan.connections.from_end(&writer).collect();
    let direct = written.clone().into_iter();
    let direct = direct.filter_map(|connection| match &connection.to {
        Terminal::Port(reader) => Some((reader, connection.policy.init)),
        Terminal::Topic(_) | Terminal::Mqueue(_) => None,
    });
    let topics = plan.topics.iter();
    let topics = topics.filter(move |topic| topic.publishers.contains(output));
    let by_topic = topics.flat_map(move |topic| {
        let end = Terminal::Topic(topic.name.clone());
        let mut written = written.iter();
        let writes_init = written.any(|it| it.to == end && it.policy.init);
        topic.subscribers.iter().map(move |reader| {
            let reader_end = Terminal::Port(reader.clone());
            let mut read = plan.connections.to_end(&reader_end);
            let reads_init = read.any(|it| it.from == end && it.policy.init);
            (reader, writes_init || reads_init)
        })
    });
    direct.chain(by_topic)
}
