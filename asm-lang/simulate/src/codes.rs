//! The diagnostic codes of input scripts and scenarios, one file for each.

pub(crate) mod s001;
pub(crate) mod s002;
pub(crate) mod s003;
pub(crate) mod s004;
pub(crate) mod s005;
pub(crate) mod s006;
pub(crate) mod v011;
pub(crate) mod v012;
pub(crate) mod v013;
pub(crate) mod v014;
pub(crate) mod v015;
pub(crate) mod v016;
pub(crate) mod v017;
pub(crate) mod v018;
pub(crate) mod v019;
pub(crate) mod v020;
pub(crate) mod v021;
pub(crate) mod v022;

use asmotion_diagnostics::Code;

/// All codes of this crate, sorted by name.
pub const CODES: &[&Code] = &[
    s001::InvalidScript::CODE,
    s002::UnknownSection::CODE,
    s003::UnknownInput::CODE,
    s004::WrongInputValue::CODE,
    s005::NotAnAnswer::CODE,
    s006::UnknownPartner::CODE,
    v011::UnknownBlock::CODE,
    v012::UnknownScenario::CODE,
    v013::CircularBlock::CODE,
    v014::UnknownChoice::CODE,
    v015::UnknownChooseRule::CODE,
    v016::PicksUndef::CODE,
    v017::ScenarioTooLong::CODE,
    v018::ScenarioWithoutMain::CODE,
    v019::BlockCallsTooDeep::CODE,
    v020::CheckFailed::CODE,
    v021::ScenarioInvariantFailed::CODE,
    v022::UntilDidNotEnd::CODE,
];
