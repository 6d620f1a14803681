//! The component that runs a specification.

use crate::bind_error::BindError;
use crate::binding::{Binding, Interfaces, calls};
use crate::effects::{EffectHandles, EffectOutbox};
use crate::fingerprint::fingerprint;
use crate::frame::InputFrame;
use crate::inputs::MessageInputs;
use crate::partners::MessagePartners;
use crate::requests::Requests;
use crate::step::{STEP_REPORT, StepRecord};
use asmotion_component::{
    BusHealth, CannotFreeze, Component, Cycle, Fault, Flow, FrozenState, In, Interface, Losses,
    Setup, ThawError,
};
use asmotion_datum::{Datum, Message};
use asmotion_lang::machine::{BackEnd, Machine};
use asmotion_lang::simulate::Seeded;
use asmotion_lang::{Specification, Style};
use std::sync::Arc;

/// A component that runs a specification: its cycle is one step of the machine.
pub struct Coordinator {
    pub(crate) specification: Arc<Specification>,
    /// Fingerprint of the specification and the bindings, stored in frozen states.
    pub(crate) fingerprint: String,
    pub(crate) machine: Machine,
    pub(crate) chooser: Seeded,
    pub(crate) inbox: MessageInputs,
    pub(crate) outbox: EffectOutbox,
    pub(crate) partners: MessagePartners,
    pub(crate) requests: Requests,
    /// Port that receives the state of the bus; `None` without such a port.
    health: Option<In<Datum>>,
    pub(crate) frame: InputFrame,
    /// The losses as last reported.
    pub(crate) reported: Losses,
}

/// Kind of the report with the number of lost messages, a [`Losses`].
pub const LOSSES_REPORT: &str = "asm/Losses";

impl Coordinator {
    /// Declares the ports and references, and builds the machine. The seed determines all random choices.
    ///
    /// # Errors
    /// An error if the binding does not fit, or if the initial state cannot be built.
    pub fn new(
        specification: Arc<Specification>,
        binding: &Binding,
        interfaces: &Interfaces,
        seed: u64,
        interface: &mut Interface,
    ) -> Result<Self, BindError> {
        let handles = declare(binding, interfaces, interface)?;
        let requests = Requests::declare(binding, interfaces, interface)?;
        let partners = MessagePartners::declare(
            &specification,
            &interfaces.references,
            &interfaces.services,
            interface,
        );
        let mut machine = specification.machine().map_err(|fault| {
            let finding = specification.explain(&fault);
            BindError::Initial(asmotion_lang::render(
                &finding,
                &specification.sources,
                Style::Plain,
            ))
        })?;
        machine.set_partners(partners.agents());
        let health = health(interfaces, &handles);
        let mut inbox = MessageInputs::new(binding, &specification, &handles.inputs, &requests)?;
        let outbox = EffectOutbox::new(binding, &specification, handles, &mut inbox)?;
        Ok(Self {
            fingerprint: fingerprint(&specification, binding),
            specification,
            machine,
            chooser: Seeded::new(seed),
            inbox,
            outbox,
            partners,
            requests,
            health,
            frame: InputFrame::default(),
            reported: Losses::default(),
        })
    }
}

impl Component for Coordinator {
    fn freeze(&self) -> Result<FrozenState, CannotFreeze> {
        self.frozen()
    }

    fn thaw(&mut self, state: &FrozenState) -> Result<(), ThawError> {
        self.thawed(state)
    }

    /// Compiles native code before the first step, so that compilation delays no step.
    fn configure(&mut self, _: &mut Setup<'_>) -> Result<(), Fault> {
        // without native code, closures compute the same steps
        let _ = self.machine.set_back_end(BackEnd::Native);
        Ok(())
    }

