//! The servers of Nav2.

use std::path::Path;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use crate::action::{action_kinds, service_kinds};
use crate::peer::{LONG, Peer};

/// The action servers and costmaps of Nav2, with a robot that needs 0.4 s to stop.
pub struct Nav2 {
    peer: Peer,
    heard: Vec<String>,
}

impl Nav2 {
    /// Starts the servers.
    ///
    /// # Panics
    /// They cannot be started.
    pub fn start(python: &Path, domain: u16) -> Self {
        let action = |kind: &str, takes: f64| {
            let (kinds, empty) = action_kinds(&format!("nav2_msgs/action/{kind}"));
            json!({ "kinds": kinds, "empty": empty, "takes": takes })
        };
        let clearing = || {
            let [request, response] = service_kinds("nav2_msgs/srv/ClearEntireCostmap");
            json!({ "request": request, "response": response })
        };
        let settings = json!({
            "domain": domain,
            "actions": {
                "compute_path_to_pose": action("ComputePathToPose", 0.05),
                "follow_path": action("FollowPath", 3.0),
                "spin": action("Spin", 0.5),
                "wait": action("Wait", 0.5),
                "backup": action("BackUp", 0.5),
            },
            "services": {
                "/global_costmap/clear_entirely_global_costmap": clearing(),
                "/local_costmap/clear_entirely_local_costmap": clearing(),
            },
        });
        let script = concat!(env!("CARGO_MANIFEST_DIR"), "/peers/nav2.py");
        let nav2 = Self {
            peer: Peer::spawn(python, script, &[&settings.to_string()]),
            heard: Vec::new(),
        };
        nav2.peer.expect("ready");
        nav2
    }

    /// Plans the end of a later goal of an action: with an error code, after so many seconds.
    pub fn next_fails(&mut self, action: &str, code: u32, after: f64) {
        self.next(action, &json!({ "code": code, "after": after }));
    }

    /// Plans the duration of a later goal of an action, which succeeds.
    pub fn next_takes(&mut self, action: &str, after: f64) {
        self.next(action, &json!({ "after": after }));
    }

    fn next(&mut self, action: &str, plan: &Value) {
        self.peer.tell(&json!(["next", action, plan]).to_string());
    }

    /// The next event, such as `begin spin`, `cancel follow_path`, `end follow_path 5` with the status, or
    /// `clear /local_costmap/clear_entirely_local_costmap`.
    ///
    /// # Panics
    /// There is none soon.
    pub fn event(&mut self) -> String {
        let line = self.peer.line();
        self.heard.push(line.clone());
        line
    }

    /// The events up to one, with it.
    ///
    /// # Panics
    /// It does not come soon.
    pub fn until(&mut self, event: &str) -> Vec<String> {
        let end = Instant::now() + LONG;
        let mut events = Vec::new();
        while events.last().is_none_or(|it| it != event) {
            assert!(Instant::now() < end, "no {event}: {events:?}");
            events.push(self.event());
        }
        events
    }

    /// The events within a time.
    pub fn events_for(&mut self, time: Duration) -> Vec<String> {
        let events = self.peer.lines_for(time);
        self.heard.extend(events.iter().cloned());
        events
    }

    /// All events so far.
    pub fn heard(&self) -> &[String] {
        &self.heard
    }

    /// Ends the servers without a farewell.
    pub fn kill(self) {
        self.peer.kill();
    }
}
