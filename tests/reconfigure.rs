//! C18: a running composite changes to its next version without a restart, or does not change at all.

mod instances;
mod over_brokers;
mod topics_over_brokers;
mod wires_outside;

use crate::processes::{
    Running, over, run_any, three_processes, through, tool, wait_until_present,
};

#[test]
fn c18_a_running_composite_becomes_its_next_version_or_stays_what_it_is() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let (user, address) = (broker.user(), broker.address());
    let url = format!("amqp://{user}@{address}/{}", vhost.name());
    let folder = tempfile::tempdir().unwrap();
    let composite = three_processes(folder.path());
    let path = composite.to_str().unwrap();
    let first = std::fs::read_to_string(&composite).unwrap();
    let becomes = |changes: &[(&str, &str)]| {
        let mut text = first.clone();
        for (from, to) in changes {
            assert!(text.contains(from), "{from}");
            text = text.replacen(from, to, 1);
        }
        std::fs::write(&composite, text).unwrap();
    };
    let names = ["onboard", "planning"];
    let running =
        names.map(|process| Running::start(&mut over(&composite, &broker, &vhost, Some(process))));
    names
        .iter()
        .for_each(|name| wait_until_present(&vhost, name));
    let reconfigure = |more: &[&str]| {
        let arguments = [&["reconfigure", path], more].concat();
        tool(&broker, &url, &arguments)
    };
    let (code, out, err) = reconfigure(&[]);
    assert_eq!(code, Some(0), "{err}");
    assert_eq!(out, "onboard: no changes\nplanning: no changes\n");
    assert!(err.contains("`supervisor` does not run"), "{err}");
    assert!(!err.contains("`planning`"), "{err}");

    // the error is shown at its place, and no process is affected
    becomes(&[(
        "to     = \"RoverDriver.twist\"",
        "to     = \"RoverDriver.twits\"",
    )]);
    let (code, _, err) = reconfigure(&[]);
    assert_eq!(code, Some(1), "{err}");
    assert!(err.contains("twits"), "{err}");

    // one process cannot change, so none does
    let faster = (
        "rust = \"nav::sim::RoverDriver\" }\nactivity  = { period_ms = 20 }",
        "rust = \"nav::sim::RoverDriver\" }\nactivity  = { period_ms = 10 }",
    );
    becomes(&[faster, ("id = \"planner\"", "id = \"another\"")]);
    let (code, out, err) = reconfigure(&[]);
    assert_eq!(code, Some(1), "{err}");
    assert!(
        out.contains("onboard: `RoverDriver` cycles every 10ms"),
        "{out}"
    );
    assert!(
        err.contains("planning: NEEDS_START: `TrajectoryPlanner` differs in `task.id`; only"),
        "{err}"
    );
    assert!(err.contains("runs unchanged"), "{err}");

    let noisy = (
        "properties = { seed = \"${properties.seed}\" }",
        "properties = { seed = \"${properties.seed}\", noise_m = 0.125 }",
    );
    becomes(&[faster, noisy]);
    let expected = "onboard: `LaserDriver` has noise_m = 0.125\n\
                    onboard: `RoverDriver` cycles every 10ms\n\
                    planning: no changes\n";
    let (code, out, err) = reconfigure(&["--try"]);
    assert_eq!((code, &*out), (Some(0), expected), "{err}");
    let (code, out, err) = reconfigure(&[]);
    assert_eq!((code, &*out), (Some(0), expected), "{err}");
    let (_, out, err) = tool(&broker, &url, &["component", "info", "LaserDriver"]);
    assert!(out.contains("noise_m = 0.125"), "{out}{err}");
    let (code, out, _) = reconfigure(&[]);
    assert_eq!(code, Some(0));
    assert_eq!(out, "onboard: no changes\nplanning: no changes\n");
    for process in running {
        assert!(process.interrupt().status.success());
    }
}

