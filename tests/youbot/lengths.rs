//! Commands for another number of joints: nothing accepts one and does nothing.

use super::bench::{Bench, Log};
use asmotion_component::Transition;
use asmotion_datum::Datum;
use asmotion_messages::JointCommand;
use asmotion_runtime::{Run, Simulation};
use std::sync::{Arc, Mutex};
use std::time::Duration;

const DRIVER: &str = "Driver/youBotDriver";
const PROXY: &str = "Driver/SCAyouBotDriver";

/// The condition that says when a motion has ended.
const IDLE: &str = " idle = { within = 0.01, of = \"commands.position\", on = \"jointStatus.position\", for_ms = 200 },";

/// The shipped driver, without `idle` in `notify`.
fn without_idle() -> String {
    let driver = Bench::default().driver;
    assert!(driver.contains(IDLE));
    driver.replace(IDLE, "")
}

/// The shipped driver, without any events.
fn without_notify() -> String {
    let driver = without_idle();
    let begin = driver.find("notify = {").unwrap();
    driver[..begin].to_owned()
}

/// The results of the commands.
fn moves(log: &Log) -> Vec<Result<(), String>> {
    let moves = log.replies.iter();
    let moves = moves.filter(|(operation, _, _)| operation == "setJointsPositions");
    moves
        .map(|(_, _, result)| result.clone().map(|_| ()))
        .collect()
}

fn told_by(log: &Log, component: &str) -> Vec<String> {
    let told = log.told.iter().filter(|(by, _)| by == component);
    told.map(|(_, text)| text.clone()).collect()
}

const REFUSED: &str = "BAD_ARGUMENT: `position`: expected a list of 6, found one of 5";

#[test]
fn a_command_of_another_length_is_refused_with_and_without_idle() {
    for driver in [Bench::default().driver, without_idle()] {
        let log = Bench {
            driver,
            properties: "joints = 6",
            script: &["1 move 1 1 1 1 1", "2 move 1 1 1 1 1 1", "3 move"],
            ..Bench::default()
        }
        .run(4);
        let none = REFUSED.replace("of 5", "of 0");
        let expected = [Err(REFUSED.to_owned()), Ok(()), Err(none)];
        assert_eq!(moves(&log), expected);
        assert_eq!(log.events().iter().filter(|it| **it == "busy").count(), 1);
        // the callers know; neither the driver nor the log is bothered
        assert_eq!(log.told, []);
    }
}

#[test]
fn a_proxy_without_events_refuses_it_too() {
    let mut bench = Bench {
        driver: without_notify(),
        properties: "joints = 6",
        script: &["1 move 1 1 1 1 1"],
        ..Bench::default()
    };
    let wire =
        "  { reference = \"Driver.notifying\", service = \"Client.notifying\", oneway = true },\n";
    assert!(bench.application.contains(wire));
    bench.application = bench.application.replace(wire, "");
    for line in [
        "references = { notifying = \"youbot/Notifying\" }\n",
        "  { reference = \"SCAyouBotDriver.notifying\", as = \"notifying\" },\n",
        "protocol   = \"driver_protocol.asm\"     # what others can rely on, for `asmotion verify`\n",
    ] {
        assert!(bench.driver.contains(line), "{line}");
        bench.driver = bench.driver.replace(line, "");
    }
    assert_eq!(moves(&bench.run(2)), [Err(REFUSED.to_owned())]);
}

#[test]
fn before_the_first_sample_the_driver_and_the_proxy_report_it_afterwards() {
    let late = "activity   = { period_ms = \"${properties.period_ms}\" }";
    for driver in [Bench::default().driver, without_idle()] {
        assert!(driver.contains(late));
        let delayed = late.replace(" }", ", delay_ms = 500 }");
        let log = Bench {
            driver: driver.replace(late, &delayed),
            properties: "joints = 6",
            script: &["0.1 move 1 1 1 1 1"],
            ..Bench::default()
        }
        .run(2);
        // nobody could know: it was sent
        assert_eq!(moves(&log), [Ok(())]);
        let refused = "`commands` refuses a message: 5 positions for 6 joints";
        assert_eq!(told_by(&log, DRIVER), [refused]);
        let unfit = "the target cannot carry out the last command for `commands`: \
                     `position`: expected a list of 6, found one of 5";
        assert_eq!(told_by(&log, PROXY), [unfit]);
        assert_eq!(log.faults, [unfit]);
    }
}

