//! The diagnostic codes of the language: one file for each code of this crate, and the list of all
//! stages.

pub(crate) mod r001;
pub(crate) mod r002;
pub(crate) mod r003;
pub(crate) mod r004;
pub(crate) mod r005;
pub(crate) mod r006;
pub(crate) mod r007;
pub(crate) mod r008;
pub(crate) mod r009;
pub(crate) mod r010;
pub(crate) mod r011;
pub(crate) mod r012;
pub(crate) mod r013;
pub(crate) mod r014;
pub(crate) mod r015;
pub(crate) mod r016;
pub(crate) mod r017;
pub(crate) mod r020;
pub(crate) mod r021;
pub(crate) mod r022;
pub(crate) mod r023;
pub(crate) mod r024;
pub(crate) mod v023;
pub(crate) mod v024;
pub(crate) mod w030;

use asmotion_diagnostics::Code;

/// Iterates over the codes of all stages. The first letter is L for syntax, A for analysis, W for
/// warnings, R for run time, S for scripted inputs, and V for scenarios.
pub fn all() -> impl Iterator<Item = &'static Code> {
    let stages = [
        asmotion_syntax::CODES,
        asmotion_hir::CODES,
        asmotion_ir::CODES,
        CODES,
        asmotion_simulate::CODES,
    ];
    stages.into_iter().flatten().copied()
}

/// The codes of this crate: run-time faults, and scenarios that cannot be opened.
const CODES: &[&Code] = &[
    w030::BeginsOutside::CODE,
    r001::Clash::CODE,
    r002::WritesForeignValue::CODE,
    r003::UndefinedGuard::CODE,
    r004::LibraryFault::CODE,
    r005::InfiniteRange::CODE,
    r006::RangeIsNoCollection::CODE,
    r007::RunsNoRule::CODE,
    r008::WrongRuleArity::CODE,
    r009::AgentWithoutProgram::CODE,
    r010::CallsTooDeep::CODE,
    r011::EndlessLoop::CODE,
    r012::CollectionTooLarge::CODE,
    r013::NoInputValue::CODE,
    r014::InvariantViolated::CODE,
    r015::NoMainToRun::CODE,
    r016::UnboundedValue::CODE,
    r017::UnboundVariable::CODE,
    r020::PickedNoCandidate::CODE,
    r021::TooManyCalls::CODE,
    r022::ReadsForeignValue::CODE,
    r023::WritesNowhere::CODE,
    r024::NoConstrainedInputs::CODE,
    v023::UnreadableScenario::CODE,
    v024::UnknownSpecification::CODE,
];
