//! The port-proxy: operations that write and read the ports of a component, and events that report its state.
//!
//! An invocation becomes a sample: one that arrives while the target is in cycle k is consumed in cycle k + 1. The
//! proxy never blocks; the map determines for each operation what a reply means: that the sample was written
//! ([`ReplyMode::OneWay`]), that the target has taken it ([`ReplyMode::Taken`]) or that the motion has ended
//! ([`ReplyMode::Done`]).

mod events;
mod freeze;
mod lengths;
mod motion;
mod operation;
mod settings;
mod target;

use std::sync::Arc;

use asmotion_component::{
    CannotFreeze, Component, Cycle, Fault, FrozenState, In, Interface, Losses, NOTICE_REPORT, Out,
    ServiceFault, ThawError, Time,
};
use asmotion_datum::{Datum, Schema};

use crate::fit::{SchemaMisfit, check_argument, check_fit};
use events::ProxyEvents;
use lengths::LengthMonitor;
use motion::MotionMonitor;
use operation::{ProxiedOperation, TAKEN_BACK, refusal};
use target::{ProxyTarget, TargetAbsence};

pub use settings::{
    IdleCriterion, ListLength, Mapped, ProxyNotification, ProxyPort, ProxySettings, ReplyMode,
};

/// A component that provides the ports of another component, its target, as services.
pub struct PortProxy {
    /// Inputs of the proxy, connected to outputs of the target.
    inputs: Vec<ProxyInput>,
    /// Outputs of the proxy, connected to inputs of the target.
    outputs: Vec<ProxyOutput>,
    operations: Vec<ProxiedOperation>,
    lengths: LengthMonitor,
    motion: Option<MotionMonitor>,
    refused: RefusedCommands,
    events: Option<ProxyEvents>,
    target: ProxyTarget,
    /// Time of the newest sample; before the first one, time of the proxy's first cycle.
    received_at: Option<Time>,
}

/// Commands of which no reply says that they were refused: there is no caller who waits, or it has had its reply.
#[derive(Default)]
struct RefusedCommands {
    count: u64,
    /// Reasons that have been reported, so that each is reported once.
    reported: Vec<String>,
}

/// Limit of remembered reasons of refusals; further ones are counted only.
const MAX_REASONS: usize = 8;

impl RefusedCommands {
    /// Counts a command, and reports the reason if it is new.
    fn add(&mut self, reason: String, cycle: &mut Cycle<'_>) {
        self.count += 1;
        cycle.set_losses(Losses {
            dropped: 0,
            misfits: self.count,
        });
        if self.reported.len() < MAX_REASONS && !self.reported.contains(&reason) {
            cycle.report(NOTICE_REPORT, Datum::text(reason.as_str()));
            self.reported.push(reason);
        }
    }
}

#[derive(Clone)]
struct ProxyInput {
    name: Arc<str>,
    port: In<Datum>,
}

struct ProxyOutput {
    name: String,
    port: Out<Datum>,
    message: Schema,
}

impl PortProxy {
    /// Declares the ports, services and the reference, according to the target and the map.
    pub fn new(settings: &ProxySettings, interface: &mut Interface) -> Self {
        let inputs = settings.inputs.iter().map(|of| ProxyInput {
            name: of.name.as_str().into(),
            port: interface.input_of(&of.name, of.message.clone(), "an output of the target"),
        });
        let inputs = inputs.collect();
        let outputs = settings.outputs.iter().map(|of| ProxyOutput {
            name: of.name.clone(),
            port: interface.output_of(&of.name, of.message.clone(), "an input of the target"),
            message: of.message.clone(),
        });
        let outputs = outputs.collect();
        let operations = settings.operations.iter();
        let notify = settings.notify.as_ref();
        Self {
            inputs,
            outputs,
            operations: operations
                .map(|mapped| ProxiedOperation::declare(mapped, interface))
                .collect(),
            lengths: LengthMonitor::new(&settings.lengths),
            refused: RefusedCommands::default(),
            motion: notify
                .and_then(|notify| notify.idle.clone())
                .map(MotionMonitor::new),
            events: notify.map(|notify| ProxyEvents::declare(notify, interface)),
            target: ProxyTarget::new(&settings.targets),
            received_at: None,
        }
    }
}

