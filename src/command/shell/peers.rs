//! Peers: who a component is joined to, and how.

use std::collections::BTreeSet;

use asmotion_remote::{Component, Word};

/// The peers of a component: name, and what joins them, as `odom → path` or `path ← plan`.
pub fn peers(of: &Component, words: &[Word]) -> BTreeSet<(String, String)> {
    let robot = words.iter().filter(|word| word.robot == of.robot());
    let joined = robot.flat_map(|word| &word.presence.joined);
    let mut peers = BTreeSet::new();
    for joint in joined {
        let ends = (joint.from.rsplit_once('.'), joint.to.rsplit_once('.'));
        let (Some((from, out)), Some((to, into))) = ends else {
            // a message queue has a component of somebody else behind it
            continue;
        };
        if from == of.name() {
            peers.insert((to.to_owned(), format!("{out} → {into}")));
        }
        if to == of.name() {
            peers.insert((from.to_owned(), format!("{into} ← {out}")));
        }
    }
    peers
}
