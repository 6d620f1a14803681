//! What the binding of a component says about its messages, beside a protocol that says when it sends them.

use asmotion_coordinator::{Action, Argument, Binding, Effect};
use std::collections::{BTreeMap, BTreeSet};

/// Contents of all messages that a component sends on some of its ports.
#[derive(Clone, Debug, Default)]
pub(crate) struct OwnMessages(BTreeMap<String, Vec<Argument>>);

impl OwnMessages {
    /// Collects the contents of the messages that a binding describes. Those of a port on which the value of a function is published
    /// are not known.
    pub fn of(binding: &Binding) -> Self {
        let mut contents: BTreeMap<String, Vec<Argument>> = BTreeMap::new();
        let mut unknown = BTreeSet::new();
        for out in &binding.out {
            let cases = match &out.effect {
                Effect::Publish(published) => {
                    unknown.insert(&published.port);
                    continue;
                }
                Effect::Literals(cases) => cases,
            };
            for action in cases.iter().flat_map(|case| &case.actions) {
                if let Action::Publish { port, value } = action {
                    contents
                        .entry(port.clone())
                        .or_default()
                        .push(value.clone());
                }
            }
        }
        contents.retain(|port, _| !unknown.contains(port));
        Self(contents)
    }

    /// Returns the contents of all messages on a port; empty if they are not known.
    pub fn on(&self, port: &str) -> &[Argument] {
        self.0.get(port).map(Vec::as_slice).unwrap_or_default()
    }
}
