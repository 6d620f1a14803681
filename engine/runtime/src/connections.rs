//! The connections between the ports of a system, and the queues that several connections share.

use std::sync::Arc;
use std::sync::atomic::AtomicU64;

use asmotion_port::{
    AnySender, BufferKind, ChannelOpener, ConnectionId, LinkReader, Lock, Notification, OpenError,
    OutputLink, Policy, ReadingEnd, SharedQueue, Sharing,
};

use crate::build_error::BuildError;
use crate::component_end::ComponentEnd;
use crate::opened_end::OpenedEnd;
use crate::topic::SystemTopic;

/// All connections of a system. Owned by the executor's thread; components hold only the ends.
#[derive(Default)]
pub(crate) struct ConnectionTable {
    /// Number of the newest connection.
    last: u64,
    /// Direct connections with their ends: refuses duplicates, and finds the connection to remove.
    direct: Vec<(ConnectionId, ComponentEnd, ComponentEnd)>,
    /// Connections of publishers to subscribers, with their ends.
    by_topic: Vec<(ConnectionId, ComponentEnd, ComponentEnd)>,
    /// The topics of a running system.
    pub topics: Vec<SystemTopic>,
    /// Adapters, not the system itself, connect publishers and subscribers.
    pub topics_outside: bool,
    /// What adapters have opened for ends of components.
    pub outer_ends: Vec<HeldEnd>,
    queues: Vec<CommonQueue>,
}

/// What an adapter has opened for an end of a component. Dropping it closes the end outside.
pub(crate) struct HeldEnd {
    pub end: ComponentEnd,
    /// Name of the end outside, for example `topic scan`.
    pub outside: String,
    /// The connection from outside into an input.
    pub connection: Option<ConnectionId>,
    pub opened: Box<dyn OpenedEnd>,
}

/// A queue that several connections share.
struct CommonQueue {
    owner: QueueOwner,
    /// The policy of the connection that created the queue.
    policy: Policy,
    queue: SharedQueue,
    users: Vec<QueueUser>,
}

/// Determines which connections share a queue: those of one input, of one output, or those that use the same name.
#[derive(PartialEq)]
enum QueueOwner {
    Input(ComponentEnd),
    Output(ComponentEnd),
    Named(String),
}

/// A connection that uses a shared queue, and the threads of its two ends.
struct QueueUser {
    connection: ConnectionId,
    threads: [usize; 2],
}

/// A new connection that has not yet been handed to its two ports.
pub(crate) struct NewConnection {
    pub connection: ConnectionId,
    pub sender: Box<dyn AnySender>,
    pub reading_end: ReadingEnd,
    pub link: OutputLink,
}

/// A connection that was removed from the table.
pub(crate) struct RemovedConnection {
    connection: ConnectionId,
    ends: (ComponentEnd, ComponentEnd),
    /// Whether it connected a publisher to a subscriber of a topic.
    is_by_topic: bool,
    /// Its entries in the shared queues, by position of the queue.
    users: Vec<(usize, QueueUser)>,
}

impl RemovedConnection {
    /// Number of the removed connection.
    pub(crate) fn connection(&self) -> ConnectionId {
        self.connection
    }

    /// The writing and the reading end.
    pub(crate) fn ends(&self) -> (&ComponentEnd, &ComponentEnd) {
        (&self.ends.0, &self.ends.1)
    }

    /// Returns whether it shared its queue with other connections.
    pub(crate) fn is_shared(&self) -> bool {
        !self.users.is_empty()
    }
}

impl ConnectionTable {
    /// Returns a fresh connection number.
    pub(crate) fn next_id(&mut self) -> ConnectionId {
        self.last += 1;
        ConnectionId::new(self.last)
    }

    /// Returns an error if the two ends are connected already.
    pub(crate) fn check_unconnected(
        &self,
        from: &ComponentEnd,
        to: &ComponentEnd,
    ) -> Result<(), BuildError> {
        match self.find(from, to) {
            None => Ok(()),
            Some(_) => Err(BuildError::AlreadyConnected {
                end: from.name.clone(),
                to: format!("`{}`", to.name),
            }),
        }
    }

    fn find(&self, from: &ComponentEnd, to: &ComponentEnd) -> Option<usize> {
        let ends = |(_, known_from, known_to): &(_, ComponentEnd, ComponentEnd)| {
            (known_from, known_to) == (from, to)
        };
        self.direct.iter().position(ends)
    }

