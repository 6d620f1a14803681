//! Commands of dashboards and tools in recordings, messages that wait there, and dangerous logins.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream, UdpSocket};
use std::path::Path;
use std::process::Command;

use asmotion_recording::{RecordingItem, RunReader};
use serde_json::{Value, json};

use crate::dashboards::{LiveTab, Watched, with_dashboard};
use crate::losses::counting;
use crate::processes::{navigation, over, run_any, tool, wait_until_present};

/// A command of a tab: sets the greatest speed of the follower.
fn max_speed(id: u64, speed: f64) -> Value {
    json!({
        "type": "order", "id": id, "component": "TrajectoryFollower", "wish": { "set": [["max_speed", speed]] },
    })
}

fn replay(file: &Path, arguments: &[&str]) -> (bool, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command.arg("replay").arg(file).args(arguments);
    let output = command.output().unwrap();
    let out = String::from_utf8(output.stdout).unwrap();
    (output.status.success(), out)
}

/// A tab with the moment of a recording at its end.
fn end_of(file: &Path) -> (Watched, LiveTab, Value) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command
        .arg("dash")
        .arg(file)
        .args(["--listen", "127.0.0.1:0"]);
    let shown = Watched::start(&mut command);
    let mut tab = shown.tab();
    tab.subscribe(&["components", "steps", "log"]);
    let moment = moment(&mut tab, 1e9);
    (shown, tab, moment)
}

fn moment(tab: &mut LiveTab, t: f64) -> Value {
    tab.send(&json!({ "type": "seek", "t": t, "span": 3600.0, "window": true }));
    tab.until("the moment", |it| it["type"] == "moment")
}

/// The messages of a channel.
fn messages(file: &Path, wanted: &str) -> Vec<(f64, Value)> {
    let items = RunReader::open(file).unwrap().filter_map(|item| {
        let RecordingItem::Message { channel, at, data } = item else {
            return None;
        };
        let message = || serde_json::from_str(&data.json().unwrap()).unwrap();
        (channel == wanted).then(|| (at.seconds(), message()))
    });
    items.collect()
}

