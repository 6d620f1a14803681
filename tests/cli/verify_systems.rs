//! `asmotion verify` of several specifications, and of their environment.

use super::{file, run};

const COURIER: &str = "specs/courier/courier.asm";
const DISPATCHER: &str = "specs/courier/dispatcher.asm";

#[test]
fn specifications_are_verified_together() {
    let (_folder, trace) = file("run.trace", "");
    let together = [
        "verify",
        "--together",
        COURIER,
        DISPATCHER,
        "--bound",
        "10",
        "--possible",
        "courier.jobs = 1",
    ];
    let (exit, out, err) = run(&[&together[..], &["--json", "--trace", &trace]].concat());
    assert_eq!(exit, 0, "{out}{err}");
    let result: serde_json::Value = serde_json::from_str(&out).unwrap();
    let steps = result["properties"][0]["run"]["steps"].as_array().unwrap();
    let moves = |name: &str| steps.iter().filter(|it| it["machine"] == name).count();
    assert!(moves("courier") > 4 && moves("dispatcher") > 0, "{out}");
    assert!(
        steps
            .iter()
            .any(|it| !it["messages"].as_array().unwrap().is_empty())
    );
    for (specification, name) in [(COURIER, "courier"), (DISPATCHER, "dispatcher")] {
        let own = trace.replace("run.trace", &format!("run.{name}.trace"));
        let (exit, out, err) = run(&["sim", specification, "--replay-inputs", &own, "--quiet"]);
        assert_eq!(exit, 0, "{out}{err}");
    }
    let (exit, out, _) = run(&together);
    assert_eq!(exit, 0);
    assert!(out.contains("courier.mode = ASKING"), "{out}");
    assert!(out.contains("dispatcher: "), "{out}");
    // a property over both, two machines of one name, an option without the other
    let both = "dispatcher.finished <= courier.jobs";
    let bounded = ["--bound", "10", "--property", both];
    let (exit, out, _) =
        run(&[&["verify", "--together", COURIER, DISPATCHER], &bounded[..]].concat());
    assert_eq!(exit, 4);
    assert!(
        out.contains(&format!("unknown   invariant {both}")),
        "{out}"
    );
    let (exit, _, err) = run(&["verify", "--together", COURIER, COURIER]);
    assert_eq!(exit, 2);
    assert!(err.contains("NAME=FILE"), "{err}");
    let (exit, _, _) = run(&["verify", COURIER, "--schedule", "synchronous"]);
    assert_eq!(exit, 2);
}

#[test]
fn an_environment_is_a_mode_a_script_or_a_specification() {
    let ends = "af(mode = SUCCESS or mode = GIVE_UP)";
    let recovery = "specs/recovery/recovery.asm";
    let (exit, _, _) = run(&["verify", recovery, "--property", ends]);
    assert_eq!(exit, 1);
    let service = "specs/recovery/service.asm";
    let (exit, out, err) = run(&[
        "verify",
        recovery,
        "--property",
        ends,
        "--environment",
        service,
    ]);
    assert_eq!((exit, err.as_str()), (0, ""), "{out}");
    let (exit, out, _) = run(&["verify", recovery, "--environment", "hold=2"]);
    assert_eq!(exit, 0);
    assert!(out.contains("assumed at most 2 inputs change"), "{out}");
    for (wrong, hint) in [
        ("hold=many", "neither"),
        ("sometimes", "neither"),
        ("nowhere.asm", "nowhere.asm"),
        ("nowhere.env.toml", "nowhere.env.toml"),
    ] {
        let (exit, _, err) = run(&["verify", recovery, "--environment", wrong]);
        assert_eq!(exit, 2, "{wrong}: {err}");
        assert!(err.contains(hint), "{err}");
    }
    let (exit, _, err) = run(&["verify", recovery, "--environment", "specs/estop/estop.asm"]);
    assert_eq!(exit, 1, "{err}");
    assert!(err.contains("M010"), "{err}");
}

