//! Diagnostics of flattening, one file per code.

pub(crate) mod c019;
pub(crate) mod c054;
pub(crate) mod c065;
pub(crate) mod c067;
pub(crate) mod c068;
pub(crate) mod c069;
pub(crate) mod c082;
pub(crate) mod c152;
pub(crate) mod c155;
pub(crate) mod c156;
pub(crate) mod c157;
pub(crate) mod c191;

use asmotion_diagnostics::Code;

/// All codes of this crate in ascending order.
pub const CODES: &[&Code] = &[
    c019::SecretInFile::CODE,
    c054::PollTooSlow::CODE,
    c065::DuplicateAddress::CODE,
    c067::OpenGateway::CODE,
    c068::InvalidServiceUrl::CODE,
    c069::OwnRobot::CODE,
    c082::TooManyComponents::CODE,
    c152::TokenInClear::CODE,
    c155::OperationMismatch::CODE,
    c156::QueueNeeded::CODE,
    c157::ChangeLost::CODE,
    c191::AuthorityWithoutTls::CODE,
];
