//! The diagnostic codes of the whole program, and the findings of the command line itself, one file per code.

pub(crate) mod s000;
pub(crate) mod v030;
pub(crate) mod v031;
pub(crate) mod v032;
pub(crate) mod v033;
pub(crate) mod v034;
pub(crate) mod v035;
pub(crate) mod v036;

use asmotion_diagnostics::Code;

/// The first letters of the codes, in the order of the list.
const FAMILIES: &str = "LAWRSMVCX";

/// The codes of SCDL, if this build includes it.
#[cfg(feature = "scdl")]
const OF_SCDL: &[&Code] = asmotion_scdl::CODES;
#[cfg(not(feature = "scdl"))]
const OF_SCDL: &[&Code] = &[];

/// All codes of this build, by family and number.
pub fn all() -> impl Iterator<Item = &'static Code> {
    let language = asmotion_lang::codes::all();
    let others = [
        asmotion_verify::CODES,
        asmotion_composite::CODES,
        asmotion_plan::CODES,
        OF_SCDL,
        CODES,
    ];
    let mut codes: Vec<_> = language
        .chain(others.into_iter().flatten().copied())
        .collect();
    codes.sort_by_key(|code| {
        let family = FAMILIES.find(|family| code.name.starts_with(family));
        (family, code.name)
    });
    codes.into_iter()
}

/// The codes of this crate, in order.
pub const CODES: &[&Code] = &[
    s000::UnreadableScript::CODE,
    v030::NoSnapshot::CODE,
    v031::SnapshotDiffers::CODE,
    v032::InvalidRunCondition::CODE,
    v033::ExpectationFailed::CODE,
    v034::ActionFailed::CODE,
    v035::MissionEndedEarly::CODE,
    v036::MissionNotStarted::CODE,
];
