//! The driver and its proxy.

use super::bench::{Bench, Log, TIMEOUT};
use asmotion_component::{Time, Transition};
use asmotion_datum::Datum;
use asmotion_messages::JointCommand;
use asmotion_runtime::{Event, Run};
use std::time::Duration;

const POSTURE: &str = "1 move 0.5 0.2 -0.3 0.4 0.1";

fn ms(time: Time) -> u128 {
    time.since(Time::ZERO).as_millis()
}

#[test]
fn j1_an_invocation_in_cycle_k_is_consumed_in_cycle_k_plus_1() {
    for script in [
        &["1.03 move 1 1 1 1 1"][..],
        &["1.07 move 1 1 1 1 1"],
        &[POSTURE],
    ] {
        let script: &'static [&'static str] = Box::leak(script.to_vec().into_boxed_slice());
        let log = Bench {
            script,
            ..Bench::default()
        }
        .run(3);
        assert_eq!(log.turned_in[0], log.called_in[0] + 1, "{script:?}");
    }
}

#[test]
fn j2_each_new_sample_triggers_once() {
    let log = Bench::default().run(5);
    let refreshes = log.notices.iter().filter(|(_, event)| event == "refresh");
    let count = refreshes.count();
    assert!(
        log.statuses.len() - count <= 1,
        "{count} of {}",
        log.statuses.len()
    );
    assert!(log.statuses.len() > 45);
}

#[test]
fn j3_one_proxy_is_called_synchronously_over_one_wire_and_one_way_over_another() {
    let reply = |wire| {
        let log = Bench {
            wire,
            script: &[POSTURE],
            ..Bench::default()
        }
        .run(3);
        assert_eq!(log.events(), ["busy", "idle"]);
        log.replies.len()
    };
    assert_eq!((reply(TIMEOUT), reply(", oneway = true")), (1, 0));
}

/// Time in ms and result of the reply to the first command, with this mode in the map.
fn replied(mode: &str, script: &'static [&'static str]) -> (u128, Result<Datum, String>) {
    let oneway = "youBotDriver.commands\", mode = \"oneway\"";
    let driver = Bench::default().driver;
    let driver = driver.replace(oneway, &oneway.replace("oneway", mode));
    let log = Bench {
        driver,
        script,
        ..Bench::default()
    }
    .run(6);
    let (operation, at, result) = log.replies[0].clone();
    assert_eq!(operation, "setJointsPositions");
    (ms(at), result)
}

#[test]
fn j1_a_caller_waits_for_written_for_taken_or_for_done() {
    let script: &[&str] = &["1.03 move 1 0 0 0 0"];
    let (written, _) = replied("oneway", script);
    let (taken, _) = replied("taken", script);
    let (done, result) = replied("done", script);
    assert!((1030..1100).contains(&written), "{written}");
    assert!(
        (1100..1200).contains(&taken),
        "the driver cycles at 1.1 s: {taken}"
    );
    assert!((2100..2600).contains(&done), "1 rad takes 1 s: {done}");
    assert!(result.is_ok());
}

#[test]
fn j1_whom_another_command_overtakes_hears_of_it() {
    let (at, result) = replied("done", &["1 move 1 0 0 0 0", "1.5 move 0 1 0 0 0"]);
    assert!((1500..1550).contains(&at), "{at}");
    assert!(result.unwrap_err().starts_with("SUPERSEDED"));
}

#[test]
fn j17_the_proxy_learns_from_an_arm_of_six_joints_how_many_there_are() {
    let six = &[
        "1 move 0.1 0.1 0.1 0.1 0.1 0.1",
        "2 move 0.1 0.1 0.1 0.1 0.1",
        "3 read",
    ];
    let arm = |properties| {
        Bench {
            properties,
            script: six,
            ..Bench::default()
        }
        .run(4)
    };
    let log = arm("joints = 6");
    let read = log.replies[2].2.as_ref().unwrap();
    assert_eq!(read.get("position").unwrap().count(), Some(6));
    assert!(log.replies[0].2.is_ok());
    let refused = log.replies[1].2.as_ref().unwrap_err();
    assert_eq!(
        refused,
        "BAD_ARGUMENT: `position`: expected a list of 6, found one of 5"
    );
    let log = arm("joints = 5");
    assert!(log.replies[0].2.is_err() && log.replies[1].2.is_ok());
}

