//! A foreign program joins a system: a component in Python that relies on the wire format alone.

use asmotion_bus::{Bus, CallFailure, Notifier, Payload, Request, SenderId};
use asmotion_messages::{OccupancyGrid, Path as Way, PlanRequest, Pose};
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, OnceLock};
use std::time::Duration;

use crate::processes::{Running, expected, modes, over, three_processes, wait_until_present};

const ADDRESS: &str = "TrajectoryPlanner.planning.plan";

/// The folder of the foreign program.
fn home() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/stranger")
}

/// A Python interpreter with the required packages, installed once. If they cannot be downloaded, prints a notice and
/// returns `None`, or fails if `CI` is set.
pub(super) fn python() -> Option<&'static Path> {
    static PYTHON: OnceLock<Option<PathBuf>> = OnceLock::new();
    PYTHON.get_or_init(install).as_deref()
}

fn install() -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("stranger");
    let python = folder.join("bin/python");
    let has_all = |python: &Path| {
        let tried = Command::new(python)
            .args(["-c", "import cbor2, pika"])
            .output();
        tried.is_ok_and(|it| it.status.success())
    };
    if has_all(&python) {
        return Some(python);
    }
    let made = Command::new("python3")
        .args(["-m", "venv"])
        .arg(&folder)
        .output();
    let made = made.expect("Python 3 is missing: run `./test`");
    assert!(
        made.status.success(),
        "no virtual environment: run `./test`\n{made:?}"
    );
    let mut pip = Command::new(&python);
    pip.args(["-m", "pip", "install", "--quiet", "--requirement"]);
    let installed = pip.arg(home().join("requirements.txt")).output().unwrap();
    let words = String::from_utf8_lossy(&installed.stderr);
    let unreached = words.contains("No matching distribution") || words.contains("onnection");
    if !installed.status.success() && unreached && std::env::var_os("CI").is_none() {
        // writes to the stream directly: the test harness captures what passing tests print
        let notice = format!(
            "\n*** SKIPPED: the stranger in Python, whose packages cannot be had.\n{words}\n"
        );
        let _ = std::io::stderr().write_all(notice.as_bytes());
        return None;
    }
    assert!(installed.status.success(), "{words}");
    Some(python)
}

/// The foreign program, running; killed at the end of the test.
struct Stranger(Child);

impl Stranger {
    fn start(python: &Path, url: &str, robot: &str) -> Self {
        let mut command = Command::new(python);
        command
            .arg(home().join("planner.py"))
            .args([url, robot, ADDRESS]);
        let mut child = command.stdout(Stdio::piped()).spawn().unwrap();
        let mut line = String::new();
        let out = child.stdout.take().unwrap();
        BufReader::new(out).read_line(&mut line).unwrap();
        assert_eq!(line, format!("serves {ADDRESS}\n"));
        Self(child)
    }
}

impl Drop for Stranger {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A room of 4 m with a wall across it, open at its upper end if there is a door.
fn room(door: bool) -> OccupancyGrid {
    let side = 80;
    let mut grid = OccupancyGrid::default();
    grid.header.frame_id = "map".to_owned();
    grid.info.resolution = 0.05;
    (grid.info.width, grid.info.height) = (side, side);
    let wall = |x, y| x == side / 2 && (!door || y < side - 30);
    let cells = (0..side * side).map(|at| if wall(at % side, at / side) { 100 } else { 0 });
    grid.data = cells.collect();
    grid
}

fn request(door: bool) -> PlanRequest {
    let mut request = PlanRequest {
        map: room(door),
        ..PlanRequest::default()
    };
    request.start.pose = Pose::planar(1.0, 1.0, 0.0);
    request.goal.pose = Pose::planar(3.0, 1.0, 0.0);
    request
}

fn ask(bus: &dyn Bus, request: PlanRequest) -> Result<Way, CallFailure> {
    let origin = SenderId::new("Tester", 1);
    let request = Request::new(origin, Payload::of(request), Duration::from_secs(20));
    let pending = bus
        .call(ADDRESS, request, Arc::new(Notifier::new()))
        .unwrap();
    Ok(pending.wait()?.to_datum().unwrap().to::<Way>().unwrap())
}

#[test]
fn it_is_no_longer_than_a_page() {
    let text = std::fs::read_to_string(home().join("planner.py")).unwrap();
    assert!(text.lines().count() <= 60, "{} lines", text.lines().count());
}

#[test]
fn it_serves_what_we_call() {
    let (Some(broker), Some(python)) = (asmotion_broker::calm(), python()) else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let _stranger = Stranger::start(python, &vhost.url(), "rover1");
    let mut settings = asmotion_amqp::AmqpSettings::parse(&vhost.url()).unwrap();
    settings.robot = Some("rover1".to_owned());
    let bus = asmotion_amqp::AmqpBus::connect(settings, Duration::from_secs(10)).unwrap();

    let way = ask(&bus, request(true)).unwrap();
    let at = |index: usize| way.poses[index].pose.position;
    let crossing = (0..way.poses.len())
        .find(|index| at(*index).x > 2.0)
        .unwrap();
    assert!(
        at(crossing).y > 2.5,
        "it goes round the wall: {:?}",
        at(crossing)
    );
    assert_eq!(way.poses.last().unwrap().pose, Pose::planar(3.0, 1.0, 0.0));

    let refused = ask(&bus, request(false)).unwrap_err();
    assert!(
        matches!(&refused, CallFailure::Refused(it) if it.code == "NO_PATH"),
        "{refused}"
    );
}

#[test]
fn a_mission_runs_with_it_in_place_of_our_planner() {
    let (Some(broker), Some(python)) = (asmotion_broker::calm(), python()) else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let composite = three_processes(folder.path());
    let _stranger = Stranger::start(python, &vhost.url(), "navigation");
    let onboard = Running::start(&mut over(&composite, &broker, &vhost, Some("onboard")));
    wait_until_present(&vhost, "onboard");
    let mut supervisor = over(&composite, &broker, &vhost, Some("supervisor"));
    assert_eq!(modes(&supervisor.output().unwrap()), expected());
    assert_eq!(modes(&onboard.interrupt()), (Vec::new(), Some(0)));
}
