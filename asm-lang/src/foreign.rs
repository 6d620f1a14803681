//! Messages about values outside the domains of their functions.

use crate::specification::Specification;
use asmotion_diagnostics::{Diagnostic, Span};
use asmotion_machine::DomainMisfit;
use asmotion_value::Value;
use std::fmt;

/// A value outside its domain, with the facts for a message.
#[derive(Debug)]
pub(crate) struct Foreign {
    element: String,
    domain: String,
    declared: Span,
    /// Span of the domain's definition, if there is one.
    defined: Option<Span>,
    /// The whole value, if only a part of it is outside.
    whole: Option<String>,
}

impl fmt::Display for Foreign {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            to,
            "{} is not an element of `{}`",
            self.element, self.domain
        )
    }
}

impl Foreign {
    /// Adds the domain, the whole value if only a part is at fault, and the suggestion.
    pub(crate) fn explain(&self, diagnostic: Diagnostic, way_out: &str) -> Diagnostic {
        let diagnostic = match self.defined {
            Some(defined) => diagnostic
                .label(defined, format!("`{}` is defined here", self.domain))
                .help(format!("{way_out}, or widen the domain")),
            None => diagnostic
                .label(self.declared, "declared here")
                .help(format!(
                    "{way_out}, or define the domain under `definitions:`"
                )),
        };
        match &self.whole {
            Some(whole) => diagnostic.note(format!("part of {whole}")),
            None => diagnostic,
        }
    }
}

impl Specification {
    /// Collects the facts about a value outside its domain.
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

    /// Returns the span to report. A value set from outside has none in the specification, so its
    /// function's is used.
    pub(crate) fn place_of(&self, at: Span, misfit: &DomainMisfit) -> Span {
        if at == Span::default() {
            self.model.functions[misfit.function.0 as usize].span
        } else {
            at
        }
    }

    /// Returns the codomain of the function as text.
    pub(crate) fn codomain(&self, misfit: &DomainMisfit) -> String {
        let function = &self.model.functions[misfit.function.0 as usize];
        self.model.show_type(function.codomain)
    }
}