impl Component for PortProxy {
    fn freeze(&self) -> Result<FrozenState, CannotFreeze> {
        self.frozen()
    }

    fn thaw(&mut self, state: &FrozenState) -> Result<(), ThawError> {
        self.thawed(state)
    }

    /// Handles samples of the target before requests, so that a sample is never taken for the reply to a later command.
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        for operation in &mut self.operations {
            operation.set_sent_times(cycle);
        }
        self.read_inputs(cycle);
        self.check_staleness(cycle);
        let absence = self.check_presence(cycle);
        for index in 0..self.operations.len() {
            self.serve_requests(index, &absence, cycle);
        }
        Ok(())
    }
}

impl PortProxy {
    /// Handles the samples of the target.
    fn read_inputs(&mut self, cycle: &mut Cycle<'_>) {
        for ProxyInput { name, port } in self.inputs.clone() {
            let samples = cycle.all(port).to_vec();
            let Some(written) = cycle.written_at(port).filter(|_| !samples.is_empty()) else {
                continue;
            };
            self.received_at = Some(cycle.now());
            for operation in &mut self.operations {
                operation.reply_to_sent(written, cycle);
            }
            for sample in samples {
                self.handle_sample(&name, &sample, cycle);
            }
        }
    }

    fn handle_sample(&mut self, port: &str, sample: &Datum, cycle: &mut Cycle<'_>) {
        for operation in &mut self.operations {
            operation.store_sample(port, sample);
        }
        for (commands, misfit) in self.lengths.measure(port, sample) {
            self.reject_sent(&commands, &misfit, cycle);
        }
        let arrived = self
            .motion
            .as_mut()
            .and_then(|motion| motion.measure(port, sample, cycle.now()));
        if arrived.is_some()
            && let Some(motion) = &self.motion
        {
            self.lengths.finish(motion.commanded_port());
        }
        let faulty = self.events.as_mut().is_some_and(|events| {
            let faulty = events.notify_sample(port, sample, cycle);
            if let Some(error) = arrived {
                events.notify_idle(error, cycle);
            }
            faulty
        });
        for operation in &mut self.operations {
            if faulty {
                operation.refuse_waiting("FAULT", "the target reports a fault", cycle);
            }
            if arrived.is_some() {
                operation.reply_to_finished(cycle);
            }
        }
    }

    /// Handles a command that was sent before the proxy knew that the target cannot carry it out.
    fn reject_sent(&mut self, port: &str, misfit: &SchemaMisfit, cycle: &mut Cycle<'_>) {
        let text = format!("the target cannot carry out the last command for `{port}`: {misfit}");
        if let Some(motion) = self.motion.as_mut().filter(|it| it.is_commanded_by(port)) {
            motion.abandon();
            for operation in &mut self.operations {
                operation.refuse_waiting("BAD_ARGUMENT", &misfit.to_string(), cycle);
            }
        }
        if let Some(events) = &self.events {
            events.notify_fault(&text, cycle);
        }
        self.refused.add(text, cycle);
    }

    /// Reports once that samples have stopped, and ends the wait of callers for the end of a motion.
    fn check_staleness(&mut self, cycle: &mut Cycle<'_>) {
        let received_at = *self.received_at.get_or_insert(cycle.now());
        let Some(events) = &mut self.events else {
            return;
        };
        if let Some(age) = events.notify_stale(cycle.now().since(received_at), cycle) {
            for operation in &mut self.operations {
                operation.refuse_waiting("STALE", &format!("no data for {age:?}"), cycle);
            }
        }
    }

