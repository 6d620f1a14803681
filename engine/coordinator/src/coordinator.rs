//! The component that runs a specification.

use crate::bind_error::BindError;
use crate::binding::{Binding, Interfaces};
use crate::content::AfterStep;
use crate::control_locations::ControlLocations;
use crate::cycle_recorder::{CycleRecorder, RecordedMachine};
use crate::effects::{EffectHandles, EffectOutbox, OutputResolver, WrittenPort};
use crate::frame::InputFrame;
use crate::inputs::MessageInputs;
use crate::last_write::LastWrite;
use crate::partners::MessagePartners;
use crate::prepared::PreparedSpecification;
use crate::recorded::{CycleCauses, MachineOrigin, RECORDED_CYCLE_REPORT, RecordedCycle};
use crate::requests::Requests;
use crate::step::{BRIEF_STEP_REPORT, FAILED_STEP_REPORT, STEP_REPORT, StepRecord};
use crate::typed_input::TypedInput;
use crate::watch::Watch;
use crate::watcher::{StepFailure, WatchedStep, Watcher};
use asmotion_component::{
    BusHealth, CannotFreeze, Component, Cycle, Fault, Flow, FrozenState, In, Interface, Losses,
    NOTICE_REPORT, Setup, ThawError, Time, prefetch,
};
use asmotion_datum::{Datum, Message};
use asmotion_lang::machine::{BackEnd, Machine, StepFault};
use asmotion_lang::simulate::{RecordedMessage, Seeded};
use asmotion_lang::{Diagnostic, FaultKind, Specification, Style, Value};
use std::any::Any;
use std::sync::Arc;

/// A component that runs a specification: its cycle is one step of the machine.
pub struct Coordinator {
    pub(crate) prepared: Arc<PreparedSpecification>,
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
    /// The last step that wrote something, for observers; not part of the frozen state.
    pub(crate) last_write: LastWrite,
    /// The control states that brief reports have told; not part of the frozen state.
    pub(crate) control: ControlLocations,
    /// Collects what a recording needs; `None` unless the run is recorded. Not part of the frozen state.
    pub(crate) recorder: Option<CycleRecorder>,
    /// Watches the properties of the specification.
    pub(crate) watcher: Watcher,
}

/// Kind of the report with the number of lost messages, a [`Losses`].
pub const LOSSES_REPORT: &str = "asm/Losses";

impl Coordinator {
    /// Declares the ports and references, and builds the machine. The seed determines all random choices.
    ///
    /// # Errors
    /// An error if the binding does not fit, or if the initial state cannot be built.
    pub fn new(
        specification: Specification,
        binding: &Binding,
        interfaces: &Interfaces,
        seed: u64,
        interface: &mut Interface,
    ) -> Result<Self, BindError> {
        let watch = Watch::default();
        Self::watching(specification, binding, &watch, interfaces, seed, interface)
    }

    /// As [`Coordinator::new`]; `watch` says which properties are watched, and the reaction to violations.
    ///
    /// # Errors
    /// As [`Coordinator::new`], or a property or the safe rule does not fit the specification.
    pub fn watching(
        specification: Specification,
        binding: &Binding,
        watch: &Watch,
        interfaces: &Interfaces,
        seed: u64,
        interface: &mut Interface,
    ) -> Result<Self, BindError> {
        let prepared = PreparedSpecification::new(specification, Arc::new(binding.clone()), watch)?;
        Self::of(Arc::new(prepared), interfaces, seed, interface)
    }