/// A second laser on board, and a second planner, which other processes could call.
const REAR_LASER: &[(&str, &str)] = &[
    (
        "[components.RoverDriver]",
        "[components.RearLaser]\n\
         implementation = { rust = \"nav::sim::LaserDriver\" }\n\
         activity   = { period_ms = 50 }\n\
         ports.in   = { scene = \"world/Scene\", truth = \"geometry_msgs/PoseStamped\" }\n\
         ports.out  = { scan = \"sensor_msgs/LaserScan\" }\n\
         properties = { noise_m = 0.25 }\n\n\
         [components.RoverDriver]",
    ),
    (
        "to     = \"LaserDriver.truth\"",
        "to     = [\"LaserDriver.truth\", \"RearLaser.truth\"]",
    ),
    (
        "to     = \"LaserDriver.scene\"",
        "to     = [\"LaserDriver.scene\", \"RearLaser.scene\"]",
    ),
    (
        "\"LaserDriver\", \"RoverDriver\"",
        "\"LaserDriver\", \"RearLaser\", \"RoverDriver\"",
    ),
];
const SPARE_PLANNER: &[(&str, &str)] = &[
    (
        "[components.TrajectoryPlanner]",
        "[components.Spare]\n\
         implementation = { rust = \"nav::TrajectoryPlanner\" }\n\
         task       = { id = \"spare\", period_ms = 100 }\n\
         services   = { planning = \"nav/PlanService\" }\n\
         ports.in   = { obstacles = \"nav/Obstacles\" }\n\n\
         [components.TrajectoryPlanner]",
    ),
    (
        "to     = \"TrajectoryPlanner.obstacles\"",
        "to     = [\"TrajectoryPlanner.obstacles\", \"Spare.obstacles\"]",
    ),
    (
        "components = [\"TrajectoryPlanner\"]",
        "components = [\"TrajectoryPlanner\", \"Spare\"]",
    ),
];

