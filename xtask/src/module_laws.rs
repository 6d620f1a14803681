//! Laws about the modules inside a crate.

use crate::graph;
use crate::modules::CrateModules;

/// Largest permitted cycle of files.
pub const LARGEST_CYCLE: usize = 5;

/// Describes all violations, one sentence each.
///
/// The laws: names are imported from their modules, not from the root of the crate; first-level
/// modules have no cyclic dependencies; a cycle of files contains at most [`LARGEST_CYCLE`] of them.
pub fn breaches(crates: &[CrateModules]) -> Vec<String> {
    let mut found = Vec::new();
    for modules in crates {
        let name = &modules.name;
        found.extend(modules.hub_uses.iter().map(|hub| {
            format!(
                "{}:{}: `{}` comes from the root of the crate: import it from its module",
                hub.path, hub.line, hub.name
            )
        }));
        for (from, to) in graph::climbing(&modules.room_arrows()) {
            found.push(format!(
                "{name}: `{from}` uses `{to}`, which uses `{from}`, perhaps through others: `cargo xtask cycles {name}` shows where"
            ));
        }
        for cycle in graph::cycles(&modules.arrows()) {
            if cycle.len() > LARGEST_CYCLE {
                found.push(format!(
                    "{name}: {} files use one another in a cycle: `cargo xtask cycles {name}` shows where",
                    cycle.len()
                ));
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::breaches;
    use crate::modules::{CrateModules, HubUse};

    /// Returns a crate whose files `a`, `b`, … are either first-level modules or parts of a single one.
    fn modules(arrows: &str, one_room: bool) -> CrateModules {
        let pairs = arrows
            .split_whitespace()
            .filter_map(|pair| pair.split_once('>'));
        let uses: std::collections::BTreeMap<_, _> = pairs
            .map(|(from, to)| ((from.to_owned(), to.to_owned()), ["Name".to_owned()].into()))
            .collect();
        let files = uses.keys().flat_map(|(from, to)| [from, to]);
        let room = |file: &String| {
            if one_room {
                "room".to_owned()
            } else {
                file.clone()
            }
        };
        CrateModules {
            name: "one".to_owned(),
            root: "lib".to_owned(),
            files: files.clone().cloned().collect(),
            rooms: files.map(|file| (file.clone(), room(file))).collect(),
            uses,
            hub_uses: Vec::new(),
        }
    }

    #[test]
    fn arrows_between_rooms_fall() {
        assert!(breaches(&[modules("a>b b>c a>c", false)]).is_empty());
        assert_eq!(breaches(&[modules("a>b b>a", false)]).len(), 1);
    }

    #[test]
    fn five_files_of_one_room_may_form_a_cycle() {
        assert!(breaches(&[modules("a>b b>c c>d d>e e>a", true)]).is_empty());
        assert_eq!(
            breaches(&[modules("a>b b>c c>d d>e e>f f>a", true)]).len(),
            1
        );
    }

    #[test]
    fn a_name_from_the_root_is_named_with_its_place() {
        let mut crates = [modules("", true)];
        crates[0].hub_uses.push(HubUse {
            path: "a.rs".to_owned(),
            line: 3,
            name: "crate::Time".to_owned(),
        });
        let found = breaches(&crates);
        assert!(found[0].starts_with("a.rs:3: `crate::Time`"), "{found:?}");
    }
}
