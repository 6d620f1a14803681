use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Invalid value
///
/// Typed properties, flags, multiplicities, and the times and flags of a task accept only certain
/// values.
///
/// ```xml wrong
/// <composite xmlns="http://docs.oasis-open.org/ns/opencsa/sca/200912" name="example">
///   <property name="wheels" type="xsd:int">four</property>
/// </composite>
/// ```
///
/// Corrected:
///
/// ```xml corrected
/// <composite xmlns="http://docs.oasis-open.org/ns/opencsa/sca/200912" name="example">
///   <property name="wheels" type="xsd:int">4</property>
/// </composite>
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(X007, error)]
#[error("invalid value `{value}` for `{name}`")]
pub(crate) struct WrongAttributeValue {
    pub name: String,
    pub value: String,
    pub expected: &'static str,
    pub at: Span,
}

impl Finding for WrongAttributeValue {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self {
            expected: wanted, ..
        } = self;
        diagnostic
            .label(self.at, format!("expected {wanted}"))
            .help(format!("write {wanted}"))
    }
}
