use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Specification that exchanges messages
///
/// A specification with messages of `CommonBehavior` depends on the behaviour of its partners, which is not known. Such
/// specifications cannot be verified yet. A model of the answers as monitored functions can be.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// import CommonBehavior
/// signature:
///   enum domain Mode = {READY | ASKED}
///   domain Robot subsetof Agent
///   domain Planner subsetof Agent
///   static robot: Robot
///   static planner: Planner
///   controlled mode: Mode
/// definitions:
///   rule r_robot = if mode = READY then par r_wsend[planner, "plan", 1] mode := ASKED endpar endif
///   main rule r_Main = program(robot)
/// default init s0:
///   function mode = READY
///   agent Robot: r_robot[]
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   enum domain Mode = {READY | ASKED}
///   enum domain Answer = {NONE | PLAN | FAILURE}
///   monitored answer: Answer
///   out asks: Boolean
///   controlled mode: Mode
/// definitions:
///   main rule r_Main =
///     if mode = READY then
///       par mode := ASKED asks := true endpar
///     else if answer != NONE then
///       par mode := READY asks := false endpar
///     endif endif
/// default init s0:
///   function mode = READY
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(M005, error)]
#[error("a specification that exchanges messages cannot be verified")]
pub(crate) struct ExchangesMessages {
    pub at: Span,
}

impl Finding for ExchangesMessages {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "the answers to this are not known")
            .help("model the partner with monitored and out functions")
    }
}