    /// As [`Coordinator::new`], for a specification that is prepared and may have other coordinators.
    ///
    /// # Errors
    /// The bindings do not fit the interfaces.
    pub fn of(
        prepared: Arc<PreparedSpecification>,
        interfaces: &Interfaces,
        seed: u64,
        interface: &mut Interface,
    ) -> Result<Self, BindError> {
        let (specification, binding) = (&prepared.specification, &prepared.binding);
        let handles = declare(&prepared, interfaces, interface)?;
        let requests = Requests::declare(binding, interfaces, interface)?;
        let partners = MessagePartners::declare(
            specification,
            &interfaces.references,
            &interfaces.services,
            interface,
        );
        let machine = prepared.machine(&partners);
        let health = health(&handles);
        let mut frame = InputFrame::default();
        let mut inbox = MessageInputs::new(
            binding,
            specification,
            &handles.inputs,
            &requests,
            &prepared.terms,
            &mut frame,
        )?;
        let mut resolver = OutputResolver {
            specification,
            handles: &handles,
            terms: &prepared.terms,
            inbox: &mut inbox,
            frame: &mut frame,
        };
        let outputs = resolver.outputs(binding)?;
        let outbox = EffectOutbox::new(outputs, handles, binding);
        Ok(Self {
            machine,
            chooser: Seeded::new(seed),
            inbox,
            outbox,
            partners,
            requests,
            health,
            frame,
            reported: Losses::default(),
            last_write: LastWrite::default(),
            control: ControlLocations::default(),
            recorder: None,
            watcher: prepared.watcher.clone(),
            prepared,
        })
    }

    /// Reports every cycle from now on as a [`RecordedCycle`], for a recording of the run.
    pub fn record_cycles(&mut self) {
        self.recorder = Some(CycleRecorder::new(MachineOrigin::Initial));
    }
}

impl Component for Coordinator {
    fn inspect(&self) -> Vec<(String, Datum)> {
        self.status().entries().unwrap_or_default()
    }

    fn prefetch(&self, depth: usize) {
        match depth {
            1 => {
                let step = self.machine.last_step();
                prefetch(self.machine.slots());
                prefetch(step.updates());
                prefetch(step.before());
                prefetch(step.inputs());
                self.inbox.prefetch();
                self.outbox.prefetch();
                self.frame.prefetch();
                self.last_write.prefetch();
            }
            2 => {
                self.inbox.prefetch_each();
                self.outbox.prefetch_each();
            }
            _ => {}
        }
    }

    fn freeze(&self) -> Result<FrozenState, CannotFreeze> {
        self.frozen()
    }

    fn thaw(&mut self, state: &FrozenState) -> Result<(), ThawError> {
        self.thawed(state)
    }

    fn take_over(&mut self, predecessor: &dyn Component, now: Time) -> Result<Vec<String>, Fault> {
        let predecessor: &dyn Any = predecessor;
        match predecessor.downcast_ref::<Self>() {
            Some(predecessor) => self.continue_from(predecessor, now),
            None => Err(Fault::new("the running component is no coordinator")),
        }
    }

    /// Compiles native code before the first step, so that compilation delays no step. A specification that has made steps
    /// begins again in its initial state: it was cleaned up, or reset after an exception.
    fn configure(&mut self, _: &mut Setup<'_>) -> Result<(), Fault> {
        if self.machine.steps() > 0 {
            self.last_write = self.last_write.for_successor(&self.machine);
            self.control.clear();
            self.machine = self.prepared.machine(&self.partners);
            self.inbox.stop_timers();
            self.outbox.published.clear();
            self.watcher.begin();
            if let Some(recorder) = &mut self.recorder {
                recorder.begin(MachineOrigin::Initial);
            }
        }
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
        self.update_conditions(cycle)?;
        let program = self.machine.program();
        for notice in self
            .inbox
            .receive(cycle, self.outbox.ports(), &self.requests, program)
        {
            cycle.report(NOTICE_REPORT, Datum::text(notice));
        }
        let ended = self.outbox.receive(cycle, &mut self.inbox);
        let (machine, recorder) = (&mut self.machine, &mut self.recorder);
        self.inbox.losses.misfits += self.partners.receive(cycle, machine, recorder);
        if let Some(recorder) = &mut self.recorder {
            recorder.note_ports(self.outbox.ports(), cycle);
            let requests = self.requests.with_requests();
            let operations = ended.iter().chain(requests);
            operations.for_each(|operation| recorder.note_cause(operation.to_string()));
        }
        self.update_bus_health(cycle);
        let now = cycle.now();
        self.inbox.freeze(now, &mut self.frame);
        if self.machine.steps() == 0 {
            // the conditions that hold in the initial state
            self.update_timers(now)?;
        }
        let (steps, causes) = (self.machine.steps(), self.recorded_causes());
        let made = self.watched_step(now);
        Self::report_violations(&made.violations, cycle)?;
        if let Some(failure) = &made.failure {
            let fault = self.failed(failure, cycle)?;
            self.record_cycle(steps, causes, &made, Some(&fault.0), cycle)?;
            return Err(fault.1);
        }
        // the step is reported before its effects
        self.report_step(&made, cycle)?;
        self.record_cycle(steps, causes, &made, None, cycle)?;
        let mut after = AfterStep {
            machine: &mut self.machine,
            frame: &mut self.frame,
            fault: None,
        };
        let (inbox, requests) = (&mut self.inbox, &mut self.requests);
        self.outbox.send(&mut after, cycle, inbox, requests);
        if let Some(fault) = after.fault {
            return Err(self.explained(&fault));
        }
        self.update_timers(now)?;
        self.requests.reply_to_open(cycle);
        self.partners.send(&self.machine, cycle);
        self.report_losses(cycle)?;
        let waiting = self.inbox.waiting_events();
        cycle.set_waiting(waiting);
        if waiting > 0 {
            cycle.request_cycle();
        }
        if let Some(deadline) = self.watcher.monitors.deadline_ns() {
            // a response is late even if nothing happens
            cycle.request_cycle_at(Time::from_nanos(deadline));
        }
        Ok(())
    }

