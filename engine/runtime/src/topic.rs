//! Topics: named meeting points of publishers and subscribers.

use asmotion_port::Policy;

use crate::end::ComponentEnd;

/// A topic of a system.
pub struct SystemTopic {
    /// The topic's name.
    pub name: String,
    /// The outputs that publish to it.
    pub publishers: Vec<ComponentEnd>,
    /// The inputs that read it, and how.
    pub subscribers: Vec<(ComponentEnd, Policy)>,
}

impl SystemTopic {
    /// The topic with only those ends whose component, given by position, is wanted.
    #[must_use]
    pub fn filtered(&self, is_wanted: impl Fn(usize) -> bool) -> Self {
        let publishers = self.publishers.iter();
        let subscribers = self.subscribers.iter();
        Self {
            name: self.name.clone(),
            publishers: (publishers.filter(|it| is_wanted(it.unit)))
                .cloned()
                .collect(),
            subscribers: (subscribers.filter(|(it, _)| is_wanted(it.unit)))
                .cloned()
                .collect(),
        }
    }
}