#[test]
fn c18_a_component_is_removed_from_a_running_process_and_added_again() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let (user, address) = (broker.user(), broker.address());
    let url = format!("amqp://{user}@{address}/{}", vhost.name());
    let folder = tempfile::tempdir().unwrap();
    let composite = three_processes(folder.path());
    let path = composite.to_str().unwrap();
    let first = std::fs::read_to_string(&composite).unwrap();
    let becomes = |changes: &[(&str, &str)]| {
        let mut text = first.clone();
        for (from, to) in changes {
            assert!(text.contains(from), "{from}");
            text = text.replacen(from, to, 1);
        }
        std::fs::write(&composite, text).unwrap();
    };
    becomes(REAR_LASER);
    let trace = folder.path().join("onboard.trace");
    let names = ["onboard", "planning"];
    let running = names.map(|process| {
        let mut command = through(run_any(&composite), &broker, &vhost, Some(process));
        if process == "onboard" {
            command.args(["--set", "RearLaser.noise_m=0.5"]);
            command.arg("--trace").arg(&trace);
        }
        Running::start(&mut command)
    });
    names
        .iter()
        .for_each(|name| wait_until_present(&vhost, name));
    let run = |arguments: &[&str]| tool(&broker, &url, arguments);

    // a component that reads a port of another process, and whose service others could call
    becomes(&[REAR_LASER, SPARE_PLANNER].concat());
    let (code, out, err) = run(&["reconfigure", path]);
    assert_eq!(code, Some(0), "{err}");
    let added = "onboard: no changes\n\
                 planning: `Spare` is added and runs `nav::TrajectoryPlanner`\n\
                 planning: `Spare.obstacles` receives bus topic port.TrajectoryAdapter.obstacles\n";
    assert_eq!(out, added, "{err}");
    let address = "robots.services.navigation.Spare.planning";
    crate::processes::queues(&vhost, address);
    becomes(REAR_LASER);
    let (code, out, err) = run(&["reconfigure", path]);
    assert_eq!(code, Some(0), "{err}");
    assert_eq!(
        out, "onboard: no changes\nplanning: `Spare` is removed\n",
        "{err}"
    );
    let queues = vhost.queues().unwrap();
    assert!(
        !queues.iter().any(|it| it.starts_with(address)),
        "{queues:?}"
    );

    // the queue of a connection between processes stays as it is
    let to = "to     = \"TrajectoryPlanner.obstacles\"\npolicy = { type = \"data\" }";
    let buffered = to.replace("\"data\"", "\"buffer\", size = 4");
    becomes(&[REAR_LASER, &[(to, &*buffered)]].concat());
    let (code, _, err) = run(&["reconfigure", path]);
    assert_eq!(code, Some(1), "{err}");
    let reason = "planning: NEEDS_START: the connection from `TrajectoryAdapter.obstacles` to \
                  `TrajectoryPlanner.obstacles` needs another queue at the broker: remove it, and add it with its new policy in a \
                  second step";
    assert!(err.contains(reason), "{err}");
    assert!(err.contains("runs unchanged"), "{err}");

    // everything else of its policy is a matter of the reader
    let aged = to.replace("\"data\"", "\"data\", max_age_ms = 60000");
    becomes(&[REAR_LASER, &[(to, &*aged)]].concat());
    let changed = "onboard: no changes\n\
                   planning: `TrajectoryPlanner.obstacles` no longer receives bus topic port.TrajectoryAdapter.obstacles\n\
                   planning: `TrajectoryPlanner.obstacles` receives bus topic port.TrajectoryAdapter.obstacles\n";
    let (code, out, err) = run(&["reconfigure", path]);
    assert_eq!((code, &*out), (Some(0), changed), "{err}");
    becomes(REAR_LASER);
    let (code, out, err) = run(&["reconfigure", path]);
    assert_eq!((code, &*out), (Some(0), changed), "{err}");

    becomes(&[]);
    let removed = "onboard: `World.truth` is disconnected from `RearLaser.truth`\n\
                   onboard: `World.scene` is disconnected from `RearLaser.scene`\n\
                   onboard: `RearLaser` is removed\n\
                   planning: no changes\n";
    let (code, out, err) = run(&["reconfigure", path]);
    assert_eq!((code, &*out), (Some(0), removed), "{err}");
    let (_, out, err) = run(&["component", "list"]);
    assert!(out.contains("LaserDriver"), "{out}{err}");
    assert!(!out.contains("RearLaser"), "{out}{err}");

    becomes(REAR_LASER);
    let added = "onboard: `RearLaser` is added and runs `nav::sim::LaserDriver`\n\
                 onboard: `World.truth` is connected to `RearLaser.truth`\n\
                 onboard: `World.scene` is connected to `RearLaser.scene`\n\
                 planning: no changes\n";
    let (code, out, err) = run(&["reconfigure", path, "--try"]);
    assert_eq!((code, &*out), (Some(0), added), "{err}");
    let (code, out, err) = run(&["reconfigure", path]);
    assert_eq!((code, &*out), (Some(0), added), "{err}");
    let (_, out, err) = run(&["component", "info", "RearLaser"]);
    assert!(out.contains("Running"), "{out}{err}");
    assert!(out.contains("noise_m = 0.5"), "as it was set: {out}{err}");
    let (code, out, err) = run(&["component", "stop", "RearLaser"]);
    assert_eq!(code, Some(0), "{out}{err}");
    let (code, out, err) = run(&["component", "start", "RearLaser"]);
    assert_eq!(code, Some(0), "{out}{err}");
    let mut ended = running.into_iter().map(Running::interrupt);
    assert!(ended.all(|process| process.status.success()));
    let written = std::fs::read_to_string(&trace).unwrap();
    for line in [
        "report RearLaser added \"`nav::sim::LaserDriver`\"",
        "life RearLaser Stopped Running",
        "publish RearLaser.scan",
        "report RearLaser removed",
    ] {
        assert!(written.contains(line), "{line}");
    }
}

