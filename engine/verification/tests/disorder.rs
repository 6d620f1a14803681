//! Components alone, with messages in an order and with contents that no composite sends.

use crate::conformance::assert_allowed;
use crate::scenarios::{Conformance, Dice, Scenario, observed};
use crate::support::Files;

/// A component of the catalogue with its input and output ports.
struct Alone {
    implementation: &'static str,
    period_ms: u64,
    inputs: &'static [(&'static str, &'static str)],
    outputs: &'static [(&'static str, &'static str)],
    /// Returns the content of a message for an input.
    content: fn(&str, u64, &mut Dice) -> String,
}

const ALONE: [Alone; 5] = [
    Alone {
        implementation: "nav::TrajectoryFollower",
        period_ms: 50,
        inputs: &[
            ("path", "nav_msgs/Path"),
            ("odom", "nav_msgs/Odometry"),
            ("scan", "sensor_msgs/LaserScan"),
            ("permit", "std_msgs/Bool"),
        ],
        outputs: &[("twist", "geometry_msgs/Twist"), ("event", "nav/Event")],
        content,
    },
    Alone {
        implementation: "nav::TrajectoryAdapter",
        period_ms: 100,
        inputs: &[
            ("path", "nav_msgs/Path"),
            ("odom", "nav_msgs/Odometry"),
            ("scan", "sensor_msgs/LaserScan"),
            ("permit", "std_msgs/Bool"),
        ],
        outputs: &[
            ("adapted", "nav_msgs/Path"),
            ("event", "nav/Event"),
            ("obstacles", "nav/Obstacles"),
        ],
        content,
    },
    Alone {
        implementation: "nav::sim::RoverDriver",
        period_ms: 20,
        inputs: &[
            ("twist", "geometry_msgs/Twist"),
            ("encoders", "rover/Encoders"),
        ],
        outputs: &[
            ("wheels", "rover/WheelSpeeds"),
            ("odom", "nav_msgs/Odometry"),
            ("event", "nav/Event"),
        ],
        content,
    },
    Alone {
        implementation: "nav::CollisionMonitor",
        period_ms: 20,
        inputs: &[
            ("command", "geometry_msgs/Twist"),
            ("odom", "nav_msgs/Odometry"),
            ("scan", "sensor_msgs/LaserScan"),
        ],
        outputs: &[("twist", "geometry_msgs/Twist"), ("event", "nav/Event")],
        content,
    },
    Alone {
        implementation: "nav::sim::LaserDriver",
        period_ms: 50,
        inputs: &[
            ("scene", "world/Scene"),
            ("truth", "geometry_msgs/PoseStamped"),
        ],
        outputs: &[("scan", "sensor_msgs/LaserScan")],
        content,
    },
];

fn stamp(at: u64) -> String {
    format!(
        r#""stamp": {{"sec": {}, "nanosec": {}}}"#,
        at / 1000,
        at % 1000 * 1_000_000
    )
}

