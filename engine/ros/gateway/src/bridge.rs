//! The component.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use asmotion_bridge::{Conversion, Use};
use asmotion_component::{
    AwaitedWriters, Component, Cycle, Fault, In, Interface, Losses, NOTICE_REPORT, Out, Setup,
};
use asmotion_datum::{Datum, Schema};

use crate::calls::CalledOperation;
use crate::desk::ComponentDesk;
use crate::echo::Echoes;
use crate::mapped::{JoinedTopics, MappedTopic, RosDirection};
use crate::misfits::Misfits;
use crate::offers::OfferedOperation;
use crate::operation::{MappedOperation, OperationCaller, OperationServer};
use crate::shown::{ComponentDisplay, ShownComponent};
use crate::traffic::Traffic;
use crate::transport::{MessageReceiver, MessageSender, RosConnection, RosTransport};
use crate::wake::Wake;

/// Longest wait for the last messages to leave, when the bridge ends.
const LEAVE: Duration = Duration::from_millis(500);

/// Joins topics and operations of a composite with topics, services and actions of ROS.
///
/// Its cycle sends the samples of its inputs to ROS, and writes the messages of ROS to its outputs; its services are carried out
/// by ROS, and its references by components. It needs the wall clock: the nodes of ROS run on it. A message that does not fit the other side is counted as a misfit, and dropped.
pub struct RosBridge {
    transport: Box<dyn RosTransport>,
    to_ros: Vec<Outbound>,
    from_ros: Vec<Inbound>,
    calls: Vec<CalledOperation>,
    offers: Vec<OfferedOperation>,
    shown: Vec<ShownComponent>,
    desk: ComponentDesk,
    /// `None` before the component is configured.
    open: Option<OpenConnection>,
    /// Messages that the bridge itself wrote, by pairs of topics that it maps in both directions.
    echoes: BTreeMap<JoinedTopics, Echoes>,
    misfits: Misfits,
}

struct Outbound {
    mapped: MappedTopic,
    port: In<Datum>,
    ros_schema: Schema,
    /// Of the next message.
    sequence: u32,
    traffic: Traffic,
    /// Messages that did not fit.
    misfits: u64,
}

struct Inbound {
    mapped: MappedTopic,
    port: Out<Datum>,
    conversion: Conversion,
    traffic: Traffic,
    /// Messages that did not fit.
    misfits: u64,
}

/// A connection, with a sender or receiver for each mapping, in their order.
struct OpenConnection {
    // before the connection, which ends when it is dropped
    senders: Vec<Box<dyn MessageSender>>,
    receivers: Vec<Box<dyn MessageReceiver>>,
    callers: Vec<Box<dyn OperationCaller>>,
    servers: Vec<Box<dyn OperationServer>>,
    /// `None` if no component is shown.
    display: Option<Box<dyn ComponentDisplay>>,
    connection: Box<dyn RosConnection>,
}

impl RosBridge {
    /// Declares the ports of the mappings. Joins nothing.
    ///
    /// # Errors
    /// The reason that the messages of a mapping cannot be converted.
    pub fn new(
        transport: Box<dyn RosTransport>,
        mapped: Vec<MappedTopic>,
        interface: &mut Interface,
    ) -> Result<Self, String> {
        let is_also = |of: &MappedTopic, direction| {
            let mut others = mapped.iter().filter(|it| it.direction == direction);
            others.any(|other| other.joined_topics() == of.joined_topics())
        };
        let inbound = mapped
            .iter()
            .filter(|it| it.direction == RosDirection::FromRos);
        let both = inbound.filter(|it| is_also(it, RosDirection::ToRos));
        let echoes = both.filter_map(MappedTopic::joined_topics);
        let echoes = echoes.map(|topics| (topics, Echoes::default())).collect();
        let (mut to_ros, mut from_ros) = (Vec::new(), Vec::new());
        for mapped in mapped {
            let ros_schema = transport.schema(&mapped.kind)?;
            let (name, schema) = (&mapped.port, mapped.schema.clone());
            match mapped.direction {
                RosDirection::ToRos => {
                    let doc = format!("to the ROS topic `{}`", mapped.ros);
                    let port = interface.input_of(name, schema, &doc);
                    to_ros.push(Outbound {
                        port,
                        mapped,
                        ros_schema,
                        sequence: 0,
                        traffic: Traffic::default(),
                        misfits: 0,
                    });
                }
                RosDirection::FromRos => {
                    let converters = mapped.converters.iter();
                    let converted = converters.fold(schema.clone(), |schema, converter| {
                        converter.converted(schema, &ros_schema)
                    });
                    let conversion = Conversion::between(&ros_schema, &converted, Use::Fill);
                    let conversion = conversion.ok_or_else(|| {
                        format!("`{}` of ROS does not become `{schema}`", mapped.kind)
                    })?;
                    let doc = format!("from the ROS topic `{}`", mapped.ros);
                    let port = interface.output_of(name, schema, &doc);
                    from_ros.push(Inbound {
                        mapped,
                        port,
                        conversion,
                        traffic: Traffic::default(),
                        misfits: 0,
                    });
                }
            }
        }
        Ok(Self {
            transport,
            to_ros,
            from_ros,
            calls: Vec::new(),
            offers: Vec::new(),
            shown: Vec::new(),
            desk: ComponentDesk::default(),
            open: None,
            echoes,
            misfits: Misfits::default(),
        })
    }