#[test]
fn c18_a_specification_is_replaced_while_it_runs_or_refused_with_the_invariant_that_does_not_hold()
{
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let (user, address) = (broker.user(), broker.address());
    let url = format!("amqp://{user}@{address}/{}", vhost.name());
    let folder = tempfile::tempdir().unwrap();
    let composite = three_processes(folder.path());
    let path = composite.to_str().unwrap();
    let specification = folder.path().join("navigate.asm");
    let first = std::fs::read_to_string(&specification).unwrap();
    let becomes = |from: &str, to: &str| {
        assert!(first.contains(from), "{from}");
        std::fs::write(&specification, first.replacen(from, to, 1)).unwrap();
    };
    let trace = folder.path().join("supervisor.trace");
    let names = ["onboard", "planning", "supervisor"];
    let running = names.map(|process| {
        let mut command = through(run_any(&composite), &broker, &vhost, Some(process));
        if process == "supervisor" {
            command.arg("--trace").arg(&trace);
        }
        Running::start(&mut command)
    });
    names
        .iter()
        .for_each(|name| wait_until_present(&vhost, name));
    let reconfigure = |more: &[&str]| {
        let arguments = [&["reconfigure", path], more].concat();
        tool(&broker, &url, &arguments)
    };

    becomes(
        "\tinvariant inv_bounded",
        "\tinvariant inv_never over tries: tries < 0\n\tinvariant inv_bounded",
    );
    let (code, _, err) = reconfigure(&["--try"]);
    assert_eq!(code, Some(1), "{err}");
    assert!(
        err.contains("the invariant `inv_never` does not hold"),
        "{err}"
    );
    assert!(err.contains("navigate.asm:"), "{err}");
    assert!(err.contains("runs unchanged"), "{err}");
    let refused = reconfigure(&[]);
    assert_eq!(refused.0, Some(1), "{}", refused.2);

    // a broken file is shown at its place, and asks no process
    becomes("\tmain rule r_Main =", "\tmain rule r_Main = par");
    let (code, out, err) = reconfigure(&[]);
    assert_eq!((code, &*out), (Some(1), ""), "{err}");
    assert!(
        err.contains("error[L031]") && err.contains("navigate.asm:"),
        "{err}"
    );

    // the control state has another name, whichever it is
    let mut renamed = first.clone();
    for mode in [
        "IDLE",
        "WAIT_MAP",
        "WAIT_PATH",
        "FOLLOWING",
        "STOPPING",
        "ARRIVED",
        "FAILED",
    ] {
        for before in [" ", "{", "[", "("] {
            renamed = renamed.replace(&format!("{before}{mode}"), &format!("{before}NOW_{mode}"));
        }
    }
    std::fs::write(&specification, renamed).unwrap();
    let (code, _, err) = reconfigure(&[]);
    assert_eq!(code, Some(1), "{err}");
    let reason = "supervisor: REFUSED: `ASMCoordinator` cannot be replaced: `mode` is ";
    assert!(err.contains(reason), "{err}");
    assert!(
        err.contains(", which does not exist in the new version") && err.contains("runs unchanged"),
        "{err}"
    );

    becomes(
        "\tcontrolled tries: Tries",
        "\tcontrolled tries: Tries\n\tcontrolled laps: Integer",
    );
    let expected = "onboard: no changes\nplanning: no changes\n\
                    supervisor: `ASMCoordinator` runs another version of `navigate.asm`\n\
                    supervisor: `laps` begins with its initial value\n";
    for arguments in [["--try"].as_slice(), &[]] {
        let (code, out, err) = reconfigure(arguments);
        assert_eq!((code, &*out), (Some(0), expected), "{err}");
    }
    let (_, out, _) = reconfigure(&[]);
    assert!(out.contains("supervisor: no changes"), "{out}");
    let mut ended = running.into_iter().map(Running::interrupt);
    assert!(ended.all(|process| process.status.success()));
    let written = std::fs::read_to_string(&trace).unwrap();
    let reports = written
        .lines()
        .filter(|it| it.contains("report ASMCoordinator replaced "));
    let reports: Vec<_> = reports.collect();
    assert_eq!(reports.len(), 1, "{reports:?}");
    assert!(
        reports[0].contains("another version of `navigate.asm`"),
        "{reports:?}"
    );
    let arguments = [
        "sim",
        specification.to_str().unwrap(),
        "--replay-inputs",
        trace.to_str().unwrap(),
    ];
    let (code, _, err) = tool(&broker, &url, &arguments);
    assert_ne!(code, Some(0));
    assert!(err.contains("`ASMCoordinator` was replaced at"), "{err}");
}

