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