    /// Returns whether an output that `is_wanted`, by position, of one component is connected to an input of another one,
    /// directly or by a topic.
    pub(crate) fn connects(
        &self,
        (from, to): (usize, usize),
        is_wanted: impl Fn(usize) -> bool,
    ) -> bool {
        let mut all = self.direct.iter().chain(&self.by_topic);
        all.any(|(_, output, input)| {
            (output.unit, input.unit) == (from, to) && is_wanted(output.index)
        })
    }

    /// Adds a direct connection to the table.
    pub(crate) fn insert(
        &mut self,
        connection: ConnectionId,
        from: ComponentEnd,
        to: ComponentEnd,
    ) {
        self.direct.push((connection, from, to));
    }

    /// Removes a direct connection from the table, if there is one.
    pub(crate) fn remove(
        &mut self,
        from: &ComponentEnd,
        to: &ComponentEnd,
    ) -> Option<RemovedConnection> {
        let (connection, from, to) = self.direct.remove(self.find(from, to)?);
        Some(self.removed(connection, (from, to), false))
    }

    /// Position of a topic, which is created if need be.
    pub(crate) fn topic_index(&mut self, name: &str) -> usize {
        let topics = &mut self.topics;
        let found = topics.iter().position(|topic| topic.name == name);
        found.unwrap_or_else(|| {
            topics.push(SystemTopic {
                name: name.to_owned(),
                publishers: Vec::new(),
                subscribers: Vec::new(),
            });
            topics.len() - 1
        })
    }

    /// The end of a component that is joined to this end outside.
    pub(crate) fn outer_end(&self, end: &ComponentEnd, outside: &str) -> Option<&HeldEnd> {
        let mut held = self.outer_ends.iter();
        held.find(|it| it.end == *end && it.outside == outside)
    }

    /// Adds a connection of a publisher to a subscriber to the table.
    pub(crate) fn insert_by_topic(
        &mut self,
        connection: ConnectionId,
        from: ComponentEnd,
        to: ComponentEnd,
    ) {
        self.by_topic.push((connection, from, to));
    }

    /// Removes the connections of publishers to subscribers for which the predicate holds.
    pub(crate) fn remove_by_topic(
        &mut self,
        is_wanted: impl Fn(ConnectionId, &ComponentEnd, &ComponentEnd) -> bool,
    ) -> Vec<RemovedConnection> {
        let by_topic = &mut self.by_topic;
        let wanted = by_topic.extract_if(.., |(connection, from, to)| {
            is_wanted(*connection, from, to)
        });
        let wanted: Vec<_> = wanted.collect();
        let wanted = wanted.into_iter();
        wanted
            .map(|(connection, from, to)| self.removed(connection, (from, to), true))
            .collect()
    }

    /// Forgets the direct connections of a component that has been removed.
    pub(crate) fn forget_component(&mut self, component: usize) {
        let is_its = |it: &mut (ConnectionId, ComponentEnd, ComponentEnd)| {
            it.1.unit == component || it.2.unit == component
        };
        let forgotten: Vec<_> = self.direct.extract_if(.., is_its).collect();
        for (connection, from, to) in forgotten {
            drop(self.removed(connection, (from, to), false));
        }
    }

    /// Iterates over the ends of other components that are directly connected to a component.
    pub(crate) fn neighbours(&self, component: usize) -> impl Iterator<Item = &ComponentEnd> {
        let ends = self.direct.iter().flat_map(move |(_, from, to)| {
            let reader = (from.unit == component).then_some(to);
            let writer = (to.unit == component).then_some(from);
            reader.into_iter().chain(writer)
        });
        ends.filter(move |end| end.unit != component)
    }

    /// Removes the users of shared queues that belong to a connection, which is no longer in the table.
    fn removed(
        &mut self,
        connection: ConnectionId,
        ends: (ComponentEnd, ComponentEnd),
        is_by_topic: bool,
    ) -> RemovedConnection {
        let mut users = Vec::new();
        for (queue, common) in self.queues.iter_mut().enumerate() {
            let effects = common
                .users
                .extract_if(.., |user| user.connection == connection);
            users.extend(effects.map(|user| (queue, user)));
        }
        RemovedConnection {
            connection,
            ends,
            is_by_topic,
            users,
        }
    }

    /// Puts a removed connection back; the reverse of `remove`.
    pub(crate) fn reinsert(&mut self, removed: RemovedConnection) {
        let (from, to) = removed.ends;
        if removed.is_by_topic {
            self.insert_by_topic(removed.connection, from, to);
        } else {
            self.insert(removed.connection, from, to);
        }
        for (queue, user) in removed.users {
            self.queues[queue].users.push(user);
        }
    }