/// A message for an input with this name.
fn content(input: &str, at: u64, dice: &mut Dice) -> String {
    let pose =
        |x: u64| format!(r#""pose": {{"position": {{"x": {x}.0}}, "orientation": {{"w": 1.0}}}}"#);
    match input {
        // one of few orders, with few ends, so that amendments and repetitions occur
        "path" => {
            let order = dice.below(3);
            let poses: Vec<String> = match dice.below(4) {
                0 => Vec::new(),
                1 => vec![pose(0)],
                _ => vec![pose(0), pose(1 + order % 2)],
            };
            let poses: Vec<String> = poses.iter().map(|it| format!("{{{it}}}")).collect();
            format!(
                r#"{{"header": {{"stamp": {{"sec": {order}}}, "frame_id": "map"}}, "poses": [{}]}}"#,
                poses.join(", ")
            )
        }
        "odom" => {
            let speed = if dice.below(3) == 0 { "0.3" } else { "0.0" };
            let place = pose(dice.below(3));
            format!(
                r#"{{"header": {{{}, "frame_id": "map"}}, "pose": {{{place}}}, "twist": {{"twist": {{"linear": {{"x": {speed}}}}}}}}}"#,
                stamp(at)
            )
        }
        "scan" => {
            let range = ["0.05", "0.6", "3.0", "9.0"][dice.below(4) as usize];
            format!(
                r#"{{"header": {{{}}}, "angle_min": -0.4, "angle_max": 0.4, "angle_increment": 0.1, "range_min": 0.01, "range_max": 8.0, "ranges": [{}]}}"#,
                stamp(at),
                [range; 9].join(", ")
            )
        }
        "permit" => format!(r#"{{"data": {}}}"#, dice.below(3) > 0),
        "twist" | "command" => {
            let speed = ["0.0", "0.3", "-0.3"][dice.below(3) as usize];
            format!(r#"{{"linear": {{"x": {speed}}}}}"#)
        }
        // wheels that stand most of the time
        "encoders" => format!(
            r#"{{{}, "left": {}.0, "right": 0.0}}"#,
            stamp(at),
            if dice.below(20) == 0 { 1 } else { 0 }
        ),
        "truth" => format!(
            r#"{{"header": {{{}}}, {}}}"#,
            stamp(at),
            pose(dice.below(2))
        ),
        _ => "{}".to_owned(),
    }
}

impl Alone {
    fn composite(&self) -> String {
        let ports = |ports: &[(&str, &str)]| {
            let ports: Vec<String> = ports
                .iter()
                .map(|(name, kind)| format!("{name} = {kind:?}"))
                .collect();
            ports.join(", ")
        };
        let promoted: Vec<String> = self
            .inputs
            .iter()
            .chain(self.outputs)
            .map(|(name, _)| format!("[[promote]]\ntopic = \"{name}\"\nas = \"{name}\"\n"))
            .collect();
        format!(
            "schema = \"composite/1\"\n[composite]\nname = \"alone\"\n[components.Tested]\nimplementation = {{ rust = {:?} }}\n\
             activity = {{ period_ms = {} }}\nsubscribe = {{ {} }}\npublish = {{ {} }}\n{}",
            self.implementation,
            self.period_ms,
            ports(self.inputs),
            ports(self.outputs),
            promoted.concat()
        )
    }

    /// Messages for random inputs; some inputs are silent for a while.
    fn scenario(&self, seed: u64) -> Scenario {
        let mut dice = Dice(seed);
        let mut messages = Vec::new();
        let mut silent = 0;
        let seconds = 60;
        for at in (0..seconds * 1000).step_by(20) {
            if at % 2000 == 0 {
                silent = dice.next();
            }
            for (number, (input, _)) in self.inputs.iter().enumerate() {
                let is_silent = silent >> (3 * number) & 7 == 0;
                let due = match *input {
                    "path" => dice.below(60) == 0,
                    "permit" => dice.below(30) == 0,
                    _ => dice.below(3) == 0,
                };
                if due && !is_silent {
                    let content = (self.content)(input, at, &mut dice);
                    messages.push((at, (*input).to_owned(), content));
                }
            }
        }
        Scenario {
            composite: "alone.composite.toml",
            messages,
            seconds,
            seed,
            ..Scenario::default()
        }
    }

    pub fn observed(&self, files: &Files, seeds: std::ops::Range<u64>) -> Conformance {
        let files = files.clone().with("alone.composite.toml", self.composite());
        let scenarios: Vec<Scenario> = seeds.map(|seed| self.scenario(seed)).collect();
        observed(&scenarios, &files)
    }
}

/// The use that the component in a folder makes of files.
pub fn observed_alone(folder: &str, files: &Files) -> Conformance {
    let implementation = match folder {
        "follower" => "nav::TrajectoryFollower",
        "adapter" => "nav::TrajectoryAdapter",
        "rover" => "nav::sim::RoverDriver",
        "collision-monitor" => "nav::CollisionMonitor",
        "laser" => "nav::sim::LaserDriver",
        other => panic!("{other} is not among the components alone"),
    };
    let alone = ALONE.iter().find(|it| it.implementation == implementation);
    alone.expect("a component").observed(files, 0..6)
}

#[test]
fn components_alone_do_what_their_protocols_say() {
    for alone in &ALONE {
        let found = alone.observed(&Files::default(), 0..6);
        assert_allowed(&found, &[alone.implementation], &[]);
    }
}
