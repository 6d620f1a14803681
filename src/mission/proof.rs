//! Verification before the start: the key `verify` of components with a specification.

use super::{Mission, MissionError};
use crate::verification::{AlikeComponents, before_start};
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
        let mut groups = Vec::new();
        let mut rest: Vec<_> = demanding(plan).collect();
        rest.retain(|(component, _)| part.has(&component.name));
        while let Some((_, keys)) = rest.first().copied() {
            let (same, others): (Vec<_>, Vec<_>) = rest.into_iter().partition(|it| it.1 == keys);
            rest = others;
            let names: Vec<&str> = same.iter().map(|(component, _)| &*component.name).collect();
            let alike = AlikeComponents::among(&self.build, plan, &names, &[], loader);
            groups.extend(alike.into_iter().map(|it| (it, keys)));
        }
        groups.sort_by_key(|(alike, _)| plan.components.position(alike.component));
        for (alike, keys) in groups {
            let result = before_start(&self.build, plan, &alike, keys, loader);
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

/// The components whose properties are verified before the start, with the keys that say which.
fn demanding(plan: &Plan) -> impl Iterator<Item = (&Component, &PlannedVerify)> {
    let components = plan.components.iter();
    components.filter_map(|component| Some((component, demanded(component)?)))
}

/// The keys that say which properties of a component are verified before the start; `None` if it is not verified.
fn demanded(component: &Component) -> Option<&PlannedVerify> {
    let keys = component.special.verify.as_ref();
    keys.filter(|it| it.ctl || it.ltl || it.invariants || it.refuse_start_on_failure)
}

/// Removes the warning about properties that no run can watch, if all specifications with a start in `plan` are verified.
pub(super) fn without_verified(report: &mut Report, plan: &Plan) {
    let is_verified = |component: &Component| {
        demanded(component).is_some_and(|keys| {
            let all = !(keys.ctl || keys.ltl || keys.invariants);
            all || keys.ctl && keys.ltl
        })
    };
    let specified = plan.components.iter().filter(|it| it.binding.is_some());
    let mut specified = specified.peekable();
    if specified.peek().is_some() && specified.all(is_verified) {
        report.diagnostics.retain(|it| it.code.name != "C201");
    }
}