#[test]
fn replies_and_requests_from_outside_can_be_given() {
    let (exit, _, err) = run(&["verify", COURIER]);
    assert_eq!(exit, 1);
    assert!(
        err.contains("M005") && err.contains("--values dispatcher.job="),
        "{err}"
    );
    let given = ["--values", "dispatcher.job=0,2", "--states", "2000"];
    let (exit, out, err) = run(&[&["verify", COURIER][..], &given].concat());
    assert_eq!((exit, err.as_str()), (4, ""), "{out}");
    assert!(out.contains("assumed dispatcher.job in {0, 2}"), "{out}");
    assert!(out.contains("note jobs grows: 0, 1, 2, … takes "), "{out}");
    let given = [
        "--values",
        "job=0",
        "--values",
        "done=1",
        "--possible",
        "finished = 1",
        "--states",
        "200",
    ];
    let (exit, out, err) = run(&[&["verify", DISPATCHER][..], &given].concat());
    assert_eq!((exit, err.as_str()), (0, ""), "{out}");
    let (exit, _, err) = run(&["verify", COURIER, "--values", "driver.job=0"]);
    assert_eq!(exit, 2);
    assert!(err.contains("no such partner"), "{err}");
}

/// A copy of the specifications of the courier in a folder, with this composite.
fn couriers(composite: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for name in ["courier.asm", "dispatcher.asm", "Dispatch.asm"] {
        let text = std::fs::read_to_string(format!("specs/courier/{name}")).unwrap();
        // an input with the name of a function of the other specification
        let text = match name {
            "courier.asm" => text
                .replace(
                    "controlled jobs",
                    "monitored busy: Boolean\n\tcontrolled sawBusy: Boolean\n\tcontrolled jobs",
                )
                .replace(
                    "\t\tswitch mode",
                    "\t\tpar\n\t\tif busy then sawBusy := true endif\n\t\tswitch mode",
                )
                .replace("\t\tendswitch", "\t\tendswitch\n\t\tendpar")
                .replace(
                    "function jobs = 0",
                    "function jobs = 0\n\tfunction sawBusy = false",
                ),
            "dispatcher.asm" => text
                .replace(
                    "controlled finished",
                    "controlled busy: Boolean\n\tcontrolled finished",
                )
                .replace(
                    "finished := finished + 1",
                    "finished := finished + 1\n\t\t\tbusy := false",
                )
                .replace(
                    "function finished = 0",
                    "function finished = 0\n\tfunction busy = false",
                ),
            _ => text,
        };
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    std::fs::write(folder.path().join("town.composite.toml"), composite).unwrap();
    folder
}

const TOWN: &str = "schema = \"composite/1\"
[composite]
name = \"town\"
[components.Courier]
implementation = { asm = \"courier.asm\", main = \"r_Main\" }
task = { period_ms = 50 }
references = { dispatcher = \"courier/Dispatch\" }
[components.Dispatcher]
implementation = { asm = \"dispatcher.asm\", main = \"r_Main\" }
task = { period_ms = 50 }
services = { dispatch = \"courier/Dispatch\" }
[[wires]]
reference = \"Courier.dispatcher\"
service = \"Dispatcher.dispatch\"
";

/// In a composite, an input that no connection leads to has any value, although another specification has a function of its name.
#[test]
fn specifications_of_a_composite_read_only_what_its_connections_bring() {
    let folder = couriers(TOWN);
    let path = |name: &str| folder.path().join(name).display().to_string();
    let ends = ["--bound", "4"];
    let together = [
        "verify",
        "--together",
        &path("courier.asm"),
        &path("dispatcher.asm"),
    ];
    let property = ["--property", "ag(not courier.sawBusy)"];
    let (exit, out, err) = run(&[&together[..], &ends, &property].concat());
    assert_eq!(exit, 4, "{out}{err}");
    assert!(
        out.contains("unknown   CTLSPEC ag(not courier.sawBusy)"),
        "{out}"
    );
    let composite = ["verify", &path("town.composite.toml")];
    let property = ["--property", "ag(not Courier.sawBusy)"];
    let (exit, out, err) = run(&[&composite[..], &ends, &property].concat());
    assert_eq!(exit, 1, "{out}{err}");
    assert!(
        out.contains("violated  CTLSPEC ag(not Courier.sawBusy)"),
        "{out}"
    );
}

/// Of two dispatchers, the wire selects the partner.
#[test]
fn the_partner_of_a_specification_in_a_composite_is_at_the_other_end_of_its_wire() {
    let second = "[components.Depot]
implementation = { asm = \"dispatcher.asm\", main = \"r_Main\" }
task = { period_ms = 50 }
services = { dispatch = \"courier/Dispatch\" }
[[wires]]
";
    let two = TOWN.replace("[[wires]]\n", second);
    for (service, other) in [("Dispatcher", "Depot"), ("Depot", "Dispatcher")] {
        let wired = two.replace(
            "service = \"Dispatcher.dispatch\"",
            &format!("service = \"{service}.dispatch\""),
        );
        let folder = couriers(&wired);
        let path = folder.path().join("town.composite.toml");
        let path = path.display().to_string();
        let asked = format!("{service}.place = 0");
        let (exit, out, err) = run(&["verify", &path, "--bound", "4", "--possible", &asked]);
        assert_eq!(exit, 0, "{out}{err}");
        assert!(
            out.contains(&format!("holds     possible: {asked}")),
            "{out}"
        );
        let asked = format!("{other}.place = 0");
        let (exit, out, err) = run(&["verify", &path, "--bound", "4", "--possible", &asked]);
        assert_ne!(exit, 0, "{out}{err}");
    }
}

/// Specifications of a composite that exchange messages, of which one calls a service of another component: each outcome of the call
/// can occur, and so does no outcome.
#[test]
fn outcomes_of_calls_occur_in_specifications_that_exchange_messages() {
    let town = format!(
        "{}{}",
        TOWN.replace(
            "references = { dispatcher = \"courier/Dispatch\" }\n",
            "references = { dispatcher = \"courier/Dispatch\", maps = \"nav/MapService\" }\n\
             [components.Courier.bind.out.order]\n\
             ASK = { call = \"maps.getMap\", with = { name = \"office\" }, ok = \"FOUND\", failed = \"LOST\", event = \"answer\" }\n\
             [components.Server]\n\
             implementation = { rust = \"nav::MapServer\" }\nactivity = { period_ms = 100 }\n\
             services = { maps = \"nav/MapService\" }\nproperties = { source = \"office=office.yaml\" }\n"
        ),
        "[[wires]]\nreference = \"Courier.maps\"\nservice = \"Server.maps\"\ntimeout_ms = 500\n"
    );
    let folder = couriers(&town);
    let courier = folder.path().join("courier.asm");
    let text = std::fs::read_to_string(&courier).unwrap();
    let text = text
        .replace(
            "\tmonitored busy",
            "\tenum domain Answer = {NOTHING | FOUND | LOST}\n\tenum domain Order = {REST | ASK}\n\
             \tmonitored answer: Answer\n\tout order: Order\n\tcontrolled seen: Answer\n\tmonitored busy",
        )
        .replace(
            "\t\tif busy then",
            "\t\torder := ASK\n\t\tseen := answer\n\t\tif busy then",
        )
        .replace(
            "\tfunction sawBusy",
            "\tfunction order = REST\n\tfunction seen = NOTHING\n\tfunction sawBusy",
        );
    std::fs::write(&courier, text).unwrap();
    let path = folder.path().join("town.composite.toml");
    let path = path.display().to_string();
    let (exit, out, err) = run(&["check", &path]);
    assert_eq!(exit, 0, "{out}{err}");
    for seen in ["FOUND", "LOST"] {
        let possible = format!("Courier.seen = {seen} and Courier.mode = UNDERWAY");
        let (exit, out, err) = run(&["verify", &path, "--bound", "8", "--possible", &possible]);
        assert_eq!(exit, 0, "{out}{err}");
        assert!(
            out.contains(&format!("holds     possible: {possible}")),
            "{out}"
        );
    }
}
