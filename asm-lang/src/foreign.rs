//! Values outside the domains of their functions.

use crate::specification::Specification;
use asmotion_diagnostics::{Diagnostic, Span};
use asmotion_machine::DomainMisfit;
use asmotion_value::Value;
use std::fmt;

/// A value that is no element of the domain it is wanted in.
#[derive(Debug)]
pub(crate) struct Foreign {
    element: String,
    domain: String,
    declared: Span,
    /// The elements of the domain, where they are defined.
    defined: Option<Span>,
    /// The value of which the element is a part.
    whole: Option<String>,
}

impl fmt::Display for Foreign {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(to, "{} is no element of `{}`", self.element, self.domain)
    }
}

impl Foreign {
    /// Adds the domain, the whole value where only a part is at fault, and the way out.
    pub(crate) fn explain(&self, diagnostic: Diagnostic, way_out: &str) -> Diagnostic {
        let diagnostic = match self.defined {
            Some(defined) => diagnostic
                .label(defined, format!("the elements of `{}`", self.domain))
                .help(format!("{way_out}, or widen the domain")),
            None => diagnostic
                .label(self.declared, "declared here")
                .help(format!(
                    "{way_out}, or define the domain under `definitions:`"
                )),
        };
        match &self.whole {
            Some(whole) => diagnostic.note(format!("it is a part of {whole}")),
            None => diagnostic,
        }
    }
}

impl Specification {
    /// The facts about a value that is none of its function's.
    pub(crate) fn foreign(
        &self,
        misfit: &DomainMisfit,
        show: &dyn Fn(&Value) -> String,
    ) -> Foreign {
        let domain = &self.model.domains[misfit.domain.0 as usize];
        let defined = domain.definition.as_ref();
        Foreign {
            element: show(&misfit.part),
            domain: domain.name.to_string(),
            declared: domain.span,
            defined: defined.map(|definition| definition.root.span),
            whole: (misfit.part != misfit.value).then(|| show(&misfit.value)),
        }
    }

    /// Where to point: what is set from outside stands nowhere in the specification, so at its function.
    pub(crate) fn place_of(&self, at: Span, misfit: &DomainMisfit) -> Span {
        match at == Span::default() {
            true => self.model.functions[misfit.function.0 as usize].span,
            false => at,
        }
    }

    /// The codomain of the function whose value does not fit.
    pub(crate) fn codomain(&self, misfit: &DomainMisfit) -> String {
        let function = &self.model.functions[misfit.function.0 as usize];
        self.model.show_type(function.codomain)
    }
}