    /// Declares the services that ROS carries out, and the references that it calls. Joins nothing.
    ///
    /// # Errors
    /// The reason that the arguments or results of an operation cannot be converted.
    pub fn with_operations(
        mut self,
        operations: Vec<MappedOperation>,
        interface: &mut Interface,
    ) -> Result<Self, String> {
        for mapped in operations {
            let there = self.transport.operation(&mapped.kind)?;
            match mapped.direction {
                RosDirection::ToRos => {
                    let called = CalledOperation::declare(mapped, there, interface)?;
                    self.calls.push(called);
                }
                RosDirection::FromRos => {
                    let offered = OfferedOperation::declare(mapped, there, interface)?;
                    self.offers.push(offered);
                }
            }
        }
        Ok(self)
    }

    /// Shows components of the desk to ROS. The program that runs the system looks after the desk.
    #[must_use]
    pub fn showing(mut self, shown: Vec<ShownComponent>, desk: ComponentDesk) -> Self {
        (self.shown, self.desk) = (shown, desk);
        self
    }

    /// Opens the display of the components that are shown.
    fn open_display(
        &self,
        connection: &mut dyn RosConnection,
        wake: Wake,
    ) -> Result<Option<Box<dyn ComponentDisplay>>, Fault> {
        if self.shown.is_empty() {
            return Ok(None);
        }
        let names = self.shown.iter().map(|it| it.component.clone());
        let watch = self.desk.watch(names, wake);
        let display = connection.show(&self.shown, watch);
        display.map(Some).map_err(Fault::new)
    }

    /// Takes requests to ROS and from ROS, and their answers.
    fn serve_operations(&mut self, open: &mut OpenConnection, cycle: &mut Cycle<'_>) {
        for (called, caller) in self.calls.iter_mut().zip(&mut open.callers) {
            called.update(&mut **caller, &mut self.misfits, cycle);
        }
        for (offered, server) in self.offers.iter_mut().zip(&mut open.servers) {
            offered.update(&mut **server, &mut self.misfits, cycle);
        }
        if let Some(display) = &mut open.display {
            for text in display.update() {
                cycle.report(NOTICE_REPORT, Datum::text(text));
            }
            if let Some(patience) = display.patience() {
                cycle.request_cycle_at(cycle.now() + patience);
            }
        }
    }

    /// Sends the samples of the inputs to ROS.
    fn send_samples(&mut self, open: &mut OpenConnection, cycle: &mut Cycle<'_>) {
        for (outbound, sender) in self.to_ros.iter_mut().zip(&mut open.senders) {
            let topics = outbound.mapped.joined_topics();
            let mut echoes = topics.and_then(|topics| self.echoes.get_mut(&topics));
            for sample in cycle.all(outbound.port).to_vec() {
                if echoes.as_mut().is_some_and(|it| it.is_echo(&sample)) {
                    continue;
                }
                let sent = outbound.message(sample).and_then(|it| sender.send(&it));
                match sent {
                    Ok(()) => outbound.traffic.pass(1, Instant::now()),
                    Err(reason) => {
                        outbound.misfits += 1;
                        let at = (&outbound.mapped.port, &outbound.mapped.ros);
                        self.misfits.count(at, &reason, cycle);
                    }
                }
            }
        }
    }

    /// Writes the messages of ROS to the outputs.
    fn write_messages(&mut self, open: &mut OpenConnection, cycle: &mut Cycle<'_>) {
        for (inbound, receiver) in self.from_ros.iter_mut().zip(&mut open.receivers) {
            for message in receiver.take() {
                match inbound.sample(&message.content) {
                    Ok(sample) => {
                        let topics = inbound.mapped.joined_topics();
                        if let Some(echoes) = topics.and_then(|it| self.echoes.get_mut(&it)) {
                            echoes.written(&sample);
                        }
                        cycle.write_aged(inbound.port, sample, message.age);
                        inbound.traffic.pass(1, Instant::now());
                    }
                    Err(reason) => {
                        inbound.misfits += 1;
                        let at = (&inbound.mapped.port, &inbound.mapped.ros);
                        self.misfits.count(at, &reason, cycle);
                    }
                }
            }
        }
    }
}

