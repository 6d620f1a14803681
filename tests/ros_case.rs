//! The lower half of the paper's Figure 1 as nodes of ROS, and the upper half as components: over the local bus, and over RabbitMQ.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use asmotion_ros_master::{Master, Process, eventually};

use crate::processes::through;

fn composite() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/ros_case/figure1.composite.toml")
}

/// The nodes of the lower half.
struct LowerHalf {
    drivers: Process,
    adapter: Process,
    _follower: Process,
}

impl LowerHalf {
    fn start(master: &Master) -> Self {
        let [drivers, adapter, follower] = ["drivers", "adapter", "follower"].map(|what| {
            let node = master.peer("lower_half", &[what]);
            assert_eq!(node.line(), "ready");
            node
        });
        Self {
            drivers,
            adapter,
            _follower: follower,
        }
    }

    /// Checks that the robot was blocked, drove along a second path, and stands at the goal.
    fn assert_arrived_with_a_replan(&self) {
        let lines: Vec<String> = std::iter::from_fn(|| self.adapter.try_line()).collect();
        let paths = |lines: &[String]| {
            let plans = lines.iter().filter_map(|line| line.strip_prefix("plan "));
            plans.filter(|count| *count != "0").count()
        };
        let blocked = lines.iter().position(|line| line == "blocked");
        let blocked = blocked.unwrap_or_else(|| panic!("never blocked: {lines:?}"));
        let (before, after) = lines.split_at(blocked);
        assert_eq!((paths(before), paths(after)), (1, 1), "{lines:?}");
        let mut line = self.drivers.line();
        while let Some(next) = self.drivers.try_line() {
            line = next;
        }
        let at: Vec<f64> = line
            .split(' ')
            .filter_map(|word| word.parse().ok())
            .collect();
        let [x, y] = at[..] else { panic!("{line}") };
        assert!((x - 5.4).hypot(y - 4.7) < 0.3, "{line}");
    }
}

fn run(master: &Master) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command
        .arg("run")
        .arg(composite())
        .args(["--clock", "wall", "--for", "60"])
        .env("ROS_MASTER_URI", master.uri())
        .stdin(Stdio::null());
    command
}

#[test]
fn n6_figure_1_with_a_lower_half_of_ros_reaches_the_goal_with_a_replan() {
    let Some(master) = Master::start() else {
        return;
    };
    let lower = LowerHalf::start(&master);
    let mut mission = run(&master);
    let mission = mission.stderr(Stdio::piped()).spawn().unwrap();
    // the tools of ROS see the proxy of the paper as a node with the topics of its map, in both directions
    let node = "/navigation_RosProxy";
    eventually("the proxy is a node", || {
        let info = master.tool("rosnode", &["info", node]);
        let (published, subscribed) = info.split_once("Subscriptions:")?;
        let has = |part: &str, topics: &[&str]| topics.iter().all(|topic| part.contains(topic));
        let is_complete = has(
            published,
            &["* /plan [nav_msgs/Path]", "* /permit [std_msgs/Bool]"],
        ) && has(
            subscribed,
            &["* /odom [nav_msgs/Odometry]", "* /event [std_msgs/String]"],
        );
        is_complete.then_some(())
    });
    let output = mission.wait_with_output().unwrap();
    let story = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{story}");
    assert!(story.contains("ARRIVED"), "{story}");
    lower.assert_arrived_with_a_replan();
}

#[test]
fn figure_1_over_rabbitmq_in_two_processes() {
    let Some(master) = Master::start() else {
        return;
    };
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let lower = LowerHalf::start(&master);
    let mut proxy = through(run(&master), &broker, &vhost, Some("proxy"));
    let mut proxy = proxy.stderr(Stdio::piped()).spawn().unwrap();
    let lines = BufReader::new(proxy.stderr.take().unwrap()).lines();
    let (sender, registered) = std::sync::mpsc::channel();
    std::thread::spawn(move || {
        for line in lines.map_while(Result::ok) {
            let _ = sender.send(line);
        }
    });
    while !registered
        .recv_timeout(asmotion_ros_master::SOON)
        .unwrap()
        .contains("registered at the ROS master")
    {}
    let supervisor = through(run(&master), &broker, &vhost, Some("supervisor"));
    let output = { supervisor }.output().unwrap();
    let _ = proxy.kill();
    let _ = proxy.wait();
    let story = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{story}");
    assert!(story.contains("ARRIVED"), "{story}");
    lower.assert_arrived_with_a_replan();
}
