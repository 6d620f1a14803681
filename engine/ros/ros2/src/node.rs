//! Nodes, and the endpoints that are created on them.

use std::sync::{Arc, OnceLock};
use std::thread::JoinHandle;
use std::time::Duration;

use asmotion_ros_interface::{Catalogue, InterfaceName};

use crate::deadline::DeadlineWatch;
use crate::error::{EndpointError, NodeError};
use crate::gid::Gid;
use crate::graph::Graph;
use crate::names;
use crate::notice::{Notice, Waker};
use crate::participant::{Inner, NodeOptions};
use crate::publisher::Publisher;
use crate::qos::Qos;
use crate::queue::Queue;
use crate::reactor::{Chore, Registration, Sink};
use crate::subscription::{Counters, Decoder, Shared, Subscription, SubscriptionOptions};

/// A node of ROS 2. Endpoints stay usable until they are dropped, but receive nothing after the node is dropped.
pub struct Node {
    inner: Arc<Inner>,
    /// `None` for a node beside another, to which the thread belongs.
    root: Option<Root>,
}

struct Root {
    thread: JoinHandle<()>,
    _graph_reader: Registration,
}

impl Node {
    /// Starts a node. It appears in the graph of peers at once.
    ///
    /// # Errors
    /// The name is not valid, or the participant cannot be created.
    pub fn start(options: NodeOptions, catalogue: Arc<Catalogue>) -> Result<Self, NodeError> {
        let (inner, thread) = Inner::start(options, catalogue)?;
        let graph_reader = inner.join_graph()?;
        Ok(Self {
            inner,
            root: Some(Root {
                thread,
                _graph_reader: graph_reader,
            }),
        })
    }

    /// Starts another node in the same participant: it shares the thread, the notices and the options of this node, and receives
    /// nothing after this one is dropped. Peers see two nodes.
    ///
    /// # Errors
    /// The name is not valid, or a node of the participant has it.
    pub fn beside(&self, namespace: &str, name: &str) -> Result<Self, NodeError> {
        let inner = self.inner.beside(namespace, name)?;
        Ok(Self { inner, root: None })
    }

    pub(crate) fn inner(&self) -> &Arc<Inner> {
        &self.inner
    }

    /// The absolute name of a topic. A relative one is in the namespace of the node, `~/x` in that of its name.
    ///
    /// # Errors
    /// The name is not valid.
    pub fn absolute(&self, topic: &str) -> Result<String, EndpointError> {
        Ok(self.inner.absolute(topic)?)
    }

    /// Creates a publisher. A relative `topic` is in the namespace of the node, `~/x` in that of its name.
    ///
    /// # Errors
    /// The name is not valid, the type is not a message that is defined, or DDS refuses.
    pub fn publisher(
        &self,
        topic: &str,
        of: &InterfaceName,
        qos: Qos,
    ) -> Result<Publisher, EndpointError> {
        let schema = self.inner.message(of)?;
        let topic = names::topic(&self.inner.absolute(topic)?);
        let kind = names::message_type(of);
        let outbox = self.inner.writer(&topic, &kind, qos, self.inner.hash(of))?;
        Ok(Publisher {
            inner: Arc::clone(&self.inner),
            outbox,
            schema,
        })
    }

    /// Creates a subscription, with a [`Qos`] or further options. Names as for [`publisher`](Self::publisher).
    ///
    /// # Errors
    /// The name is not valid, the type is not a message that is defined, or DDS refuses.
    pub fn subscription(
        &self,
        topic: &str,
        of: &InterfaceName,
        options: impl Into<SubscriptionOptions>,
    ) -> Result<Subscription, EndpointError> {
        let SubscriptionOptions {
            qos,
            ignores_own,
            waker,
        } = options.into();
        let schema = self.inner.message(of)?;
        let topic = names::topic(&self.inner.absolute(topic)?);
        let shared = Arc::new(Shared {
            queue: Queue::new(qos.queue()),
            counters: Counters::default(),
            deadline: OnceLock::new(),
        });
        let decoder = Decoder {
            schema,
            shared: Arc::clone(&shared),
            last: Default::default(),
            ignored: ignores_own.then(|| self.inner.gid().participant()),
            waker,
        };
        let kind = names::message_type(of);
        let hash = self.inner.hash(of);
        let sink = |_| Box::new(decoder) as Box<dyn Sink>;
        let (gid, registration) = self.inner.reader(&topic, &kind, qos, hash, sink)?;
        if let Some(deadline) = qos.deadline {
            let graph = Arc::clone(&self.inner.graph);
            let watch = Arc::new(DeadlineWatch::new(graph, gid, &topic, deadline));
            let watch = shared.deadline.get_or_init(|| watch);
            let chore: Arc<dyn Chore> = watch.clone();
            self.inner.reactor.add_chore(Arc::downgrade(&chore));
        }
        Ok(Subscription {
            inner: Arc::clone(&self.inner),
            gid,
            shared,
            _registration: registration,
        })
    }

    /// The peers and their endpoints at this moment.
    pub fn graph(&self) -> Graph {
        self.inner.graph.lock().clone()
    }

    /// Waits until the graph has a property, at most for `longest`; returns whether it has.
    pub fn wait_for_graph(&self, longest: Duration, has: impl Fn(&Graph) -> bool) -> bool {
        self.inner.graph.wait(longest, has)
    }

    /// Takes the notices since the last time, at most the last 64. One about a peer comes when the peer's node is known, or after
    /// half a second.
    pub fn take_notices(&self) -> Vec<Notice> {
        self.inner.graph.take_notices()
    }

    /// Sets what is called when notices wait.
    pub fn wake_for_notices(&self, waker: Waker) {
        self.inner.graph.set_waker(waker);
    }

    /// Sets what is called after messages have been put into queues, in the thread of the node, which has nothing else to do until it
    /// returns. It may drop the node. Only the first one counts, also for nodes [beside](Self::beside) this one.
    pub fn call_after_reading(&self, call: Waker) {
        self.inner.reactor.call_after_reading(call);
    }

    /// The name of the node with its namespace.
    pub fn full_name(&self) -> String {
        self.inner.full_name()
    }

    /// The id of the participant.
    pub fn gid(&self) -> Gid {
        self.inner.gid()
    }
}

impl Drop for Node {
    fn drop(&mut self) {
        let Some(root) = self.root.take() else {
            return self.inner.leave_participant();
        };
        self.inner.leave_graph();
        self.inner.reactor.stop();
        // the thread that drops its own node ends later
        if root.thread.thread().id() != std::thread::current().id() {
            // it does not panic on input; if it did, the message is already out
            let _ = root.thread.join();
        }
    }
}