#[test]
fn j15_operations_of_a_proxy_show_the_types_of_their_interface() {
    let (simulation, _) = Bench::default().simulate();
    let declared = simulation.declaration("Driver/SCAyouBotDriver").unwrap();
    let operations = declared.services.iter().flat_map(|it| &it.operations);
    let typed = operations.map(|it| format!("{}: {} -> {}", it.name, it.request, it.response));
    let expected = [
        "setJointsPositions: youbot/JointPositions -> std_msgs/Empty",
        "getJointsPositions: std_msgs/Empty -> youbot/JointPositions",
        "setPeriod: youbot/Period -> std_msgs/Empty",
    ];
    assert_eq!(typed.collect::<Vec<_>>(), expected);
}

#[test]
fn j22_the_map_is_checked_before_anything_starts() {
    let shipped = Bench::default();
    assert_eq!(shipped.findings(), [""; 0]);
    let mistakes = [
        (
            "sendingCommand.setJointsPositions\"",
            "settingPeriod.setPeriod\"",
            "C124",
        ),
        ("error_flags != 0", "error_flags == true", "C125"),
        (
            "mode = \"oneway\" },\n  { operation = \"retr",
            "mode = \"last\" },\n  { operation = \"retr",
            "C120",
        ),
        ("activity   = { period_ms = 20 }\n", "", "C127"),
    ];
    for (right, wrong, code) in mistakes {
        let driver = shipped.driver.replace(right, wrong);
        assert_ne!(driver, shipped.driver, "{right}");
        let found = Bench {
            driver,
            ..Bench::default()
        }
        .findings();
        assert!(found.contains(&code), "{wrong}: {found:?}");
    }
}

#[test]
fn j10_y5_who_polls_slower_than_twice_as_often_is_warned() {
    let driver = Bench::default().driver;
    let pushed = "type = \"buffer\", size = 32";
    let period = "activity   = { period_ms = 20 }\n";
    let polled = |poll_ms, period_replaced: &str| {
        let policy = format!("delivery = \"poll\", poll_ms = {poll_ms}");
        assert!(driver.contains(pushed) && driver.contains(period));
        let driver = driver.replace(pushed, &policy);
        Bench {
            driver: driver.replace(period, period_replaced),
            ..Bench::default()
        }
        .findings()
    };
    assert_eq!(polled(500, ""), ["C054"]);
    assert_eq!(polled(50, ""), [""; 0]);
    // who has a period reads at it
    assert_eq!(polled(500, period), ["C048"]);
}

#[test]
fn y4_idle_is_told_when_the_motion_has_ended_and_not_when_the_write_returned() {
    let log = Bench {
        script: &["1 move 1 0 0 0 0"],
        ..Bench::default()
    }
    .run(6);
    assert_eq!(log.events(), ["busy", "idle"]);
    let (busy, idle) = (log.first("busy").unwrap(), log.first("idle").unwrap());
    // 1 rad at 1 rad/s, within 0.01 rad for 200 ms
    let motion = idle.since(busy).as_millis();
    assert!((1090..1500).contains(&motion), "{motion} ms");
    let mut statuses = log.statuses.iter();
    let (_, status) = statuses.rfind(|(at, _)| *at <= idle).unwrap();
    assert!((status.position[0] - 1.0).abs() < 0.01);
}