#[test]
fn commands_of_two_tabs_are_in_the_recording_with_their_origins() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.mcap");
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command
        .arg("run")
        .arg(navigation().join("navigation.composite.toml"))
        .args([
            "--clock",
            "wall",
            "--goal",
            "9,5",
            "--for",
            "600",
            "--control",
        ])
        .arg("--record")
        .arg(&file);
    let mut run = Watched::start(with_dashboard(&mut command));
    let (mut one, mut two) = (run.tab(), run.tab());
    let token = run.token().to_owned();
    assert_eq!(two.ask(&max_speed(1, 0.3))["type"], "problem");
    assert_eq!(
        one.ask(&json!({ "type": "arm", "token": token }))["type"],
        "armed"
    );
    assert_eq!(one.ask(&max_speed(2, 0.45))["type"], "done");
    assert_eq!(one.ask(&max_speed(3, -1.5))["type"], "problem");
    assert_eq!(two.ask(&max_speed(4, 0.2))["type"], "problem");
    run.interrupt();

    let commands = messages(&file, "commands");
    let told = commands.iter().map(|(_, it)| {
        let of = |name: &str| it[name].as_str().unwrap_or("no").to_owned();
        format!(
            "{} tab {} {} {}: {}",
            it["number"],
            it["tab"],
            of("login"),
            of("outcome"),
            of("text")
        )
    });
    assert_eq!(
        told.collect::<Vec<_>>(),
        [
            "1 tab 2 no refused: set TrajectoryFollower.max_speed = 0.3",
            "2 tab 1 token asked: arm",
            "2 tab 1 token done: arm",
            "3 tab 1 token asked: set TrajectoryFollower.max_speed = 0.45",
            "3 tab 1 token done: set TrajectoryFollower.max_speed = 0.45",
            "4 tab 1 token asked: set TrajectoryFollower.max_speed = -1.5",
            "4 tab 1 token refused: set TrajectoryFollower.max_speed = -1.5",
            "5 tab 2 no refused: set TrajectoryFollower.max_speed = 0.2",
        ]
    );
    assert!(commands.iter().all(|(at, it)| *at >= 0.0
        && *at < 600.0
        && it["client"].as_str().unwrap().starts_with("127.0.0.1:")));
    let bytes = std::fs::read(&file).unwrap();
    let has_token = bytes.windows(token.len()).any(|it| it == token.as_bytes());
    assert!(!has_token, "the token is in the recording");

    // the steps are the same with them
    let (is_equal, out) = replay(&file, &[]);
    assert!(is_equal, "{out}");
    assert!(out.contains("equal      ASMCoordinator"), "{out}");
    let lines: Vec<&str> = out
        .lines()
        .filter(|it| it.starts_with("  command "))
        .collect();
    assert_eq!(lines.len(), 5, "{out}");
    assert!(
        lines[0].contains(
            " tab 2: refused: set TrajectoryFollower.max_speed = 0.3: this tab is not armed"
        ),
        "{out}"
    );
    assert!(
        lines[2].contains(" tab 1 (token): done: set TrajectoryFollower.max_speed = 0.45"),
        "{out}"
    );
    assert!(
        lines[3].contains("refused: set TrajectoryFollower.max_speed = -1.5: "),
        "{out}"
    );
    let (_, json) = replay(&file, &["--json"]);
    let lines = json
        .lines()
        .map(|it| serde_json::from_str::<Value>(it).unwrap());
    let refused = lines.filter(|it| it["type"] == "command" && it["outcome"] == "refused");
    assert_eq!(refused.count(), 3);

    // and its dashboard shows them in the log, with warnings on the line of time
    let (_shown, tab, moment) = end_of(&file);
    let log = moment["window"]["log"].as_array().unwrap().iter();
    let shown: Vec<_> = log.filter(|it| it["kind"] == "command").collect();
    assert_eq!(shown.len(), 8, "{shown:#?}");
    assert!(shown[0]["component"].as_str().unwrap().ends_with(" tab 2"));
    assert_eq!(shown[0]["level"], "warning");
    assert_eq!(
        shown[4]["text"],
        "done: set TrajectoryFollower.max_speed = 0.45"
    );
    let marks = tab.system["recording"]["marks"].as_array().unwrap();
    let refused = marks
        .iter()
        .filter(|it| it[2].as_str().unwrap().starts_with("refused: "));
    assert_eq!(refused.count(), 3, "{marks:?}");
}

#[test]
fn a_refused_command_changes_no_hash_of_a_step() {
    let folder = tempfile::tempdir().unwrap();
    // slow enough for a tab to come before the end, also on a busy machine
    let last_hash = |name: &str, asks: bool| {
        let file = folder.path().join(name);
        let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
        command
            .arg("run")
            .arg(navigation().join("navigation.composite.toml"))
            .args(["--goal", "3.4,4.7", "--for", "60"])
            .args(["--speed", if asks { "1" } else { "0" }, "--record"])
            .arg(&file);
        if asks {
            let mut run = Watched::start(with_dashboard(&mut command));
            let mut tab = run.tab();
            assert_eq!(tab.ask(&max_speed(1, 0.3))["type"], "problem");
            tab.until("the end", |it| it["end"].is_string());
            run.wait();
        } else {
            let output = command.output().unwrap();
            assert!(output.status.success(), "{output:?}");
        }
        let ends = RunReader::open(&file).unwrap().filter_map(|item| {
            let RecordingItem::End(end) = item else {
                return None;
            };
            Some(end.coordinators["ASMCoordinator"].last_hash.clone())
        });
        let count = messages(&file, "commands").len();
        assert_eq!(count, usize::from(asks));
        ends.last().unwrap()
    };
    assert_eq!(
        last_hash("asked.mcap", true),
        last_hash("plain.mcap", false)
    );
}

