//! C18: a running composite changes to its next version without a restart, or does not change at all.

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
        err.contains("planning: NEEDS_START: `TrajectoryPlanner` differs in more"),
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