#[test]
fn y4_a_fault_of_the_driver_is_told_and_ends_the_waiting() {
    let (mut simulation, log) = Bench {
        script: &[POSTURE],
        ..Bench::default()
    }
    .simulate();
    simulation.run_for(Duration::from_secs(2));
    let faults = Datum::List(vec![Datum::Int(0), Datum::Int(4)]);
    let faults = [("faults".to_owned(), faults)];
    simulation
        .set_properties("Driver/youBotDriver", &faults)
        .unwrap();
    simulation.run_for(Duration::from_secs(1));
    let log = log.lock().unwrap();
    let at = log.first("fault").unwrap();
    assert!((2000..2150).contains(&ms(at)), "{at}");
}

#[test]
fn y11_a_driver_that_falls_silent_is_told_and_shown_as_stale() {
    // it runs, and says nothing for ten seconds
    let script = &[
        "1.95 period 10",
        "2.5 read",
        "4 read",
        "4.1 move 0.3 0.3 0.3 0.3 0.3",
    ];
    let log = Bench {
        script,
        ..Bench::default()
    }
    .run(5);
    let stale = ms(log.first("stale").unwrap());
    assert!((2900..3150).contains(&stale), "{stale} ms");
    assert_eq!(log.events(), ["stale", "busy"], "once");
    assert!(
        log.replies[1].2.is_ok(),
        "the last value is half a second old"
    );
    let refused = log.replies[2].2.as_ref().unwrap_err();
    assert!(
        refused.starts_with("STALE"),
        "never a frozen good value: {refused}"
    );
    assert!(log.replies[3].2.is_ok(), "it runs");
}

const DRIVER: &str = "Driver/youBotDriver";

/// Stops the driver at 2 s, and starts it at 5 s. Returns the log after 7 s.
fn stopped_for_a_while(driver: String, script: &'static [&'static str], wire: &'static str) -> Log {
    let bench = Bench {
        driver,
        script,
        wire,
        ..Bench::default()
    };
    let (mut simulation, log) = bench.simulate();
    simulation.run_for(Duration::from_secs(2));
    simulation.transition(DRIVER, Transition::Stop).unwrap();
    simulation.run_for(Duration::from_secs(3));
    simulation.transition(DRIVER, Transition::Start).unwrap();
    simulation.run_for(Duration::from_secs(2));
    std::mem::take(&mut log.lock().unwrap())
}

/// The shipped driver, with this mode of its commands.
fn with_mode(mode: &str) -> String {
    let oneway = "youBotDriver.commands\", mode = \"oneway\"";
    let driver = Bench::default().driver;
    assert!(driver.contains(oneway));
    driver.replace(oneway, &oneway.replace("oneway", mode))
}

#[test]
fn a_proxy_refuses_commands_and_readings_of_a_driver_that_is_stopped() {
    let driver = Bench::default().driver;
    // without `notify`, nothing else notices it
    let silent = driver.replace(", stale_ms = 1000", "");
    assert_ne!(silent, driver);
    for driver in [driver, silent] {
        let script = &[
            "2.5 move 0.3 0.3 0.3 0.3 0.3",
            "2.6 period 0.05",
            "2.7 read",
            "4 read",
            "5.5 read",
        ];
        let log = stopped_for_a_while(driver, script, TIMEOUT);
        let (refused, last) = log.replies.split_at(4);
        for (operation, _, result) in refused {
            let expected = format!("STOPPED: `{DRIVER}` is stopped");
            assert_eq!(result, &Err(expected), "{operation}");
        }
        let read = last[0].2.as_ref().unwrap();
        let position: Vec<f64> = read.get("position").unwrap().to().unwrap();
        assert_eq!(position, [0.0; 5], "no old command was carried out");
    }
}

/// The shipped driver as a composite of its own, in which the arm has another name.
const NESTED_ARM: &str = r#"
schema = "composite/1"
promote = [
  { port = "Arm.commands", as = "commands" },
  { port = "Arm.period", as = "period" },
  { port = "Arm.jointStatus", as = "jointStatus" },
]
[composite]
name = "arm"
[components.Arm]
implementation = { rust = "youbot::DummyDriver" }
activity = { period_ms = 20 }
ports.in = { commands = "youbot/JointCommand", period = "std_msgs/Float64" }
ports.out = { jointStatus = "youbot/JointStatus" }
"#;

