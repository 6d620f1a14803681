//! The diagnostic codes of verification: one file for each.

pub(crate) mod m001;
pub(crate) mod m002;
pub(crate) mod m003;
pub(crate) mod m004;
pub(crate) mod m005;
pub(crate) mod m006;
pub(crate) mod m007;
pub(crate) mod m008;
pub(crate) mod m009;
pub(crate) mod m010;
pub(crate) mod m011;
pub(crate) mod m012;
pub(crate) mod m013;
pub(crate) mod m014;
pub(crate) mod m020;
pub(crate) mod m030;

use asmotion_diagnostics::{Code, Span};
use asmotion_lang::Specification;

/// The codes of this crate: reasons for which a specification cannot be verified.
pub const CODES: &[&Code] = &[
    m001::InputWithoutRange::CODE,
    m002::TooManyAlternatives::CODE,
    m003::NoTemporalFormula::CODE,
    m004::FormulaTooLarge::CODE,
    m005::UnknownContent::CODE,
    m006::NothingAssumed::CODE,
    m007::AmbiguousConnection::CODE,
    m008::ConnectionMismatch::CODE,
    m009::UnusedProvision::CODE,
    m010::NothingProvided::CODE,
    m011::MailboxOverflow::CODE,
    m012::SeveralMachines::CODE,
    m013::StorageFailure::CODE,
    m014::SteadyGrowth::CODE,
    m020::UnknownFairName::CODE,
    m030::NotSymbolic::CODE,
];

/// Returns the place of the main rule.
pub(crate) fn main_rule(specification: &Specification) -> Span {
    let main = specification.model.main;
    let main = main.and_then(|id| specification.model.rules.get(id.0 as usize));
    main.map(|rule| rule.span).unwrap_or_default()
}
