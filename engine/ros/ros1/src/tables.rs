//! What the node takes part in, by name: topics, services and parameters.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex};

use crate::context::lock;
use crate::names::RosName;
use crate::parameter::FollowedParameter;
use crate::provider::ProvidedService;
use crate::publication::Publication;
use crate::subscription::TopicSubscription;

type Table<T> = Mutex<BTreeMap<RosName, Arc<T>>>;

/// What the node takes part in.
#[derive(Default)]
pub(crate) struct Tables {
    pub(crate) publications: Table<Publication>,
    pub(crate) subscriptions: Table<TopicSubscription>,
    pub(crate) services: Table<ProvidedService>,
    pub(crate) parameters: Table<FollowedParameter>,
    /// Parameters that the node deletes when it ends.
    pub(crate) temporary: Mutex<BTreeSet<RosName>>,
}

/// Something the master is told of.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Registration {
    Publisher { topic: RosName, of: Arc<str> },
    Subscriber { topic: RosName, of: Arc<str> },
    Service(RosName),
    Parameter(RosName),
}

/// The entry of a table whose name is this text.
pub(crate) fn entry<T>(table: &Table<T>, name: &str) -> Option<Arc<T>> {
    let table = lock(table);
    let mut entries = table.iter();
    let found = entries.find(|(it, _)| it.as_str() == name);
    found.map(|(_, entry)| Arc::clone(entry))
}

impl Tables {
    /// What the master should know.
    pub(crate) fn registrations(&self) -> Vec<Registration> {
        let mut all = Vec::new();
        for (topic, publication) in &*lock(&self.publications) {
            all.push(Registration::Publisher {
                topic: topic.clone(),
                of: Arc::clone(&publication.of.name),
            });
        }
        for (topic, subscription) in &*lock(&self.subscriptions) {
            all.push(Registration::Subscriber {
                topic: topic.clone(),
                of: subscription.type_name().into(),
            });
        }
        let services = lock(&self.services);
        all.extend(services.keys().cloned().map(Registration::Service));
        let parameters = lock(&self.parameters);
        all.extend(parameters.keys().cloned().map(Registration::Parameter));
        all
    }

    /// Ends all connections of topics.
    pub(crate) fn close(&self) {
        lock(&self.publications).values().for_each(|it| it.close());
        lock(&self.subscriptions).values().for_each(|it| it.close());
    }
}
