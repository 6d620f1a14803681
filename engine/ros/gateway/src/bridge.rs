//! The component.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Instant;

use asmotion_component::{
    AwaitedWriters, Component, Cycle, Fault, Interface, Losses, NOTICE_REPORT, Setup,
};
use asmotion_datum::Datum;

use crate::calls::CalledOperation;
use crate::desk::ComponentDesk;
use crate::echo::Echoes;
use crate::frames::Transforms;
use crate::inbound::Inbound;
use crate::mapped::{JoinedTopics, MappedTopic, RosDirection};
use crate::misfits::Misfits;
use crate::offers::OfferedOperation;
use crate::open_connection::{OpenConnection, sum};
use crate::operation::MappedOperation;
use crate::outbound::Outbound;
use crate::shown::{ComponentDisplay, ShownComponent};
use crate::transport::{ConnectionState, RosConnection, RosTransport};
use crate::wake::{CycleWakes, Wake};

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
    /// Request a cycle; `None` before the component is configured.
    wakes: Option<CycleWakes>,
    /// Messages that the bridge itself wrote, by pairs of topics that it maps in both directions.
    echoes: BTreeMap<JoinedTopics, Echoes>,
    misfits: Misfits,
    transforms: Transforms,
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
            match mapped.direction {
                RosDirection::ToRos => {
                    to_ros.push(Outbound::declare(mapped, ros_schema, interface)?);
                }
                RosDirection::FromRos => {
                    from_ros.push(Inbound::declare(mapped, &ros_schema, interface)?);
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
            wakes: None,
            echoes,
            misfits: Misfits::default(),
            transforms: Transforms::default(),
        })
    }

    /// Takes transforms from this topic and the one of its name with `_static`, in place of `/tf` and `/tf_static`.
    #[must_use]
    pub fn with_transforms_of(self, topic: &str) -> Self {
        Self {
            transforms: Transforms::on(topic),
            ..self
        }
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

    /// Opens a connection with all topics and operations.
    fn open_connection(&self, wakes: &CycleWakes) -> Result<OpenConnection, Fault> {
        let mut connection = self.transport.join(wakes.clone()).map_err(Fault::new)?;
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
        let transformed = self.to_ros.iter().map(|it| &it.mapped);
        let mut transformed = transformed.chain(self.from_ros.iter().map(|it| &it.mapped));
        let transforms = if transformed.any(|it| it.transform.is_some()) {
            let subscribed = self.transforms.subscribe(&mut *connection);
            subscribed.map_err(Fault::new)?
        } else {
            Vec::new()
        };
        let display = self.open_display(&mut *connection, Arc::clone(&wakes.wake))?;
        Ok(OpenConnection {
            senders,
            receivers,
            callers,
            servers,
            transforms,
            display,
            connection,
        })
    }

    /// Replaces a connection that receives nothing any more. Calls end, and subscribers get the last messages of latched topics again.
    fn join_again(
        &mut self,
        mut broken: OpenConnection,
        cycle: &mut Cycle<'_>,
    ) -> Result<OpenConnection, Fault> {
        let Some(wakes) = self.wakes.clone() else {
            return Ok(broken);
        };
        for (outbound, sender) in self.to_ros.iter_mut().zip(&broken.senders) {
            outbound.keep_losses(sender.losses());
        }
        for (inbound, receiver) in self.from_ros.iter_mut().zip(&broken.receivers) {
            inbound.keep_losses(receiver.losses());
        }
        for called in &mut self.calls {
            called.lose_all(&mut self.misfits, cycle);
        }
        for offered in &mut self.offers {
            offered.lose_all(cycle);
        }
        // nothing that it has not sent would leave any more
        broken.senders.clear();
        drop(broken);
        let mut open = self.open_connection(&wakes)?;
        for (outbound, sender) in self.to_ros.iter().zip(&mut open.senders) {
            for message in &outbound.last {
                // it was sent before, so it can be encoded
                let _ = sender.send(message);
            }
        }
        Ok(open)
    }

    /// Returns whether calls to ROS or from ROS have not ended.
    fn has_calls(&self) -> bool {
        self.calls.iter().any(CalledOperation::is_busy)
            || self.offers.iter().any(OfferedOperation::is_busy)
    }

    /// Losses of all mappings so far.
    fn losses(&self, open: &OpenConnection) -> Losses {
        let own = Losses {
            dropped: 0,
            misfits: self.misfits.total(),
        };
        let to_ros = self.to_ros.iter().map(Outbound::losses);
        let from_ros = self.from_ros.iter().map(Inbound::losses);
        to_ros.chain(from_ros).fold(sum(own, open.losses()), sum)
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

    /// Takes the transforms of ROS, sends the samples of the inputs to ROS, and writes the messages of ROS to the outputs.
    fn pass_messages(&mut self, open: &mut OpenConnection, cycle: &mut Cycle<'_>) {
        let (transforms, misfits) = (&mut self.transforms, &mut self.misfits);
        // before the messages that need them
        transforms.update(&mut open.transforms, misfits, cycle);
        let (buffer, echoes) = (&transforms.buffer, &mut self.echoes);
        // first what arrived from the composite: it cannot contain a message that is written below
        for (outbound, sender) in self.to_ros.iter_mut().zip(&mut open.senders) {
            let topics = outbound.mapped.joined_topics();
            let known = topics.and_then(|it| echoes.get_mut(&it));
            outbound.send(&mut **sender, known, buffer, misfits, cycle);
        }
        for (inbound, receiver) in self.from_ros.iter_mut().zip(&mut open.receivers) {
            let topics = inbound.mapped.joined_topics();
            let known = topics.and_then(|it| echoes.get_mut(&it));
            inbound.write(&mut **receiver, known, buffer, misfits, cycle);
        }
        let now = Instant::now();
        let to_ros = self.to_ros.iter().filter_map(|it| it.patience(now));
        let from_ros = self.from_ros.iter().filter_map(|it| it.patience(now));
        if let Some(patience) = to_ros.chain(from_ros).min() {
            cycle.request_cycle_at(cycle.now() + patience);
        }
    }
}

impl Component for RosBridge {
    fn configure(&mut self, setup: &mut Setup<'_>) -> Result<(), Fault> {
        self.open = None;
        let (Some(wake), Some(lend_thread)) = (setup.waker(), setup.thread_lender()) else {
            return Err(Fault::new(
                "a ros-bridge needs the wall clock: run without `--speed`, or in a profile without it",
            ));
        };
        let wakes = CycleWakes { wake, lend_thread };
        self.open = Some(self.open_connection(&wakes)?);
        self.wakes = Some(wakes);
        Ok(())
    }

    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        let Some(mut open) = self.open.take() else {
            return Ok(());
        };
        for notice in open.connection.notices() {
            cycle.report(NOTICE_REPORT, Datum::text(notice));
        }
        let joins_again = match open.connection.state() {
            ConnectionState::Sound => false,
            ConnectionState::Partial => !self.has_calls(),
            ConnectionState::Broken => true,
        };
        if joins_again {
            open = self.join_again(open, cycle)?;
        }
        self.pass_messages(&mut open, cycle);
        self.serve_operations(&mut open, cycle);
        cycle.set_losses(self.losses(&open));
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
            let losses = with(sum(of.losses(), sender.losses()), of.misfits());
            (name, of.traffic.describe(losses, now))
        });
        let from_ros = self.from_ros.iter().zip(&open.receivers);
        let from_ros = from_ros.map(|(of, receiver)| {
            let name = format!("{} ← {}", of.mapped.port, of.mapped.ros);
            let losses = with(sum(of.losses(), receiver.losses()), of.misfits());
            (name, of.traffic.describe(losses, now))
        });
        let transforms = self.transforms.describe(&open.transforms, now);
        to_ros.chain(from_ros).chain(transforms).collect()
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

/// Losses with further misfits.
fn with(losses: Losses, misfits: u64) -> Losses {
    let dropped = 0;
    sum(losses, Losses { dropped, misfits })
}
