//! Values outside the domains of their functions.

use crate::Specification;
use asmotion_diagnostics::{Diagnostic, Span};
use asmotion_machine::Misfit;
use asmotion_value::Value;

impl Specification {
    /// That a value is none of its function's.
    pub(super) fn no_element(
        &self,
        misfit: &Misfit,
        when: &str,
        show: &dyn Fn(&Value) -> String,
    ) -> String {
        let domain = &self.model.domains[misfit.domain.0 as usize].name;
        format!("{} is no element of `{domain}`, {when}", show(&misfit.part))
    }

    /// Adds the domain, the whole value where only a part is at fault, and the way out.
    pub(super) fn outside(
        &self,
        mut finding: Diagnostic,
        misfit: &Misfit,
        show: &dyn Fn(&Value) -> String,
        way_out: &str,
    ) -> Diagnostic {
        let domain = &self.model.domains[misfit.domain.0 as usize];
        // what is set from outside stands nowhere in the specification
        if let Some(place) = finding.primary.as_mut()
            && place.span == Span::default()
        {
            place.span = self.model.functions[misfit.function.0 as usize].span;
        }
        finding = match &domain.definition {
            Some(definition) => finding
                .label(
                    definition.root.span,
                    format!("the elements of `{}`", domain.name),
                )
                .help(format!("{way_out}, or widen the domain")),
            None => finding.label(domain.span, "declared here").help(format!(
                "{way_out}, or define the domain under `definitions:`"
            )),
        };
        if misfit.part != misfit.value {
            finding = finding.note(format!("it is a part of {}", show(&misfit.value)));
        }
        finding
    }

    /// The codomain of the function whose value does not fit.
    pub(super) fn codomain(&self, misfit: &Misfit) -> String {
        let function = &self.model.functions[misfit.function.0 as usize];
        self.model.show_type(function.codomain)
    }
}