#[test]
fn commands_of_tools_are_in_the_recording_and_in_the_dashboard() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.mcap");
    let composite = navigation().join("navigation.composite.toml");
    let mut command = over(&composite, &broker, &vhost, None);
    command.arg("--record").arg(&file);
    let mut run = Watched::start(with_dashboard(&mut command));
    wait_until_present(&vhost, "navigation");
    let mut tab = run.tab();
    tab.subscribe(&["log"]);
    let url = format!(
        "amqp://{}@{}/{}",
        broker.user(),
        broker.address(),
        vhost.name()
    );
    for (speed, code) in [("0.4", 0), ("-1.5", 1)] {
        let set = [
            "component",
            "set",
            "TrajectoryFollower",
            &format!("max_speed={speed}"),
        ];
        let (found, out, err) = tool(&broker, &url, &set);
        assert_eq!(found.map(i32::signum), Some(code), "{out}{err}");
    }
    let (_, out, err) = tool(&broker, &url, &["component", "info", "TrajectoryFollower"]);
    assert!(out.contains("0.4"), "{out}{err}");
    let is_done = |frame: &Value| {
        let log = frame["log"].as_array().into_iter().flatten();
        let mut texts = log.filter_map(|it| it["text"].as_str());
        texts.any(|it| it == "done: set TrajectoryFollower.max_speed = 0.4")
    };
    tab.until("the command of the tool", is_done);
    run.interrupt();
    let commands = messages(&file, "commands");
    let told = commands.iter().map(|(_, it)| {
        let of = |name: &str| it[name].as_str().unwrap_or("no").to_owned();
        format!("{} {}: {}", of("client"), of("outcome"), of("text"))
    });
    let told: Vec<_> = told.collect();
    assert!(
        told.contains(&"asmotion-tool done: set TrajectoryFollower.max_speed = 0.4".to_owned()),
        "{told:?}"
    );
    assert!(
        told.contains(&"asmotion-tool refused: set TrajectoryFollower.max_speed = -1.5".to_owned()),
        "{told:?}"
    );
    // questions are no commands
    assert!(
        told.iter().all(|it| it.contains("set TrajectoryFollower")),
        "{told:?}"
    );
    let (is_equal, out) = replay(&file, &[]);
    assert!(is_equal, "{out}");
}

#[test]
fn messages_that_wait_are_in_the_recording_and_in_its_dashboard() {
    let folder = tempfile::tempdir().unwrap();
    let composite = counting(folder.path(), 2000);
    let record = |name: &str| {
        let file = folder.path().join(name);
        let mut command = run_any(&composite);
        let output = command.arg("--record").arg(&file).output().unwrap();
        assert!(output.status.success(), "{output:?}");
        file
    };
    let file = record("run.mcap");
    let queues = messages(&file, "queues");
    let at = |t: f64| {
        let known = queues.iter().rfind(|(at, _)| *at <= t);
        known.map_or(0, |(_, it)| it["waiting"]["Sink"].as_u64().unwrap_or(0))
    };
    // 200 a second arrive for 5 s, and 50 a second leave
    let [early, full, late, end] = [1.05, 5.05, 15.05, 30.0].map(at);
    assert!((100..200).contains(&early), "{queues:?}");
    assert!((700..800).contains(&full), "{queues:?}");
    assert!((200..300).contains(&late), "{queues:?}");
    // the last second was not counted
    assert!(end <= 50, "{queues:?}");
    // equal runs have equal records of it
    assert_eq!(messages(&record("again.mcap"), "queues"), queues);
    let (_shown, mut tab, last) = end_of(&file);
    let waiting = |moment: &Value| {
        let components = moment["components"]["components"].as_array().unwrap();
        let sink = components.iter().find(|it| it["name"] == "Sink").unwrap();
        sink["waiting"].as_u64().unwrap_or(0)
    };
    assert_eq!(waiting(&last), end);
    assert_eq!(waiting(&moment(&mut tab, 5.05)), full);
    assert_eq!(waiting(&moment(&mut tab, 0.0)), 0);
}

