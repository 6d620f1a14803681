//! Peers: the components connected to a component.

use std::collections::BTreeSet;

use asmotion_remote::{RemoteComponent, RobotPresence};

/// Returns the peers of a component: name and connection, for example `odom → path` or `path ← plan`.
pub fn peers(of: &RemoteComponent, presences: &[RobotPresence]) -> BTreeSet<(String, String)> {
    let robot = presences
        .iter()
        .filter(|presence| presence.robot == of.robot());
    let joined = robot.flat_map(|presence| &presence.presence.joined);
    let mut peers = BTreeSet::new();
    for joint in joined {
        let ends = (joint.from.rsplit_once('.'), joint.to.rsplit_once('.'));
        let (Some((from, out)), Some((to, into))) = ends else {
            // the component behind a message queue is not part of this system
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
