//! The diagnostic codes of verification: one file for each.

pub(crate) mod m001;
pub(crate) mod m002;
pub(crate) mod m003;
pub(crate) mod m004;
pub(crate) mod m005;

use asmotion_diagnostics::Code;

/// The codes of this crate: reasons for which a specification cannot be verified.
pub const CODES: &[&Code] = &[
    m001::InputWithoutRange::CODE,
    m002::TooManyAlternatives::CODE,
    m003::NoTemporalFormula::CODE,
    m004::FormulaTooLarge::CODE,
    m005::ExchangesMessages::CODE,
];
