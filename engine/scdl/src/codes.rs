//! Diagnostics about SCDL files, and about composites to be exported to SCDL, one file per code.

pub(crate) mod x001;
pub(crate) mod x002;
pub(crate) mod x003;
pub(crate) mod x004;
pub(crate) mod x005;
pub(crate) mod x006;
pub(crate) mod x007;
pub(crate) mod x008;
pub(crate) mod x009;
pub(crate) mod x010;
pub(crate) mod x011;
pub(crate) mod x012;
pub(crate) mod x013;
pub(crate) mod x014;

use asmotion_diagnostics::Code;

/// All codes of this crate, in order.
pub const CODES: &[&Code] = &[
    x001::InvalidXml::CODE,
    x002::NotScdl::CODE,
    x003::MissingAttribute::CODE,
    x004::NoCounterpart::CODE,
    x005::PasswordInScdl::CODE,
    x006::UnknownScdlName::CODE,
    x007::WrongAttributeValue::CODE,
    x008::AssumedValue::CODE,
    x009::AmbiguousAutowire::CODE,
    x010::NoScdlForm::CODE,
    x011::RenamedForToml::CODE,
    x012::UndirectedTopic::CODE,
    x013::SeveralPromoted::CODE,
    x014::MovedAddress::CODE,
];
