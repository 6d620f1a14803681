//! Topics: named exchanges between publishers and subscribers.

use asmotion_port::Policy;

use crate::component_end::ComponentEnd;

/// A topic with its publishers and subscribers.
#[derive(Debug, Clone)]
pub struct SystemTopic {
    /// Name without a leading slash, as in the composite.
    pub name: String,
    /// The outputs that publish on it, in order of declaration.
    pub publishers: Vec<ComponentEnd>,
    /// The inputs that subscribe to it, each with the policy of its connections.
    pub subscribers: Vec<(ComponentEnd, Policy)>,
}

impl SystemTopic {
    /// The topic with only those ends whose component, given by position, satisfies the predicate.
    #[must_use]
    pub fn filtered(&self, is_wanted: impl Fn(usize) -> bool) -> Self {
        let publishers = self.publishers.iter();
        let subscribers = self.subscribers.iter();
        Self {
            name: self.name.clone(),
            publishers: publishers
                .filter(|it| is_wanted(it.unit))
                .cloned()
                .collect(),
            subscribers: subscribers
                .filter(|(it, _)| is_wanted(it.unit))
                .cloned()
                .collect(),
        }
    }
}