#[test]
fn a_caller_that_waits_for_the_end_of_a_motion_learns_that_there_is_none() {
    let late = "activity   = { period_ms = \"${properties.period_ms}\" }";
    let driver = Bench::default().driver;
    let driver = driver.replace(late, &late.replace(" }", ", delay_ms = 500 }"));
    let driver = driver.replace(
        "youBotDriver.commands\", mode = \"oneway\"",
        "youBotDriver.commands\", mode = \"done\"",
    );
    let log = Bench {
        driver,
        properties: "joints = 6",
        script: &["0.1 move 1 1 1 1 1"],
        ..Bench::default()
    }
    .run(2);
    assert_eq!(moves(&log), [Err(REFUSED.to_owned())]);
}

#[test]
fn a_one_way_command_that_is_refused_is_counted_and_reported_once() {
    let bench = Bench {
        driver: without_idle(),
        properties: "joints = 6",
        wire: ", oneway = true",
        script: &["1 move 1 1 1 1 1", "2 move 1 1 1 1 1", "3 move 1 1"],
        ..Bench::default()
    };
    let (mut simulation, log) = bench.simulate();
    simulation.run_for(Duration::from_secs(4));
    assert_eq!(simulation.losses(PROXY).misfits, 3);
    let expected = [5, 2].map(|count| {
        format!(
            "a one-way command for `commands` is refused: BAD_ARGUMENT: `position`: expected a list of 6, found one \
             of {count}"
        )
    });
    assert_eq!(told_by(&log.lock().unwrap(), PROXY), expected);
}

/// Restarts the driver with another number of joints.
fn restart(simulation: &mut Simulation, joints: u32) {
    for transition in [Transition::Stop, Transition::Cleanup] {
        simulation.transition(DRIVER, transition).unwrap();
    }
    let joints = [("joints".to_owned(), Datum::Int(i64::from(joints)))];
    simulation.set_properties(DRIVER, &joints).unwrap();
    for transition in [Transition::Configure, Transition::Start] {
        simulation.transition(DRIVER, transition).unwrap();
    }
}

#[test]
fn a_driver_that_returns_with_other_joints_is_learnt_again() {
    for driver in [Bench::default().driver, without_idle()] {
        let bench = Bench {
            driver,
            properties: "joints = 6",
            script: &[
                "1 move 1 1 1 1 1 1",
                "1.6 move 2 2 2 2 2",
                "2 move 0 0 0 0 0 0",
            ],
            ..Bench::default()
        };
        let (mut simulation, log) = bench.simulate();
        simulation.run_for(Duration::from_millis(1300));
        restart(&mut simulation, 5);
        simulation.run_for(Duration::from_millis(1700));
        let log = log.lock().unwrap();
        let refused = "BAD_ARGUMENT: `position`: expected a list of 5, found one of 6";
        assert_eq!(moves(&log), [Ok(()), Ok(()), Err(refused.to_owned())]);
        // the motion with six joints was under way
        let unfit = "the target cannot carry out the last command for `commands`: \
                     `position`: expected a list of 5, found one of 6";
        assert_eq!(told_by(&log, PROXY), [unfit]);
        assert_eq!(log.faults, [unfit]);
    }
}

/// Writes a command to the driver's input, as a wire, a tool or a specification does.
fn write(simulation: &mut Simulation, joints: usize) {
    let command = JointCommand {
        position: vec![0.5; joints],
        ..JointCommand::default()
    };
    let port = format!("{DRIVER}.commands");
    let now = simulation.now();
    simulation.inject(now, &port, command).unwrap();
    simulation.run_for(Duration::from_millis(300));
}

#[test]
fn without_a_proxy_the_driver_counts_and_reports_it() {
    let (mut simulation, log) = Bench::default().simulate();
    simulation.run_for(Duration::from_millis(500));
    for joints in [6, 6, 5, 6, 0] {
        write(&mut simulation, joints);
    }
    assert_eq!(simulation.losses(DRIVER).misfits, 4);
    let log = log.lock().unwrap();
    let expected =
        [6, 0].map(|count| format!("`commands` refuses a message: {count} positions for 5 joints"));
    assert_eq!(told_by(&log, DRIVER), expected);
    let (_, last) = log.statuses.last().unwrap();
    assert_eq!(last.position, [0.5; 5]);
}

#[test]
fn a_period_that_the_driver_does_not_take_is_reported() {
    let log = Bench {
        script: &["1 period 20"],
        ..Bench::default()
    }
    .run(2);
    let refused = "`period` refuses a message: 20 s is not 0.001 to 10 s";
    assert_eq!(told_by(&log, DRIVER), [refused]);
}

/// The new notices of both components, and the results of the commands, in a second run of one second.
fn second(mut simulation: Simulation, log: &Arc<Mutex<Log>>) -> String {
    *log.lock().unwrap() = Log::default();
    simulation.run_for(Duration::from_secs(1));
    write(&mut simulation, 4);
    let log = log.lock().unwrap();
    format!("{:?} {:?}", moves(&log), log.told)
}

