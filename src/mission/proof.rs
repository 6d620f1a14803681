//! Verification before the start: the key `verify` of components with a specification.

use super::{Mission, MissionError};
use crate::verification::before_start;
use asmotion_composite::model::PlannedVerify;
use asmotion_lang::{Loader, Report};
use asmotion_plan::{Component, Part, Plan};

impl Mission {
    /// Verifies the components of this process that demand it.
    ///
    /// # Errors
    /// A property does not hold, or is not known to hold, and the composite refuses the start in this case.
    pub(super) fn verify_before_start(
        &self,
        plan: &Plan,
        part: &Part,
        loader: &dyn Loader,
    ) -> Result<(), MissionError> {
        for (component, keys) in demanding(plan) {
            if !part.has(&component.name) {
                continue;
            }
            let result = before_start(&self.build, plan, component, keys, loader);
            if keys.refuse_start_on_failure && !result.findings.is_empty() {
                return Err(MissionError::NotVerified(result.findings));
            }
            for finding in result.findings {
                (self.notice)(&finding);
            }
        }
        Ok(())
    }
}

/// The components whose properties are verified before the start.
fn demanding(plan: &Plan) -> impl Iterator<Item = (&Component, &PlannedVerify)> {
    let components = plan.components.iter();
    components.filter_map(|component| {
        let keys = component.special.verify.as_ref()?;
        let is_demanded = keys.ctl || keys.ltl || keys.invariants || keys.refuse_start_on_failure;
        is_demanded.then_some((component, keys))
    })
}

/// Removes the warning about properties that no run can watch, if all specifications with a start in `plan` are verified.
pub(super) fn without_verified(report: &mut Report, plan: &Plan) {
    let is_verified = |component: &Component| {
        demanding(plan).any(|(it, keys)| {
            let all = !(keys.ctl || keys.ltl || keys.invariants);
            it.name == component.name && (all || keys.ctl && keys.ltl)
        })
    };
    let specified = plan.components.iter().filter(|it| it.binding.is_some());
    let mut specified = specified.peekable();
    if specified.peek().is_some() && specified.all(is_verified) {
        report.diagnostics.retain(|it| it.code.name != "C201");
    }
}