#[test]
fn c18_two_specifications_that_talk_to_each_other_are_replaced_together_or_not_at_all() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let (user, address) = (broker.user(), broker.address());
    let url = format!("amqp://{user}@{address}/{}", vhost.name());
    let folder = tempfile::tempdir().unwrap();
    let specs = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("specs/courier");
    let names = [
        "Dispatch.asm",
        "courier.asm",
        "dispatcher.asm",
        "courier.composite.toml",
    ];
    for name in names {
        std::fs::copy(specs.join(name), folder.path().join(name)).unwrap();
    }
    let composite = folder.path().join("courier.composite.toml");
    let path = composite.to_str().unwrap();
    let becomes = |name: &str, from: &str, to: &str| {
        let text = std::fs::read_to_string(specs.join(name)).unwrap();
        assert!(text.contains(from), "{from}");
        std::fs::write(folder.path().join(name), text.replace(from, to)).unwrap();
    };
    let running = Running::start(&mut through(run_any(&composite), &broker, &vhost, None));
    crate::processes::queues(&vhost, "robots.services.courier.control.courier");
    let reconfigure = || tool(&broker, &url, &["reconfigure", path]);

    // the second one could change
    becomes("dispatcher.asm", "place + 3", "place + 4");
    becomes("courier.asm", "jobs >= 0", "jobs < 0");
    let (code, out, err) = reconfigure();
    assert_eq!((code, &*out), (Some(1), ""), "{err}");
    assert!(
        err.contains("the invariant `jobs < 0` does not hold"),
        "{err}"
    );
    becomes("dispatcher.asm", "place + 3", "place + 3");
    becomes("courier.asm", "jobs >= 0", "jobs >= 0");
    let (code, out, err) = reconfigure();
    assert_eq!(
        (code, &*out),
        (Some(0), "courier: no changes\n"),
        "neither has changed: {err}"
    );

    becomes("dispatcher.asm", "place + 3", "place + 4");
    becomes("courier.asm", "jobs >= 0", "jobs >= -1");
    let (code, out, err) = reconfigure();
    let expected = "courier: `Courier` runs another version of `courier.asm`\n\
                    courier: `Dispatcher` runs another version of `dispatcher.asm`\n";
    assert_eq!((code, &*out), (Some(0), expected), "{err}");
    drop(running);
}

/// Asks for the double of 4.
const ASKER: &str = "asm asker
import StandardLibrary
import CommonBehavior
signature:
	enum domain Mode = {WAITING | LATE}
	domain Services subsetof Agent
	static sums: Services
	monitored late: Boolean
	controlled mode: Mode
	controlled asked: Boolean
	controlled answer: Integer
	out double: Prod(Services, Integer) -> Integer