impl Component for RosBridge {
    fn configure(&mut self, setup: &mut Setup<'_>) -> Result<(), Fault> {
        self.open = None;
        let Some(wake) = setup.waker() else {
            return Err(Fault::new(
                "a ros-bridge needs the wall clock: run without `--speed`, or in a profile without it",
            ));
        };
        let mut connection = self.transport.join(Arc::clone(&wake)).map_err(Fault::new)?;
        let (mut senders, mut receivers) = (Vec::new(), Vec::new());
        for outbound in &self.to_ros {
            senders.push(connection.publish(&outbound.mapped).map_err(Fault::new)?);
        }
        for inbound in &self.from_ros {
            receivers.push(connection.subscribe(&inbound.mapped).map_err(Fault::new)?);
        }
        let (mut callers, mut servers) = (Vec::new(), Vec::new());
        for called in &self.calls {
            callers.push(connection.call(&called.mapped).map_err(Fault::new)?);
        }
        for offered in &self.offers {
            servers.push(connection.offer(&offered.mapped).map_err(Fault::new)?);
        }
        let display = self.open_display(&mut *connection, wake)?;
        self.open = Some(OpenConnection {
            senders,
            receivers,
            callers,
            servers,
            display,
            connection,
        });
        Ok(())
    }

    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        let Some(mut open) = self.open.take() else {
            return Ok(());
        };
        for notice in open.connection.notices() {
            cycle.report(NOTICE_REPORT, Datum::text(notice));
        }
        // first what arrived from the composite: it cannot contain a message that is written below
        self.send_samples(&mut open, cycle);
        self.write_messages(&mut open, cycle);
        self.serve_operations(&mut open, cycle);
        cycle.set_losses(open.losses(self.misfits.total()));
        self.open = Some(open);
        Ok(())
    }

    fn awaited_writers(&self) -> AwaitedWriters {
        AwaitedWriters::All
    }

    fn inspect(&self) -> Vec<(String, Datum)> {
        let (Some(open), now) = (&self.open, Instant::now()) else {
            return Vec::new();
        };
        let to_ros = self.to_ros.iter().zip(&open.senders).map(|(of, sender)| {
            let name = format!("{} → {}", of.mapped.port, of.mapped.ros);
            (
                name,
                of.traffic.describe(with(sender.losses(), of.misfits), now),
            )
        });
        let from_ros = self.from_ros.iter().zip(&open.receivers);
        let from_ros = from_ros.map(|(of, receiver)| {
            let name = format!("{} ← {}", of.mapped.port, of.mapped.ros);
            (
                name,
                of.traffic
                    .describe(with(receiver.losses(), of.misfits), now),
            )
        });
        to_ros.chain(from_ros).collect()
    }

    fn stop(&mut self, _: &mut Cycle<'_>) {
        // the cycle before has sent the last samples
        if let Some(mut open) = self.open.take() {
            for (called, caller) in self.calls.iter_mut().zip(&mut open.callers) {
                called.cancel_all(&mut **caller);
            }
            for (offered, server) in self.offers.iter_mut().zip(&mut open.servers) {
                offered.end_all(&mut **server);
            }
            self.open = Some(open);
        }
    }

    fn cleanup(&mut self) {
        self.open = None;
    }

    fn exception(&mut self) {
        self.open = None;
    }
}

/// Messages that have been sent leave before the node does.
impl Drop for OpenConnection {
    fn drop(&mut self) {
        let until = Instant::now() + LEAVE;
        for sender in &mut self.senders {
            sender.finish(until);
        }
    }
}

/// Losses with further misfits.
fn with(losses: Losses, misfits: u64) -> Losses {
    Losses {
        misfits: losses.misfits + misfits,
        ..losses
    }
}

impl OpenConnection {
    /// The losses of all mappings, with those of the bridge itself.
    fn losses(&self, misfits: u64) -> Losses {
        let senders = self.senders.iter().map(|it| it.losses());
        let receivers = self.receivers.iter().map(|it| it.losses());
        let none = Losses {
            dropped: 0,
            misfits,
        };
        senders.chain(receivers).fold(none, |sum, of| Losses {
            dropped: sum.dropped + of.dropped,
            misfits: sum.misfits + of.misfits,
        })
    }
}

impl Outbound {
    /// The message of ROS for a sample: with the fields that only ROS has, and a sequence number in the header, as the clients of
    /// ROS 1 put it there.
    fn message(&mut self, sample: Datum) -> Result<Datum, String> {
        let mut converters = self.mapped.converters.iter();
        let converted = converters.try_fold(sample, |sample, it| it.to_there(sample))?;
        let complete = self.ros_schema.complete(converted);
        let mut message = complete.map_err(|error| error.to_string())?;
        if let Some(sequence) =
            field_mut(&mut message, "header").and_then(|it| field_mut(it, "seq"))
        {
            *sequence = Datum::Int(self.sequence.into());
            self.sequence = self.sequence.wrapping_add(1);
        }
        Ok(message)
    }
}

impl Inbound {
    /// The sample for a message of ROS.
    fn sample(&self, message: &Datum) -> Result<Datum, String> {
        let converted = self.conversion.apply(message);
        let mut converters = self.mapped.converters.iter();
        let sample = converters.try_fold(converted, |sample, it| it.to_here(sample))?;
        let complete = self.mapped.schema.complete(sample);
        complete.map_err(|error| error.to_string())
    }
}

fn field_mut<'d>(record: &'d mut Datum, name: &str) -> Option<&'d mut Datum> {
    let Datum::Record(fields) = record else {
        return None;
    };
    let mut fields = fields.iter_mut();
    fields
        .find(|(field, _)| **field == *name)
        .map(|(_, value)| value)
}
