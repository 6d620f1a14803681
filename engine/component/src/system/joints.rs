//! What joins the ports of a system: direct connections by their ends, and the queues that several have in common.

use std::sync::Arc;
use std::sync::atomic::AtomicU64;

use asmotion_connection::Kind;

use super::{BuildError, End};
use crate::Policy;
use crate::policy::{Lock, Sharing};
use crate::port::{AnySender, Incoming, Inlet, Link, News, OpenError, Queue, Reader};

/// Tells one connection of a system from all others.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct ConnectionId(u64);

/// All joints of a system.
#[derive(Default)]
pub(crate) struct Joints {
    /// Number of the last connection.
    last: u64,
    /// Direct connections, so that none is made twice, and each can be ended.
    direct: Vec<(ConnectionId, End, End)>,
    queues: Vec<Common>,
}

/// A queue that several connections have in common.
struct Common {
    whose: Whose,
    /// As of the connection that was first.
    policy: Policy,
    queue: Queue,
    users: Vec<User>,
}

/// Whose connections have the queue in common.
#[derive(PartialEq)]
enum Whose {
    Input(End),
    Output(End),
    Named(String),
}

/// A connection that has a queue in common with others, and its threads.
struct User {
    connection: ConnectionId,
    threads: [usize; 2],
}

/// A connection that is possible, on its way to its two ports.
pub(crate) struct Joint {
    pub connection: ConnectionId,
    pub sender: Box<dyn AnySender>,
    pub incoming: Incoming,
    pub link: Link,
}

/// A direct connection that was forgotten.
pub(crate) struct Forgotten {
    connection: ConnectionId,
    ends: (End, End),
    /// Its part in queues that several have in common.
    users: Vec<(usize, User)>,
}

impl Forgotten {
    /// Which it was.
    pub(crate) fn connection(&self) -> ConnectionId {
        self.connection
    }
}

impl Joints {
    /// A number for a connection.
    pub(crate) fn number(&mut self) -> ConnectionId {
        self.last += 1;
        ConnectionId(self.last)
    }

    /// Refuses a second direct connection of two ends.
    pub(crate) fn refuse_twice(&self, from: &End, to: &End) -> Result<(), BuildError> {
        match self.find(from, to) {
            None => Ok(()),
            Some(_) => Err(BuildError::Joined {
                end: from.name.clone(),
                to: format!("`{}`", to.name),
            }),
        }
    }

    fn find(&self, from: &End, to: &End) -> Option<usize> {
        let ends = |(_, known_from, known_to): &(_, End, End)| (known_from, known_to) == (from, to);
        self.direct.iter().position(ends)
    }

    /// Remembers a direct connection.
    pub(crate) fn remember(&mut self, connection: ConnectionId, from: End, to: End) {
        self.direct.push((connection, from, to));
    }

    /// Forgets a direct connection.
    pub(crate) fn forget(&mut self, from: &End, to: &End) -> Option<Forgotten> {
        let (connection, from, to) = self.direct.remove(self.find(from, to)?);
        let mut users = Vec::new();
        for (queue, common) in self.queues.iter_mut().enumerate() {
            let leaving = (common.users).extract_if(.., |user| user.connection == connection);
            users.extend(leaving.map(|user| (queue, user)));
        }
        Some(Forgotten {
            connection,
            ends: (from, to),
            users,
        })
    }

    /// Remembers again what was forgotten last.
    pub(crate) fn restore(&mut self, forgotten: Forgotten) {
        let (from, to) = forgotten.ends;
        self.remember(forgotten.connection, from, to);
        for (queue, user) in forgotten.users {
            self.queues[queue].users.push(user);
        }
    }

    /// Makes a connection between two ports, whose components cycle in these threads.
    pub(crate) fn make(
        &mut self,
        (from, to): (&End, &End),
        threads: [usize; 2],
        policy: &Policy,
        inlet: &dyn Inlet,
    ) -> Result<Joint, BuildError> {
        let connection = self.number();
        let queue = self.common(from, to, policy)?;
        self.admit((from, to), threads, policy, queue)?;
        let common = queue.map(|queue| &mut self.queues[queue].queue);
        let opened = inlet.open(connection, policy, common);
        let (sender, incoming) = opened.map_err(|error| error.at(&from.name, &to.name))?;
        if let Some(queue) = queue {
            self.queues[queue].users.push(User {
                connection,
                threads,
            });
        }
        let news = match policy.trigger {
            true => News::Trigger(to.unit),
            false => News::Silent,
        };
        let link = Link {
            readers: vec![Reader { connection, news }],
            to: to.name.clone(),
            mandatory: policy.mandatory,
            queue,
            dropped: Arc::new(AtomicU64::new(0)),
        };
        Ok(Joint {
            connection,
            sender,
            incoming,
            link,
        })
    }

    /// The place of the queue that the policy wants to have in common.
    fn common(
        &mut self,
        from: &End,
        to: &End,
        policy: &Policy,
    ) -> Result<Option<usize>, BuildError> {
        let whose = match (policy.sharing, policy.kind) {
            (Sharing::PerConnection, _) | (_, Kind::Data) => return Ok(None),
            (Sharing::PerInput, _) => Whose::Input(to.clone()),
            (Sharing::PerOutput, _) => Whose::Output(from.clone()),
            (Sharing::Shared, _) => Whose::Named(policy.queue.clone()),
        };
        // One that nobody uses any more is made anew.
        self.queues.iter_mut().for_each(|common| {
            if common.users.is_empty() {
                common.queue = None;
            }
        });
        let known = self.queues.iter().position(|common| common.whose == whose);
        let Some(known) = known else {
            self.queues.push(Common {
                whose,
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
        match same(&common.policy) == same(policy) {
            true => Ok(Some(known)),
            false => Err(other_queue(
                &from.name,
                &to.name,
                "a queue of another policy",
            )),
        }
    }

    /// Refuses what the threads of the ends do not allow.
    fn admit(
        &self,
        (from, to): (&End, &End),
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
            Some(max) if all.len() > max => Err(BuildError::Crowded {
                to: to.name.clone(),
                threads: all.len(),
                max,
            }),
            Some(_) | None => Ok(()),
        }
    }
}

impl OpenError {
    /// The error of a connection between these ends.
    pub(crate) fn at(self, from: &str, to: &str) -> BuildError {
        match self {
            Self::NoZero(source) => BuildError::NoZero {
                to: to.to_owned(),
                source,
            },
            Self::OtherType => other_queue(from, to, "samples of another type"),
        }
    }
}

fn other_queue(from: &str, to: &str, what: &'static str) -> BuildError {
    BuildError::OtherQueue {
        from: from.to_owned(),
        to: to.to_owned(),
        what,
    }
}
