use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Message whose content cannot be enumerated
///
/// A specification that exchanges messages is verified with every reply of a partner that is not part of the system, and with every
/// request of a client that is not part of it. The data of `Integer`, `Real`, `String` or an undeclared operation cannot be
/// enumerated.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// import CommonBehavior
/// signature:
///   domain Robot subsetof Agent
///   domain Planner subsetof Agent
///   static robot: Robot
///   static planner: Planner
///   out plan: Prod(Planner, Integer) -> Integer
///   controlled length: Integer
/// definitions:
///   rule r_robot = r_wcall[planner, "plan", 1, 500, length]
///   main rule r_Main = program(robot)
/// default init s0:
///   agent Robot: r_robot[]
/// ```
///
/// Declare a finite codomain of the operation:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// import CommonBehavior
/// signature:
///   domain Robot subsetof Agent
///   domain Planner subsetof Agent
///   domain Length subsetof Integer
///   static robot: Robot
///   static planner: Planner
///   out plan: Prod(Planner, Integer) -> Length
///   controlled length: Length
/// definitions:
///   domain Length = {0:3}
///   rule r_robot = r_wcall[planner, "plan", 1, 500, length]
///   main rule r_Main = program(robot)
/// default init s0:
///   agent Robot: r_robot[]
/// ```
///
/// Or verify the partner as well, `asmotion verify robot.asm planner.asm`, or select values for one verification:
/// `--values planner.plan=0,1` for replies, `--values job=0,1` for requests.
#[derive(Debug, thiserror::Error, Coded)]
#[code(M005, error)]
#[error("the {content} of `{operation}` cannot be enumerated")]
pub(crate) struct UnknownContent {
    /// `replies` or `requests`.
    pub content: &'static str,
    /// The operation, with the partner for a reply.
    pub operation: String,
    pub at: Span,
}

impl Finding for UnknownContent {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "exchanged here")
            .help(format!(
                "verify the partner together with this specification, declare a finite domain, or select values with `--values {}=…`",
                self.operation
            ))
    }
}
