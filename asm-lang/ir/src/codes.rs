//! The diagnostic codes of lowering, one file for each.

pub(crate) mod a031;
pub(crate) mod a032;
pub(crate) mod a035;
pub(crate) mod a040;
pub(crate) mod a041;
pub(crate) mod w006;
pub(crate) mod w007;
pub(crate) mod w033;

use asmotion_diagnostics::Code;

/// All codes of this crate, sorted by name.
pub const CODES: &[&Code] = &[
    a031::MacroGrows::CODE,
    a032::NotALocation::CODE,
    a035::CircularDomain::CODE,
    a040::UnknownOperation::CODE,
    a041::MessageMismatch::CODE,
    w006::StaticChanges::CODE,
    w007::DerivedNeverChanges::CODE,
    w033::UnreachedElement::CODE,
];
