//! C18: wires of a running process to another robot and to another system.

use std::fs::File;
use std::path::Path;
use std::time::{Duration, Instant};

use asmotion_broker::{SharedBroker, Vhost};

use super::over_brokers::{ADDER, ASKER};
use crate::processes::{Running, queues, run_any, through, tool};

/// Timeout for a loaded machine.
const LONG: Duration = Duration::from_secs(60);

/// A robot whose adder is offered over the broker and over HTTP.
const ARM: &str = r#"
schema = "composite/1"
[composite]
name = "arm"
[gateways.main]
listen = "127.0.0.1:0"
[components.Adder]
implementation = { asm = "adder.asm" }
task = { period_ms = 20 }
services = { adding = "test/Adds" }
[[promote]]
service = "Adder.adding"
as = "adding"
binding = "http"
"#;

/// A station that asks for a sum.
const STATION: &str = r#"
schema = "composite/1"
[composite]
name = "station"
[brokers.main]
url = "amqp://station@desk:5672/cell"
[components.Asker]
implementation = { asm = "asker.asm" }
task = { period_ms = 20 }
references = { sums = { interface = "test/Adds", optional = true } }
"#;

fn wire(binding: &str, url: &str) -> String {
    format!(
        "[[wires]]\nreference = \"Asker.sums\"\nbinding = \"{binding}\"\nurl = \"{url}\"\ntimeout_ms = 5000\n"
    )
}

/// A station that is changed while it runs.
struct Station<'b> {
    broker: &'b SharedBroker,
    vhost: &'b Vhost<'b>,
    folder: &'b Path,
}

impl Station<'_> {
    fn tool(&self, arguments: &[&str]) -> (Option<i32>, String, String) {
        let (user, address) = (self.broker.user(), self.broker.address());
        let url = format!("amqp://{user}@{address}/{}", self.vhost.name());
        tool(self.broker, &url, arguments)
    }

    fn start(&self, name: &str, text: &str) -> Running {
        let path = self.folder.join(format!("{name}.composite.toml"));
        std::fs::write(&path, text).unwrap();
        let mut command = through(run_any(&path), self.broker, self.vhost, None);
        let output = File::create(self.folder.join(format!("{name}.out"))).unwrap();
        Running::start(command.stdout(output))
    }

    /// Waits until the output of the station contains a text.
    #[track_caller]
    fn says(&self, text: &str) {
        let until = Instant::now() + LONG;
        loop {
            let said = std::fs::read_to_string(self.folder.join("station.out")).unwrap();
            if said.contains(text) {
                return;
            }
            assert!(Instant::now() < until, "{text}");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// Changes the wires of the station.
    fn becomes(&self, wires: &str) -> (Option<i32>, String) {
        let path = self.folder.join("station.composite.toml");
        std::fs::write(&path, format!("{STATION}{wires}")).unwrap();
        let (code, out, err) = self.tool(&["reconfigure", path.to_str().unwrap()]);
        (code, out + &err)
    }

    /// Changes the wires of the station, and waits until it is in this mode. The changes must contain all of these texts.
    #[track_caller]
    fn is_in(&self, mode: &str, wires: &str, changes: &[&str]) {
        let (code, said) = self.becomes(wires);
        assert_eq!(code, Some(0), "{said}");
        for change in changes {
            assert!(said.contains(change), "{change}: {said}");
        }
        let until = Instant::now() + LONG;
        loop {
            let (_, out, err) = self.tool(&["component", "info", "Asker"]);
            if out.contains(&format!("mode = {mode}")) {
                return;
            }
            assert!(Instant::now() < until, "{mode}: {out}{err}");
        }
    }
}

#[test]
fn c18_a_running_process_is_wired_to_another_robot_and_to_a_system_over_http() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in [("adder", ADDER), ("asker", ASKER)] {
        std::fs::write(folder.path().join(format!("{name}.asm")), text).unwrap();
    }
    let station = Station {
        broker: &broker,
        vhost: &vhost,
        folder: folder.path(),
    };
    let mut arm = station.start("arm", ARM);
    let url = format!("{}/adding", arm.listening());
    queues(&vhost, "robots.services.arm.Adder.adding");
    let process = station.start("station", STATION);
    queues(&vhost, "robots.services.station.control.station");

    let robot = wire("amqp", "robot://arm/Adder.adding");
    let added = "`Asker.sums` is wired to `robot://arm/Adder.adding`";
    let removed = "`Asker.sums` is unwired from `robot://arm/Adder.adding`";
    station.is_in("LOST", "", &["no changes"]);
    station.is_in("ANSWERED", &robot, &[added]);
    station.is_in("LOST", "", &[removed]);
    let system = wire("http", &url);
    let to_system = format!("`Asker.sums` is wired to `{url}`");
    station.is_in("ANSWERED", &system, &[&to_system]);
    // the new wire is compared with what the robot announces, as one from the start
    let wrong = wire("amqp", "robot://arm/Adder.adding2");
    station.is_in("LOST", &wrong, &["`Asker.sums` is unwired from `http"]);
    station.says("robot `arm` has no service `Adder.adding2`, which `Asker.sums` calls");
    station.is_in("ANSWERED", &robot, &[added]);

    // what cannot be reached changes nothing
    let own = wire("amqp", "robot://station/Asker.sums");
    let (code, said) = station.becomes(&own);
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("is a service of this robot"), "{said}");
    let key = "ca = \"none.pem\"\ntimeout_ms";
    let untrusted = wire("http", "https://localhost:1/adding").replace("timeout_ms", key);
    let (code, said) = station.becomes(&untrusted);
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("none.pem"), "{said}");
    station.is_in("ANSWERED", &robot, &["no changes"]);
    drop((process, arm));
}