    /// Returns why the target takes no commands, and why its last sample is out of date. A target that is not there ends the wait
    /// of callers, and the motion.
    fn check_presence(&mut self, cycle: &mut Cycle<'_>) -> TargetAbsence {
        let is_stale = self.events.as_ref().is_some_and(ProxyEvents::is_stale);
        let absence = self.target.absence(is_stale, cycle);
        let Some(fault) = absence.of_component() else {
            return absence;
        };
        for operation in &mut self.operations {
            operation.refuse_all(fault, cycle);
        }
        if let Some(motion) = &mut self.motion
            && motion.abandon()
            && let Some(events) = &self.events
        {
            events.notify_fault(&fault.to_string(), cycle);
        }
        absence
    }

    /// Handles the requests of one operation.
    fn serve_requests(&mut self, index: usize, absence: &TargetAbsence, cycle: &mut Cycle<'_>) {
        let Some(served) = self.operations.get(index).map(ProxiedOperation::handle) else {
            return;
        };
        for request in cycle.requests(served) {
            let wants_reply = request.deadline.is_some();
            let Some(operation) = self.operations.get_mut(index) else {
                return;
            };
            if operation.reads() {
                let mut inputs = self.inputs.iter();
                let port = inputs.find(|input| *input.name == operation.port);
                let result = match (absence.to_readings(), port) {
                    (Some(absence), _) if !operation.has_samples() => Err(absence.clone()),
                    (_, Some(input)) => operation.read(input.port, cycle),
                    (_, None) => Err(refusal("NO_DATA", "the target has no such port")),
                };
                cycle.reply(served, request.id, result);
                continue;
            }
            let commanded = match absence.to_commands() {
                Some(absence) => Err(absence.clone()),
                None => self.command(index, &request.argument, cycle),
            };
            match commanded {
                Ok(()) => {
                    if let Some(operation) = self.operations.get_mut(index)
                        && wants_reply
                    {
                        operation.accepted(request.id, cycle);
                    }
                }
                Err(fault) if wants_reply => cycle.reply(served, request.id, Err(fault)),
                Err(fault) => {
                    let port = self.operations.get(index).map(|it| it.port.as_str());
                    let port = port.unwrap_or_default();
                    let text = format!("a one-way command for `{port}` is refused: {fault}");
                    self.refused.add(text, cycle);
                }
            }
        }
    }

    /// Writes a sample to the target if it fits the port's type.
    fn command(
        &mut self,
        index: usize,
        argument: &Datum,
        cycle: &mut Cycle<'_>,
    ) -> Result<(), ServiceFault> {
        let missing = || refusal("BAD_ARGUMENT", "the target has no such port");
        let operation = self.operations.get(index).ok_or_else(missing)?;
        let mut outputs = self.outputs.iter();
        let output = outputs.find(|output| output.name == operation.port);
        let output = output.ok_or_else(missing)?;
        let unfit = |misfit: SchemaMisfit| refusal("BAD_ARGUMENT", &misfit.to_string());
        check_argument(argument, &operation.request).map_err(unfit)?;
        let conversion = &operation.conversion;
        let message = conversion.apply(argument);
        // the caller knows the argument, not the message
        let unfit = |misfit: SchemaMisfit| unfit(misfit.at_source_of(conversion));
        check_fit(&message, &output.message).map_err(unfit)?;
        self.lengths
            .command(&output.name, &message)
            .map_err(unfit)?;
        if let Some(motion) = self
            .motion
            .as_mut()
            .filter(|it| it.is_commanded_by(&output.name))
        {
            motion.command(&message);
            for operation in &mut self.operations {
                operation.refuse_waiting("SUPERSEDED", TAKEN_BACK, cycle);
            }
        }
        if let Some(events) = &mut self.events {
            let moves = self
                .motion
                .as_ref()
                .is_none_or(|motion| motion.is_commanded_by(&output.name));
            if moves {
                events.notify_busy(cycle);
            }
        }
        cycle.write(output.port, message);
        Ok(())
    }
}