    /// Freezes, computes a step and sends: the step's messages leave with the cycle, or not at all. A coordinator that
    /// is stopping starts no new step, and finishes the current one.
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        if cycle.interrupted() {
            return Ok(());
        }
        self.requests.receive(cycle);
        self.inbox
            .receive(cycle, &self.requests, self.machine.program());
        self.outbox.receive(cycle, &mut self.inbox);
        self.inbox.losses.misfits += self.partners.receive(cycle, &mut self.machine);
        self.update_bus_health(cycle);
        self.inbox.freeze(cycle.now(), &mut self.frame);
        let stepped = self
            .machine
            .step(&mut self.frame, &mut self.chooser, cycle.now().nanos());
        if let Err(fault) = stepped {
            let finding = self.specification.explain_in(&fault, &self.machine);
            return Err(Fault::new(asmotion_lang::render(
                &finding,
                &self.specification.sources,
                Style::Plain,
            )));
        }
        let step = self.machine.last_step();
        if !step.updates().is_empty() || !step.sent().is_empty() {
            let record = StepRecord::of(&self.specification, &self.machine, &step);
            // the step is reported before its effects
            cycle.report(STEP_REPORT, Datum::of(&record)?);
        }
        let (inbox, requests) = (&mut self.inbox, &mut self.requests);
        self.outbox
            .send(&self.machine, &step, cycle, inbox, requests);
        self.requests.reply_to_open(cycle);
        self.partners.send(&self.machine, cycle);
        self.report_losses(cycle)?;
        if self.inbox.has_waiting_events() {
            cycle.request_cycle();
        }
        Ok(())
    }

    /// Ends all calls under way; for the specification they have failed.
    fn stop(&mut self) {
        self.outbox.stop(&mut self.inbox);
        self.partners.stop(&mut self.machine);
    }
}

impl Coordinator {
    /// Reports the losses if they have increased.
    fn report_losses(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        let losses = self.inbox.losses;
        if losses != self.reported {
            self.reported = losses;
            cycle.set_losses(losses);
            cycle.report(LOSSES_REPORT, Datum::of(&losses)?);
        }
        Ok(())
    }

    /// Marks the machine's channels as down while the bus is not up, so that messages are not sent.
    fn update_bus_health(&mut self, cycle: &Cycle<'_>) {
        let Some(port) = self.health else { return };
        if let Flow::NewData(health) = cycle.read(port)
            && let Some(state) = health.get("state")
        {
            let is_up = state.as_text() == Some(BusHealth::UP);
            self.machine.set_channel_down(!is_up);
        }
    }
}

/// The port that receives the state of the bus, identified by its type.
fn health(interfaces: &Interfaces, handles: &EffectHandles) -> Option<In<Datum>> {
    let types = interfaces.inputs.iter().map(|(_, message)| message);
    let mut ports = types.zip(&handles.inputs);
    let found = ports.find(|(message, _)| message.name == BusHealth::NAME);
    found.map(|(_, (_, port))| *port)
}

/// Declares every port of the component, and every operation that the binding calls.
fn declare(
    binding: &Binding,
    interfaces: &Interfaces,
    interface: &mut Interface,
) -> Result<EffectHandles, BindError> {
    let mut handles = EffectHandles::default();
    for (name, message) in &interfaces.inputs {
        let port = interface.input_of(name, message.clone(), "bound to the specification");
        handles.inputs.push((name.clone(), port));
    }
    for (name, message) in &interfaces.outputs {
        let port = interface.output_of(name, message.clone(), "bound to the specification");
        handles.outputs.push((name.clone(), port));
    }
    for call in calls(binding) {
        let operation = &call.operation;
        if handles
            .operations
            .iter()
            .any(|(known, _)| known == operation)
        {
            continue;
        }
        let declared = interfaces
            .references
            .iter()
            .find(|(reference, _)| *reference == operation.service);
        let Some((reference, service)) = declared else {
            return Err(BindError::UnknownOperation(operation.clone()));
        };
        let handle = interface.require_of(
            reference,
            service,
            &operation.operation,
            "called by the specification",
        );
        handles.operations.push((operation.clone(), handle));
    }
    Ok(handles)
}
