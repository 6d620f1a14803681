//! How a bridge reaches the nodes of ROS; each generation of ROS implements it.

use std::time::{Duration, Instant};

use asmotion_component::Losses;
use asmotion_datum::{Datum, Schema};

use crate::desk::ComponentWatch;
use crate::mapped::MappedTopic;
use crate::operation::{MappedOperation, OperationCaller, OperationSchemas, OperationServer};
use crate::shown::{ComponentDisplay, ShownComponent};
use crate::wake::CycleWakes;

/// What a transport without services and actions says.
const NO_OPERATIONS: &str = "this bridge connects topics only";

/// How a bridge reaches the nodes of ROS.
pub trait RosTransport: Send {
    /// The schema of a message type in ROS, with the fields that only this generation of ROS has.
    ///
    /// # Errors
    /// The reason that the type is not known.
    fn schema(&self, kind: &str) -> Result<Schema, String>;

    /// The schemas of a service or an action. By default, there are none.
    ///
    /// # Errors
    /// The reason that the type is not known.
    fn operation(&self, kind: &str) -> Result<OperationSchemas, String> {
        Err(format!("`{kind}`: {NO_OPERATIONS}"))
    }

    /// Starts a node. It joins when the graph can be reached, and again when it comes back; until then messages are lost, and
    /// counted. Its threads request cycles of the bridge.
    ///
    /// # Errors
    /// The reason that no node can be started: a name is not one, or the operating system refuses sockets or threads.
    fn join(&self, wakes: CycleWakes) -> Result<Box<dyn RosConnection>, String>;
}

/// A node of a bridge in the graph of ROS. Dropping it leaves the graph.
pub trait RosConnection: Send {
    /// Publishes a topic.
    ///
    /// # Errors
    /// The reason that the topic cannot be published, such as a name that is not one.
    fn publish(&mut self, topic: &MappedTopic) -> Result<Box<dyn MessageSender>, String>;

    /// Subscribes to a topic, without the messages of this node. The node wakes the bridge when messages have arrived.
    ///
    /// # Errors
    /// As [`publish`](Self::publish).
    fn subscribe(&mut self, topic: &MappedTopic) -> Result<Box<dyn MessageReceiver>, String>;

    /// Creates a client of a service or an action. The node wakes the bridge when a call has made progress.
    ///
    /// # Errors
    /// As [`publish`](Self::publish).
    fn call(&mut self, _: &MappedOperation) -> Result<Box<dyn OperationCaller>, String> {
        Err(NO_OPERATIONS.to_owned())
    }

    /// Offers a service or an action. The node wakes the bridge when a request has arrived.
    ///
    /// # Errors
    /// As [`publish`](Self::publish).
    fn offer(&mut self, _: &MappedOperation) -> Result<Box<dyn OperationServer>, String> {
        Err(NO_OPERATIONS.to_owned())
    }

    /// Shows components to ROS: their properties as parameters, and their life cycle.
    ///
    /// # Errors
    /// As [`publish`](Self::publish).
    fn show(
        &mut self,
        _: &[ShownComponent],
        _: ComponentWatch,
    ) -> Result<Box<dyn ComponentDisplay>, String> {
        Err(NO_OPERATIONS.to_owned())
    }

    /// Takes the events in the life of the node, for the person who runs the system.
    fn notices(&mut self) -> Vec<String>;

    /// Returns whether the bridge has to join again. It is known after [`notices`](Self::notices).
    fn state(&self) -> ConnectionState {
        ConnectionState::Sound
    }
}

/// The state of the connection of a bridge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ConnectionState {
    /// All known peers are reached.
    Sound,
    /// A peer is not reached; the bridge joins again when no call is under way.
    Partial,
    /// The node may receive nothing any more; the bridge joins again at once.
    Broken,
}

/// Sends the messages of a topic.
pub trait MessageSender: Send {
    /// Sends a message of the topic's schema in ROS. Does not block: it is dropped, and counted, where it cannot be sent.
    ///
    /// # Errors
    /// The reason that the message cannot be encoded.
    fn send(&mut self, message: &Datum) -> Result<(), String>;

    /// Waits until the messages sent so far have left, at most until this time: dropping the connection drops the others.
    fn finish(&mut self, until: Instant);

    /// Messages dropped so far.
    fn losses(&self) -> Losses;
}

/// A message from ROS.
#[derive(Debug, Clone, PartialEq)]
pub struct RosMessage {
    /// The message, of the topic's schema in ROS.
    pub content: Datum,
    /// Time for which it is known to have waited on its way and in this process.
    pub age: Duration,
}

/// Receives the messages of a topic.
pub trait MessageReceiver: Send {
    /// Takes the messages that have arrived, the oldest first.
    fn take(&mut self) -> Vec<RosMessage>;

    /// Messages dropped, and messages that could not be decoded, so far.
    fn losses(&self) -> Losses;
}