/// The bench with the arm nested in the driver's composite. The client reads every 0.1 s.
fn nested() -> Bench {
    let mut driver = Bench::default().driver;
    // without `notify`, the proxy learns of a driver that stops only from its state
    let notify = driver.find("notify = {").unwrap();
    driver.truncate(notify);
    let begin = driver.find("[properties]").unwrap();
    let end = driver.find("# the proxy of the paper").unwrap();
    let arm =
        "[components.youBotDriver]\nimplementation = { composite = \"inner.composite.toml\" }\n\n";
    driver.replace_range(begin..end, arm);
    let driver = driver
        .replace(r#"references = { notifying = "youbot/Notifying" }"#, "")
        .replace(
            r#"  { reference = "SCAyouBotDriver.notifying", as = "notifying" },"#,
            "",
        );
    let notified =
        r#"  { reference = "Driver.notifying", service = "Client.notifying", oneway = true },"#;
    let reads = (2..600).map(|tenth| format!("{} read", f64::from(tenth) / 10.0));
    let reads = reads.map(|line| &*Box::leak(line.into_boxed_str()));
    Bench {
        application: Bench::default().application.replace(notified, ""),
        driver: driver.replace("protocol ", "# protocol "),
        inner: Some(NESTED_ARM.to_owned()),
        script: Box::leak(reads.collect()),
        ..Bench::default()
    }
}

/// Runs until a read is answered; returns the error.
fn next_reply(
    run: &mut dyn Run,
    is_wanted: impl Fn(&Result<(), String>) -> bool,
) -> Option<String> {
    let limit = run.now() + Duration::from_secs(20);
    let mut last = None;
    run.run_until_event(limit, &mut |_, event| {
        if let Event::Replied { result, .. } = event {
            let result = result.as_ref().map(|_| ()).map_err(ToString::to_string);
            let found = is_wanted(&result);
            last = Some(result);
            return found;
        }
        false
    });
    last.expect("a reply").err()
}

#[test]
fn a_proxy_of_a_nested_composite_refuses_calls_while_the_component_inside_is_stopped() {
    let arm = "Driver/youBotDriver/Arm";
    let runs: [Box<dyn Run>; 2] = [Box::new(nested().simulate().0), Box::new(nested().live())];
    for mut run in runs {
        let run = &mut *run;
        assert_eq!(next_reply(run, Result::is_ok), None);
        run.transition(arm, Transition::Stop).unwrap();
        let refused = next_reply(run, Result::is_err).unwrap();
        assert_eq!(refused, format!("STOPPED: `{arm}` is stopped"));
        run.transition(arm, Transition::Start).unwrap();
        assert_eq!(next_reply(run, Result::is_ok), None);
    }
}

#[test]
fn a_one_way_command_to_a_driver_that_is_stopped_is_counted_and_reported() {
    let script = &["2.5 move 0.3 0.3 0.3 0.3 0.3"];
    let log = stopped_for_a_while(Bench::default().driver, script, ", oneway = true");
    let expected =
        format!("a one-way command for `commands` is refused: STOPPED: `{DRIVER}` is stopped");
    let proxy = "Driver/SCAyouBotDriver".to_owned();
    assert_eq!(log.told, [(proxy, expected)]);
    let (_, last) = log.statuses.last().unwrap();
    assert_eq!(last.position, [0.0; 5]);
}

#[test]
fn a_driver_that_stops_ends_the_wait_of_callers_and_the_motion() {
    // 3 rad at 1 rad/s, interrupted after 0.5 s
    let script = &["1.5 move 3 0 0 0 0"];
    let log = stopped_for_a_while(with_mode("done"), script, TIMEOUT);
    let (_, at, result) = &log.replies[0];
    let stopped = format!("STOPPED: `{DRIVER}` is stopped");
    assert_eq!(result, &Err(stopped.clone()));
    assert!((2000..2050).contains(&ms(*at)), "{at}");
    assert_eq!(log.faults, [stopped]);
    assert!(!log.events().contains(&"idle"));
    // it stays where it was stopped
    let (_, last) = log.statuses.last().unwrap();
    assert!((last.position[0] - 0.4).abs() < 0.11, "{last:?}");
    // one that has not been read yet is not taken later
    let log = stopped_for_a_while(with_mode("taken"), &["1.99 move 3 0 0 0 0"], TIMEOUT);
    assert!(log.replies[0].2.is_err(), "{:?}", log.replies);
    let (_, last) = log.statuses.last().unwrap();
    assert_eq!(last.position, [0.0; 5]);
}

#[test]
fn a_command_past_the_proxy_to_a_stopped_driver_is_not_carried_out_later() {
    let (mut simulation, log) = Bench::default().simulate();
    simulation.run_for(Duration::from_secs(1));
    simulation.transition(DRIVER, Transition::Stop).unwrap();
    let command = JointCommand {
        position: vec![0.3; 5],
        ..JointCommand::default()
    };
    let now = simulation.now();
    let port = format!("{DRIVER}.commands");
    simulation.inject(now, &port, command).unwrap();
    simulation.run_for(Duration::from_secs(6));
    simulation.transition(DRIVER, Transition::Start).unwrap();
    simulation.run_for(Duration::from_secs(2));
    assert_eq!(simulation.losses(DRIVER).dropped, 1);
    let log = log.lock().unwrap();
    let (_, last) = log.statuses.last().unwrap();
    assert_eq!(last.position, [0.0; 5]);
}

#[test]
fn y6_the_same_seed_gives_the_same_stream_byte_for_byte() {
    let stream = |properties| {
        let driver = Bench::default()
            .driver
            .replace("seed = \"${", "random = true, seed = \"${");
        let log = Bench {
            driver,
            properties,
            ..Bench::default()
        }
        .run(10);
        let statuses = log.statuses.iter().map(|(_, status)| status);
        statuses
            .map(|status| asmotion_datum::cbor::encode(status).unwrap())
            .collect::<Vec<_>>()
    };
    assert_eq!(stream("seed = 3"), stream("seed = 3"));
    assert_ne!(stream("seed = 3"), stream("seed = 4"));
    assert!(stream("seed = 3").len() >= 99);
}

#[test]
fn y7_y8_a_period_set_through_the_service_is_the_drivers_within_five_cycles() {
    let log = Bench {
        script: &["1.01 period 0.05"],
        ..Bench::default()
    }
    .run(4);
    let stamps: Vec<i64> = log
        .statuses
        .iter()
        .map(|(_, it)| it.stamp.as_nanos())
        .collect();
    let after = stamps.partition_point(|stamp| *stamp < 1_010_000_000);
    let measured: Vec<i64> = stamps[after..]
        .windows(2)
        .map(|pair| pair[1] - pair[0])
        .collect();
    let settled = &measured[1..6];
    let mean_ms = settled.iter().sum::<i64>() as f64 / 5e6;
    assert!((mean_ms - 50.0).abs() <= 1.0, "{mean_ms} ms: {measured:?}");
    // an invalid period has no effect
    let log = Bench {
        script: &["1 period -1", "2 period 0"],
        ..Bench::default()
    }
    .run(4);
    assert!((39..=41).contains(&log.statuses.len()));
}

#[test]
fn y12_the_driver_has_few_lines() {
    let driver = include_str!("../../components/youbot/src/driver.rs");
    let lines = driver.lines().map(str::trim);
    let code = lines.filter(|line| !line.is_empty() && !line.starts_with("//"));
    assert!(code.count() <= 80);
}