    /// Ends all calls under way; for the specification they have failed.
    fn stop(&mut self, _: &mut Cycle<'_>) {
        self.outbox.stop(&mut self.inbox);
        self.partners.stop(&mut self.machine, &mut self.recorder);
    }
}

/// Adds the inputs without a value to the explanation of a guard or an invariant that is undef, with the key that gives them one.
fn with_missing_inputs(finding: Diagnostic, fault: &StepFault, machine: &Machine) -> Diagnostic {
    let is_undef = |value: &Value| *value == Value::Undef;
    let is_guard = matches!(fault.kind, FaultKind::UndefinedGuard);
    let is_invariant = matches!(&fault.kind, FaultKind::Invariant { value, .. } if is_undef(value));
    if !(is_guard || is_invariant) {
        return finding;
    }
    let step = machine.last_step();
    let missing = step.inputs().iter().filter(|it| is_undef(&it.value));
    missing.fold(finding, |finding, input| {
        let location = asmotion_lang::simulate::location(machine, input.slot);
        finding.help(format!(
            "`none` in the binding of `{location}` in the composite is its value before the first message"
        ))
    })
}

impl Coordinator {
    /// The causes of the next step, if the run is recorded.
    fn recorded_causes(&mut self) -> Option<CycleCauses> {
        let recorder = self.recorder.as_mut()?;
        let agents = self.partners.agents();
        let machine = RecordedMachine {
            specification: &self.prepared.specification,
            machine: &self.machine,
            agents: &agents,
            watch: &self.watcher.watch,
        };
        Some(recorder.causes(machine, &self.frame))
    }

    /// Keeps the step that was just made if it wrote or sent something, and reports it in the form that observers use, if any do.
    fn report_step(&mut self, made: &WatchedStep, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        let step = self.machine.last_step();
        if made.replaced.is_none() && step.updates().is_empty() && step.sent().is_empty() {
            return Ok(());
        }
        self.last_write.note(&step, cycle.now());
        let record = || {
            let record = StepRecord {
                safe_rule: made.replaced.as_ref().map(|it| it.rule.clone()),
                ..StepRecord::of(&self.prepared.specification, &self.machine, &step)
            };
            Datum::of(&record)
        };
        if cycle.wants_report(STEP_REPORT) {
            cycle.report(STEP_REPORT, record()?);
        } else if cycle.wants_report(BRIEF_STEP_REPORT) {
            let brief = if self.control.note(&self.machine, &step) {
                record()?
            } else {
                Datum::of(&step.number())?
            };
            cycle.report(BRIEF_STEP_REPORT, brief);
        }
        Ok(())
    }

    /// Reports the step that was made from these causes. It is reported in a cycle that fails as well: a recording repeats that
    /// one, too.
    fn record_cycle(
        &self,
        steps: u64,
        causes: Option<CycleCauses>,
        made: &WatchedStep,
        fault: Option<&str>,
        cycle: &mut Cycle<'_>,
    ) -> Result<(), Fault> {
        let Some(causes) = causes else {
            return Ok(());
        };
        let fault = fault.map(ToOwned::to_owned);
        let (specification, machine) = (&self.prepared.specification, &self.machine);
        let record = RecordedCycle {
            violations: made.violations.clone(),
            replaced: made.replaced.clone(),
            ..RecordedCycle::of(specification, machine, steps, causes, fault)
        };
        cycle.report(RECORDED_CYCLE_REPORT, Datum::of(&record)?);
        Ok(())
    }

