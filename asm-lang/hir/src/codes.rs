//! The diagnostic codes of the analysis, one file for each.

pub(crate) mod a001;
pub(crate) mod a002;
pub(crate) mod a003;
pub(crate) mod a004;
pub(crate) mod a005;
pub(crate) mod a006;
pub(crate) mod a007;
pub(crate) mod a008;
pub(crate) mod a009;
pub(crate) mod a010;
pub(crate) mod a011;
pub(crate) mod a012;
pub(crate) mod a013;
pub(crate) mod a014;
pub(crate) mod a015;
pub(crate) mod a016;
pub(crate) mod a018;
pub(crate) mod a019;
pub(crate) mod a020;
pub(crate) mod a021;
pub(crate) mod a023;
pub(crate) mod a024;
pub(crate) mod a025;
pub(crate) mod a026;
pub(crate) mod a027;
pub(crate) mod a028;
pub(crate) mod a033;
pub(crate) mod a034;
pub(crate) mod a036;
pub(crate) mod w001;
pub(crate) mod w002;
pub(crate) mod w003;
pub(crate) mod w004;
pub(crate) mod w005;
pub(crate) mod w020;
pub(crate) mod w021;
pub(crate) mod w022;
pub(crate) mod w023;
pub(crate) mod w024;
pub(crate) mod w025;
pub(crate) mod w026;
pub(crate) mod w027;
pub(crate) mod w028;
pub(crate) mod w029;
pub(crate) mod w031;
pub(crate) mod w032;

use asmotion_diagnostics::Code;

/// All codes of this crate, sorted by name.
pub const CODES: &[&Code] = &[
    a001::UnknownFunction::CODE,
    a002::UnknownVariable::CODE,
    a003::UnknownRule::CODE,
    a004::UnknownDomain::CODE,
    a005::UnknownConstant::CODE,
    a006::NoOverload::CODE,
    a007::TypeMismatch::CODE,
    a008::WrongArity::CODE,
    a009::DuplicateDeclaration::CODE,
    a010::ImportNotFound::CODE,
    a011::ImportCycle::CODE,
    a012::ImportsTooDeep::CODE,
    a013::UnreadableFile::CODE,
    a014::WritesMonitored::CODE,
    a015::NotExported::CODE,
    a016::WritesFixed::CODE,
    a018::NotACollection::CODE,
    a019::DisagreeingDomains::CODE,
    a020::DefinesUndeclared::CODE,
    a021::DefinesWrongKind::CODE,
    a023::MainParameters::CODE,
    a024::RuleWithoutResult::CODE,
    a025::WrongCallForm::CODE,
    a026::CannotExtend::CODE,
    a027::NoSuchInit::CODE,
    a028::NotARule::CODE,
    a033::DomainCycle::CODE,
    a034::WritesReserved::CODE,
    a036::NotImported::CODE,
    w001::NotBinds::CODE,
    w002::FileNameDiffers::CODE,
    w003::ImportsNothing::CODE,
    w004::EmptyDomain::CODE,
    w005::NoMainRule::CODE,
    w020::WritesVariable::CODE,
    w021::OutOfScope::CODE,
    w022::ResultUndeclared::CODE,
    w023::ReturnsToMonitored::CODE,
    w024::DefinesItself::CODE,
    w025::IntegerForNatural::CODE,
    w026::LocalInSignature::CODE,
    w027::ExtendsStatic::CODE,
    w028::ArgumentTooWide::CODE,
    w029::NothingChosen::CODE,
    w031::PropertiesNotVerified::CODE,
    w032::InterpolatedText::CODE,
];

/// Code of the finding for an unknown initial state. Exported because the name may come from a
/// command line.
pub const NO_SUCH_INIT: &Code = a027::NoSuchInit::CODE;
