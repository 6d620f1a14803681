//! The component that a program implements.

mod actions;
mod frozen;
mod session;

use asmotion_component::{
    AwaitedWriters, CannotFreeze, Component, Cycle, Fault, FrozenState, Interface, Setup, ThawError,
};
use asmotion_datum::Datum;

use self::session::ProgramSession;
use crate::declaration::{ProgramDeclaration, ProgramHandles};
use crate::error::ProgramError;
use crate::process::ProgramCommand;
use crate::reply::{expect, pair, value_of};
use crate::request::ProgramRequest;

/// A component that another program implements.
///
/// The program is started by `configure` and ended by the exception hook, by the next `configure`, and when the component is
/// dropped. A cycle waits for the program: it is the computation of this component, and delays no other one in a live
/// system.
pub struct ProgramComponent {
    command: ProgramCommand,
    declaration: ProgramDeclaration,
    handles: ProgramHandles,
    /// The running program; `None` before the component is configured, and after an exception.
    session: Option<ProgramSession>,
    open: actions::OpenExchanges,
    budget: actions::LineBudget,
}

impl ProgramComponent {
    /// Declares the component on an interface. Starts nothing.
    pub fn new(
        command: ProgramCommand,
        declaration: ProgramDeclaration,
        interface: &mut Interface,
    ) -> Self {
        Self {
            handles: declaration.declare(interface),
            command,
            declaration,
            session: None,
            open: actions::OpenExchanges::default(),
            budget: actions::LineBudget::default(),
        }
    }

    fn session(&self) -> Result<&ProgramSession, ProgramError> {
        self.session
            .as_ref()
            .ok_or_else(|| ProgramError::protocol("the program does not run"))
    }

    /// Sends a request that `done` answers, and carries out the actions of the reply.
    fn run(
        &mut self,
        cycle: &mut Cycle<'_>,
        request: ProgramRequest,
        kind: &'static str,
    ) -> Result<(), ProgramError> {
        let session = self.session()?;
        let (reply, age) = session.cycle(request, kind);
        self.report_lines(cycle);
        let reply = reply?;
        expect(&reply, "done", kind)?;
        self.carry_out(cycle, &reply, age)
    }

    /// Runs a cycle: `cycle`, or `recover` in the error state.
    fn compute(&mut self, cycle: &mut Cycle<'_>, kind: &'static str) -> Result<(), Fault> {
        let request = self.cycle_request(cycle, kind);
        Ok(self.run(cycle, request, kind)?)
    }

    /// Sends a request of the life cycle, whose failure has no effect: the component stops anyway.
    fn notify(&self, kind: &'static str) {
        if let Some(session) = &self.session {
            let _ = session.exchange(ProgramRequest::of(kind), kind);
        }
    }
}

impl Component for ProgramComponent {
    fn configure(&mut self, setup: &mut Setup<'_>) -> Result<(), Fault> {
        self.session = None;
        self.open = actions::OpenExchanges::default();
        let session = ProgramSession::start(&self.command, &self.declaration, setup)?;
        let properties = self.configured_properties(setup);
        let types = self.declaration.types().into_iter();
        let types = types.map(|(name, schema)| Ok((name.to_owned(), Datum::of(schema)?)));
        let types = types.collect::<Result<Vec<_>, Fault>>()?;
        let request = ProgramRequest::of("configure")
            .put("properties", Datum::record(properties))
            .put("schemas", Datum::record(types));
        let reply = session.exchange(request, "configure")?;
        expect(&reply, "ok", "configure")?;
        self.session = Some(session);
        Ok(())
    }

    fn start(&mut self) -> Result<(), Fault> {
        let reply = self
            .session()?
            .exchange(ProgramRequest::of("start"), "start")?;
        Ok(expect(&reply, "ok", "start")?)
    }

    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        self.compute(cycle, "cycle")
    }

    fn recover(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        self.compute(cycle, "recover")
    }

    fn serve(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        let request = self.serve_request(cycle);
        Ok(self.run(cycle, request, "serve")?)
    }

    /// A program may drive a device or lead to another network.
    fn awaited_writers(&self) -> AwaitedWriters {
        AwaitedWriters::Safe
    }

    fn stop(&mut self, cycle: &mut Cycle<'_>) {
        if self.session.as_ref().is_none_or(ProgramSession::is_closed) {
            return;
        }
        let request = ProgramRequest::of("stop")
            .put("now", cycle.now().nanos())
            .put("number", actions::number(cycle.number()));
        if let Err(error) = self.run(cycle, request, "stop") {
            cycle.error(error.into());
        }
    }

    fn cleanup(&mut self) {
        self.notify("cleanup");
    }

    fn exception(&mut self) {
        self.notify("exception");
        self.session = None;
    }

    fn inspect(&self) -> Vec<(String, Datum)> {
        let described = || {
            let reply = self
                .session()?
                .exchange(ProgramRequest::of("inspect"), "inspect")?;
            expect(&reply, "inspected", "inspect")?;
            let fields = value_of(&reply, "fields").cloned().unwrap_or_default();
            let Datum::List(fields) = fields else {
                return Err(ProgramError::protocol("`fields` is no list"));
            };
            let fields = fields.iter().map(|field| {
                let (name, value) = pair(field, "fields")?;
                Ok((name.to_owned(), value.clone()))
            });
            fields.collect::<Result<Vec<_>, ProgramError>>()
        };
        described().unwrap_or_default()
    }

    fn freeze(&self) -> Result<FrozenState, CannotFreeze> {
        self.frozen()
    }

    fn thaw(&mut self, state: &FrozenState) -> Result<(), ThawError> {
        self.thawed(state)
    }
}