    /// Opens a connection between two ports whose components cycle in the given threads.
    pub(crate) fn open(
        &mut self,
        (from, to): (&ComponentEnd, &ComponentEnd),
        threads: [usize; 2],
        policy: &Policy,
        opener: &dyn ChannelOpener,
    ) -> Result<NewConnection, BuildError> {
        let connection = self.next_id();
        let queue = self.shared_queue(from, to, policy)?;
        self.check_threads((from, to), threads, policy, queue)?;
        let common = queue.map(|queue| &mut self.queues[queue].queue);
        let opened = opener.open(connection, policy, common);
        let (sender, reading_end) =
            opened.map_err(|error| open_error(error, &from.name, &to.name))?;
        if let Some(queue) = queue {
            self.queues[queue].users.push(QueueUser {
                connection,
                threads,
            });
        }
        let notification = if policy.trigger {
            Notification::Trigger(to.unit)
        } else {
            Notification::Silent
        };
        let link = OutputLink {
            readers: vec![LinkReader {
                connection,
                notification,
                losses: opener.losses(),
            }],
            to: to.name.clone(),
            mandatory: policy.mandatory,
            queue,
            dropped: Arc::new(AtomicU64::new(0)),
        };
        Ok(NewConnection {
            connection,
            sender,
            reading_end,
            link,
        })
    }

    /// Position of the shared queue that the policy asks for; creates an entry if there is none.
    fn shared_queue(
        &mut self,
        from: &ComponentEnd,
        to: &ComponentEnd,
        policy: &Policy,
    ) -> Result<Option<usize>, BuildError> {
        let owner = match (policy.sharing, policy.kind) {
            (Sharing::PerConnection, _) | (_, BufferKind::Data) => return Ok(None),
            (Sharing::PerInput, _) => QueueOwner::Input(to.clone()),
            (Sharing::PerOutput, _) => QueueOwner::Output(from.clone()),
            (Sharing::Shared, _) => QueueOwner::Named(policy.queue.clone()),
        };
        // a queue without users is recreated with the policy of its next user
        self.queues.iter_mut().for_each(|common| {
            if common.users.is_empty() {
                common.queue = None;
            }
        });
        let known = self.queues.iter().position(|common| common.owner == owner);
        let Some(known) = known else {
            self.queues.push(CommonQueue {
                owner,
                policy: policy.clone(),
                queue: None,
                users: Vec::new(),
            });
            return Ok(Some(self.queues.len() - 1));
        };
        let common = &mut self.queues[known];
        if common.users.is_empty() {
            common.policy = policy.clone();
        }
        let same = |policy: &Policy| (policy.kind, policy.lock, policy.pull);
        if same(&common.policy) == same(policy) {
            Ok(Some(known))
        } else {
            Err(queue_mismatch(
                &from.name,
                &to.name,
                "a queue of another policy",
            ))
        }
    }

    /// Checks that a shared queue has the same policy and allows the threads of both ends.
    fn check_threads(
        &self,
        (from, to): (&ComponentEnd, &ComponentEnd),
        threads: [usize; 2],
        policy: &Policy,
        queue: Option<usize>,
    ) -> Result<(), BuildError> {
        let users = queue.map_or(&[][..], |queue| &self.queues[queue].users);
        let mut all: Vec<_> = users.iter().flat_map(|user| user.threads).collect();
        all.extend(threads);
        all.sort_unstable();
        all.dedup();
        if policy.lock == Lock::Unsync && all.len() > 1 {
            return Err(BuildError::Threads {
                from: from.name.clone(),
                to: to.name.clone(),
            });
        }
        match policy.max_threads {
            Some(max) if all.len() > max => Err(BuildError::TooManyThreads {
                to: to.name.clone(),
                threads: all.len(),
                max,
            }),
            Some(_) | None => Ok(()),
        }
    }
}

/// Converts an error of the port crate into one that names both ends.
pub(crate) fn open_error(error: OpenError, from: &str, to: &str) -> BuildError {
    match error {
        OpenError::NoZero(source) => BuildError::NoZero {
            to: to.to_owned(),
            source,
        },
        OpenError::TypeMismatch => queue_mismatch(from, to, "samples of another type"),
    }
}

fn queue_mismatch(from: &str, to: &str, what: &'static str) -> BuildError {
    BuildError::QueueMismatch {
        from: from.to_owned(),
        to: to.to_owned(),
        difference: what,
    }
}