definitions:
	main rule r_Main =
		par
			if not asked then asked := true endif
			if not isDef(answer) then r_wcall[sums, \"double\", 4, 600000, answer] endif
			if late then mode := LATE endif
		endpar
default init s0:
	function mode = WAITING
	function asked = false
";

const REPLIER: &str = "asm replier
import StandardLibrary
import CommonBehavior
signature:
	controlled argument: Integer
	out double: Prod(Agent, Integer) -> Integer
definitions:
	main rule r_Main =
		if nextRequest(self) = \"double\" then
			seq
				r_wreceive[undef, \"double\", argument]
				r_wreply[undef, \"double\", argument + argument]
			endseq
		endif
default init s0:
	function argument = 0
";

/// `Silent` has one cycle, before it is asked.
const ASKED: &str = r#"
schema = "composite/1"
[composite]
name = "asked"
[components.Silent]
implementation = { asm = "replier.asm" }
task = { period_ms = 80000000 }
services = { adding = "test/Adds" }
[components.Asker]
implementation = { asm = "asker.asm" }
task = { period_ms = 50, delay_ms = 500 }
references = { sums = "test/Adds" }
bind.monitored.late = { timer = "asked", ms = 80000000 }
[[wires]]
reference = "Asker.sums"
service = "Silent.adding"
timeout_ms = 600000
"#;

#[test]
fn c18_a_timer_is_removed_and_added_while_a_call_is_under_way() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let (user, address) = (broker.user(), broker.address());
    let url = format!("amqp://{user}@{address}/{}", vhost.name());
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in [("asker.asm", ASKER), ("replier.asm", REPLIER)] {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let composite = folder.path().join("asked.composite.toml");
    let path = composite.to_str().unwrap();
    std::fs::write(&composite, ASKED).unwrap();
    let running = Running::start(&mut through(run_any(&composite), &broker, &vhost, None));
    crate::processes::queues(&vhost, "robots.services.asked.control.asked");
    // waits until the asker shows a text
    let shows = |expected: &str| {
        let until = std::time::Instant::now() + std::time::Duration::from_secs(60);
        loop {
            let (_, out, err) = tool(&broker, &url, &["component", "info", "Asker"]);
            if out.contains(expected) {
                return;
            }
            assert!(std::time::Instant::now() < until, "{expected}: {out}{err}");
        }
    };
    shows("sums.double");
    // the types of this operation have no names
    let (_, out, err) = tool(&broker, &url, &["component", "info", "Silent"]);
    let operation = "  operation   Silent.adding.double\n";
    assert!(out.contains(operation), "{out}{err}");

    let removed = ASKED.replace("{ timer = \"asked\", ms = 80000000 }", "{ value = false }");
    std::fs::write(&composite, &removed).unwrap();
    let expected = "asked: `Asker` runs `asker.asm` with other bindings\n\
                    asked: the timer of `late` ends: its binding differs\n";
    for arguments in [
        ["reconfigure", path, "--try"].as_slice(),
        &["reconfigure", path],
    ] {
        let (code, out, err) = tool(&broker, &url, arguments);
        assert_eq!((code, &*out), (Some(0), expected), "{err}");
    }
    shows("mode = WAITING");

    // a timer that is added begins, and ends; the call is under way all the time
    let timed = removed.replace("{ value = false }", "{ timer = \"asked\", ms = 1 }");
    std::fs::write(&composite, timed).unwrap();
    let (code, out, err) = tool(&broker, &url, &["reconfigure", path]);
    assert_eq!(code, Some(0), "{out}{err}");
    shows("mode = LATE");
    shows("sums.double");
    // another length does not end it
    std::fs::write(&composite, ASKED).unwrap();
    let (code, out, err) = tool(&broker, &url, &["reconfigure", path]);
    assert_eq!(code, Some(0), "{err}");
    assert!(!out.contains("timer"), "{out}");
    drop(running);
}

/// A component that one profile has.
const IN_FIELD: &str = r#"
[components.Second]
implementation = { asm = "replier.asm" }
profile = "field"
task = { period_ms = 80000000 }
services = { adding = "test/Adds" }
"#;

#[test]
fn c18_a_version_without_the_running_profile_is_refused_with_its_name_and_the_way_out() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let (user, address) = (broker.user(), broker.address());
    let url = format!("amqp://{user}@{address}/{}", vhost.name());
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in [("asker.asm", ASKER), ("replier.asm", REPLIER)] {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let composite = folder.path().join("asked.composite.toml");
    let path = composite.to_str().unwrap();
    let in_field = format!("{ASKED}{IN_FIELD}");
    let in_lab = in_field.replace("\"field\"", "\"lab\"");
    let running = |text: &str, arguments: &[&str]| {
        std::fs::write(&composite, text).unwrap();
        let mut command = through(run_any(&composite), &broker, &vhost, None);
        let running = Running::start(command.args(arguments));
        crate::processes::queues(&vhost, "robots.services.asked.control.asked");
        running
    };
    let refused = |text: &str, reason: &str| {
        std::fs::write(&composite, text).unwrap();
        let (code, _, err) = tool(&broker, &url, &["reconfigure", path]);
        assert_eq!(code, Some(1), "{err}");
        assert!(err.contains(reason), "{reason}: {err}");
        assert!(err.contains("runs unchanged"), "{err}");
    };

    let with_profile = running(&in_field, &["--profile", "field"]);
    refused(
        ASKED,
        "BAD_COMPOSITE: this process runs profile `field`, which `asked.composite.toml` does not have (it has \
         none): keep an element with `profile = \"field\"`, or restart the process without `--profile`",
    );
    refused(
        &in_lab,
        "does not have (it has `lab`): keep an element with `profile = \"field\"`, or restart the process with \
         another one",
    );
    drop(with_profile.interrupt());

    let without = running(ASKED, &[]);
    refused(
        &in_field,
        "this process runs without a profile, but `asked.composite.toml` has the profiles `field`: remove \
         `profile` from its elements, or restart the process with one of them (`--profile`)",
    );
    drop(without);
}