#[test]
fn what_was_learnt_and_reported_is_frozen() {
    let bench = || Bench {
        driver: without_idle(),
        properties: "joints = 6",
        script: &["1.5 move 1 1 1 1 1"],
        ..Bench::default()
    };
    let (mut simulation, log) = bench().simulate();
    simulation.run_for(Duration::from_millis(600));
    write(&mut simulation, 4);
    let frozen = simulation.freeze().unwrap();
    let (mut other, heard) = bench().simulate();
    other.thaw(&frozen).unwrap();
    let expected = format!("[Err({REFUSED:?})] []");
    assert_eq!(second(simulation, &log), expected);
    assert_eq!(second(other, &heard), expected);
}

#[test]
fn a_proxy_finds_the_lists_of_equal_length_and_expand_shows_them() {
    let derived =
        "lengths = [\n  { of = \"commands.position\", on = \"jointStatus.position\" },\n]";
    let expanded = |driver: String| {
        let bench = Bench {
            driver,
            ..Bench::default()
        };
        assert_eq!(bench.findings(), [""; 0]);
        bench.expanded()
    };
    let found = expanded(without_idle());
    assert!(found.contains(derived), "{found}");
    // `idle` says it already
    assert!(!expanded(Bench::default().driver).contains("lengths"));
}

/// The driver without `idle`, with these lengths.
fn with_lengths(lengths: &str) -> Bench {
    let driver = without_idle();
    let notify = driver.find("notify = {").unwrap();
    Bench {
        driver: format!(
            "{}lengths = [{lengths}]\n{}",
            &driver[..notify],
            &driver[notify..]
        ),
        properties: "joints = 6",
        script: &["1 move 1 1 1 1 1"],
        ..Bench::default()
    }
}

#[test]
fn lengths_can_be_named_or_left_free() {
    let named = with_lengths("{ of = \"commands.position\", on = \"jointStatus.velocity\" }");
    assert_eq!(moves(&named.run(2)), [Err(REFUSED.to_owned())]);
    let free = with_lengths("{ of = \"commands.position\" }");
    let log = free.run(2);
    assert_eq!(moves(&log), [Ok(())]);
    let refused = "`commands` refuses a message: 5 positions for 6 joints";
    assert_eq!(told_by(&log, DRIVER), [refused]);
}

#[test]
fn lengths_are_checked() {
    for (lengths, code) in [
        (
            "{ of = \"commands.position\", on = \"jointStatus.stamp\" }",
            "C125",
        ),
        (
            "{ of = \"commands.stamp\", on = \"jointStatus.position\" }",
            "C125",
        ),
        (
            "{ of = \"commands.place\", on = \"jointStatus.position\" }",
            "C115",
        ),
        (
            "{ of = \"orders.position\", on = \"jointStatus.position\" }",
            "C020",
        ),
    ] {
        let found = with_lengths(lengths).findings();
        assert!(found.contains(&code), "{lengths}: {found:?}");
    }
}

#[test]
fn a_state_that_only_lengths_names_is_mirrored_and_connected() {
    let reading = "  { operation = \"retrievingStatus.getJointsPositions\", port = \"youBotDriver.jointStatus\", mode = \"last\" },\n";
    let mut bench = with_lengths("{ of = \"commands.position\", on = \"jointStatus.position\" }");
    bench.driver = without_events(&bench.driver)
        .replace(reading, "")
        .replace(", retrievingStatus = \"youbot/RetrievingStatus\"", "")
        .replace(
            "  { service = \"SCAyouBotDriver.retrievingStatus\", as = \"retrievingStatus\" },\n",
            "",
        )
        .replace(
            "  { from = \"youBotDriver.jointStatus\", to = \"SCAyouBotDriver.jointStatus\", policy = { type = \"buffer\", size = 32 } },\n",
            "",
        );
    assert!(!bench.driver.contains("SCAyouBotDriver.jointStatus"));
    bench.application = bench
        .application
        .replace(
            "  { reference = \"Client.status\", service = \"Driver.retrievingStatus\", timeout_ms = 1000 },\n",
            "",
        )
        .replace(", status = \"youbot/RetrievingStatus\"", "");
    assert_eq!(bench.findings(), [""; 0]);
    assert_eq!(moves(&bench.run(2)), [Err(REFUSED.to_owned())]);
}

/// The driver with no event but `busy`.
fn without_events(driver: &str) -> String {
    let begin = driver.find(", refresh = ").unwrap();
    format!("{} }}\n", driver[..begin].trim_end_matches(','))
}