    /// Reports a step that failed. Returns the message of its fault, and the fault of the component.
    fn failed(
        &self,
        failure: &StepFailure,
        cycle: &mut Cycle<'_>,
    ) -> Result<(String, Fault), Fault> {
        let number = match failure {
            StepFailure::Fault(fault) => fault.step,
            StepFailure::Unsafe(_) => self.machine.steps(),
        };
        let record = StepRecord::failed(&self.prepared.specification, &self.machine, number);
        cycle.report(FAILED_STEP_REPORT, Datum::of(&record)?);
        let message = failure.message(&self.prepared.specification, &self.machine);
        let fault = match failure {
            StepFailure::Fault(fault) => {
                let finding = self.prepared.specification.explain_in(fault, &self.machine);
                self.rendered(&with_missing_inputs(finding, fault, &self.machine))
            }
            StepFailure::Unsafe(_) => Fault::new(message.clone()),
        };
        Ok((message, fault))
    }

    /// Starts and stops timers according to their conditions in the current state.
    pub(crate) fn update_timers(&mut self, now: Time) -> Result<(), Fault> {
        let (inbox, machine) = (&mut self.inbox, &mut self.machine);
        let updated = inbox.update_timers(machine, &mut self.frame, now);
        updated.map_err(|fault| self.explained(&fault))
    }

    /// Determines the values that messages must have, in the state before the step.
    fn update_conditions(&mut self, cycle: &Cycle<'_>) -> Result<(), Fault> {
        let mut state = AfterStep {
            machine: &mut self.machine,
            frame: &mut self.frame,
            fault: None,
        };
        let context = self.outbox.context(&self.requests);
        self.inbox.update_conditions(&context, &mut state, cycle);
        match state.fault {
            Some(fault) => Err(self.explained(&fault)),
            None => Ok(()),
        }
    }

    /// The fault of a term, with its places in the texts.
    pub(crate) fn explained(&self, fault: &StepFault) -> Fault {
        self.rendered(&self.prepared.specification.explain_in(fault, &self.machine))
    }

    pub(crate) fn rendered(&self, finding: &Diagnostic) -> Fault {
        let sources = &self.prepared.specification.sources;
        Fault::new(asmotion_lang::render(finding, sources, Style::Plain))
    }

    /// Reports the losses if they have increased.
    fn report_losses(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        let losses = self.inbox.losses;
        if losses != self.reported {
            self.reported = losses;
            cycle.set_losses(Losses {
                dropped: self.inbox.dropped_elsewhere,
                ..losses
            });
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
            let is_down = state.as_text() != Some(BusHealth::UP);
            if let Some(recorder) = &mut self.recorder {
                recorder.note_message(RecordedMessage::Channel { is_down });
            }
            self.machine.set_channel_down(is_down);
        }
    }
}

/// The port that receives the state of the bus, identified by its type.
fn health(handles: &EffectHandles) -> Option<In<Datum>> {
    let mut ports = handles.inputs.iter();
    let found = ports.find(|it| it.schema.name == BusHealth::NAME);
    found.map(|it| it.port)
}

/// Declares every port of the component, and every operation that the binding calls.
fn declare(
    prepared: &PreparedSpecification,
    interfaces: &Interfaces,
    interface: &mut Interface,
) -> Result<EffectHandles, BindError> {
    let mut handles = EffectHandles::default();
    for (name, message) in &interfaces.inputs {
        let port = interface.input_of(name, message.clone(), "bound to the specification");
        handles.inputs.push(TypedInput {
            name: name.clone(),
            port,
            schema: prepared.schema(message),
        });
    }
    for (name, message) in &interfaces.outputs {
        let port = interface.output_of(name, message.clone(), "bound to the specification");
        handles.outputs.push((name.clone(), port));
        handles.written.push(WrittenPort {
            port,
            name: name.clone(),
            schema: prepared.schema(message),
        });
    }
    for call in prepared.binding.calls() {
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