#[test]
fn a_running_system_says_how_many_messages_wait() {
    let folder = tempfile::tempdir().unwrap();
    let composite = counting(folder.path(), 2000);
    let mut command = run_any(&composite);
    command.args(["--clock", "wall", "--dashboard", "127.0.0.1:0"]);
    let run = Watched::start(&mut command);
    let mut tab = run.tab();
    tab.subscribe(&["components"]);
    tab.until("messages that wait", |frame| {
        let components = frame["components"]["components"].as_array();
        let mut components = components.into_iter().flatten();
        components.any(|it| it["name"] == "Sink" && it["waiting"].as_u64() > Some(100))
    });
}

/// A way to a broker over an address of this machine that is no loopback address, as to another machine. `None` without one.
fn foreign_way(to: SocketAddr) -> Option<SocketAddr> {
    let socket = UdpSocket::bind("0.0.0.0:0").unwrap();
    // nothing is sent: this only finds the address of the interface
    socket.connect("192.0.2.1:9").ok()?;
    let own = socket.local_addr().ok()?.ip();
    if own.is_loopback() || own.is_unspecified() {
        return None;
    }
    let listener = TcpListener::bind((own, 0)).ok()?;
    let address = listener.local_addr().ok()?;
    std::thread::spawn(move || {
        for client in listener.incoming().flatten() {
            let Ok(broker) = TcpStream::connect(to) else {
                continue;
            };
            pass_on(client.try_clone().unwrap(), broker.try_clone().unwrap());
            pass_on(broker, client);
        }
    });
    Some(address)
}

fn pass_on(mut from: TcpStream, mut to: TcpStream) {
    std::thread::spawn(move || {
        let mut part = [0; 4096];
        while let Ok(count @ 1..) = from.read(&mut part) {
            if to.write_all(&part[..count]).is_err() {
                break;
            }
        }
        let _ = to.shutdown(std::net::Shutdown::Both);
    });
}

#[test]
fn the_login_guest_at_a_broker_on_another_machine_is_warned_of() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    // other tests may have made it
    let _ = broker.add_user("guest", "guest");
    vhost.permit("guest", ".*", ".*", ".*").unwrap();
    let Some(foreign) = foreign_way(broker.address()) else {
        panic!("this machine has no address besides those of its loopback interface");
    };
    let at = |place: SocketAddr| format!("amqp://guest:guest@{place}/{}", vhost.name());
    let warning = format!(
        "the login at the broker {foreign}/{} is `guest`",
        vhost.name()
    );
    let way_out = format!("rabbitmqctl set_permissions -p {} NAME", vhost.name());
    let (code, out, err) = tool(&broker, &at(foreign), &["doctor"]);
    assert_eq!(code, Some(0), "{out}{err}");
    assert!(
        out.contains("note") && out.contains(&warning) && out.contains(&way_out),
        "{out}"
    );
    let (_, out, err) = tool(&broker, &at(broker.address()), &["doctor"]);
    assert!(!out.contains("is `guest`"), "{out}{err}");

    let composite = navigation().join("navigation.composite.toml");
    let run = |place: SocketAddr| {
        let mut command = run_any(&composite);
        command.args(["--clock", "wall", "--bus", &at(place)]);
        command
    };
    // in the dashboard
    let watched = Watched::start(with_dashboard(&mut run(foreign)));
    let warnings = |tab: &LiveTab| tab.hello["warnings"].to_string();
    let tab = watched.tab();
    assert!(warnings(&tab).contains(&warning), "{}", tab.hello);
    drop(watched);
    let watched = Watched::start(with_dashboard(&mut run(broker.address())));
    assert_eq!(warnings(&watched.tab()), "[]");
    drop(watched);
    // and at the start
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command.arg("run").arg(&composite);
    command.args(["--clock", "wall", "--for", "1", "--bus", &at(foreign)]);
    let output = command.output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains(&warning) && said.contains(&way_out), "{said}");
}
