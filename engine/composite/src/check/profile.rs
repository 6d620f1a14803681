//! Profiles of a composite.

use std::collections::BTreeMap;

use asmotion_diagnostics::{Report, Span};

use crate::at::At;
use crate::codes::c020::UnknownName;
use crate::family::Family;
use crate::finding::Findings;
use crate::nearest::nearest;

/// Returns whether an element with these profiles is active in `profile`; an empty list means all profiles.
pub fn takes_part(profiles: &[At<String>], profile: Option<&str>) -> bool {
    let mut own = profiles.iter();
    profiles.is_empty() || own.any(|own| Some(own.value.as_str()) == profile)
}

/// Returns the names of the profiles used by components in ascending order. Reports other profiles named anywhere.
pub fn profiles(family: &Family, report: &mut Report) -> Vec<String> {
    let components = family
        .composites()
        .flat_map(|composite| &composite.components);
    let mut known: BTreeMap<&str, Span> = BTreeMap::new();
    for profile in components.flat_map(|component| &component.profiles) {
        known.entry(&profile.value).or_insert(profile.span);
    }
    for composite in family.composites() {
        let wires = composite.wires.iter().map(|it| &it.profiles);
        let connections = composite.connections.iter().map(|it| &it.profiles);
        let promotions = composite.promotions.iter().map(|it| &it.profiles);
        for profile in wires.chain(connections).chain(promotions).flatten() {
            if !known.contains_key(profile.value.as_str()) {
                report.found(UnknownName {
                    what: "profile",
                    name: profile.value.clone(),
                    at: profile.span,
                    nearest: nearest(profile, known.iter().map(|(name, at)| (*name, Some(*at)))),
                    left_out: None,
                });
            }
        }
    }
    known.into_keys().map(str::to_owned).collect()
}
