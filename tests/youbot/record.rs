//! The recorded table of the arm's motion.

use std::path::Path;
use std::process::Command;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use asmotion::mission::Mission;
use asmotion_bench::Bench;
use asmotion_component::Time;
use asmotion_datum::Datum;
use asmotion_messages::JointStatus;
use asmotion_runtime::Event;
use asmotion_youbot::DummyDriver;

const COMPOSITE: &str = "specs/youbot/youbot.composite.toml";

/// The status published by the driver in two seconds, with its times.
fn published() -> Vec<(i64, JointStatus)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut mission = Mission::new(root.join(COMPOSITE).display().to_string());
    mission.limit = Some(std::time::Duration::from_secs(2));
    let all = Arc::new(Mutex::new(Vec::new()));
    let listener = Arc::clone(&all);
    let hear = move |at: Time, event: &Event<'_>, _: Option<&str>| {
        if let Event::Published { port, sample, .. } = event
            && *port == "jointStatus"
        {
            let status = sample.to_shared().read::<JointStatus>().unwrap();
            listener.lock().unwrap().push((at.nanos(), status));
        }
    };
    mission
        .run(|_, _| (), hear, &AtomicBool::new(false))
        .unwrap();
    let mut all = all.lock().unwrap();
    std::mem::take(&mut *all)
}

/// Records ports of two seconds of the youBot's motion, and returns what the command says.
fn record(file: &Path, ports: &[&str]) -> String {
    let mut run = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    run.current_dir(env!("CARGO_MANIFEST_DIR"));
    run.args(["run", COMPOSITE, "--for", "2", "--quiet", "--record"]);
    run.arg(file);
    for port in ports {
        run.args(["--ports", port]);
    }
    String::from_utf8(run.output().unwrap().stderr).unwrap()
}

#[test]
fn o15_csv_columns_equal_published_values() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.csv");
    let said = record(&file, &["Driver/*.jointStatus", "Nobody.*"]);
    assert!(said.contains("`Nobody.*`: no port of this name"), "{said}");
    let mut table = csv::Reader::from_path(&file).unwrap();
    let names: Vec<String> = table.headers().unwrap().iter().map(str::to_owned).collect();
    assert_eq!(names[0], "time_s");
    let column = |field: &str| {
        let name = format!("Driver/youBotDriver.jointStatus.{field}");
        let place = names.iter().position(|known| *known == name);
        place.unwrap_or_else(|| panic!("no {name} in {names:?}"))
    };
    let published = published();
    let mut rows = 0;
    for (row, (at, status)) in table.records().zip(&published) {
        let row = row.unwrap();
        let number = |field: &str| row[column(field)].parse::<f64>().unwrap();
        assert_eq!(
            (number_of_nanos(&row[0]), number("stamp.nanosec")),
            (*at, f64::from(status.stamp.nanosec))
        );
        for joint in 0..5 {
            let of = |field: &str| number(&format!("{field}.{joint}"));
            assert_eq!(of("position"), status.position[joint]);
            assert_eq!(of("velocity"), status.velocity[joint]);
            assert_eq!(of("current"), status.current[joint]);
            assert_eq!(of("temperature"), status.temperature[joint]);
            assert_eq!(of("error_flags"), f64::from(status.error_flags[joint]));
        }
        rows += 1;
    }
    assert_eq!(rows, published.len());
    assert!(rows > 15, "{rows}");
    // only the requested columns: the time, a stamp of two numbers, five lists of five
    assert_eq!(names.len(), 1 + 2 + 5 * 5);
}

#[test]
fn o15_on_the_bench_the_driver_does_with_recorded_commands_what_it_did_in_the_run() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.csv");
    record(&file, &[]);
    let mut bench = Bench::new(DummyDriver::new);
    bench
        .period(Duration::from_millis(100))
        .set("joints", Datum::Int(5))
        .set("seed", Datum::Int(42))
        .give_recorded("commands", &file, "Driver/SCAyouBotDriver.commands");
    let cycles = bench.run_for(Duration::from_secs(2)).unwrap();
    let status = cycles
        .iter()
        .flat_map(|it| it.outputs::<JointStatus>("jointStatus"));
    let status: Vec<JointStatus> = status.collect();
    let expected: Vec<JointStatus> = published().into_iter().map(|(_, status)| status).collect();
    assert_eq!(status, expected[..status.len()]);
    let moved = |joint: usize| status[0].position[joint] != status[19].position[joint];
    assert!((0..5).all(moved), "the arm has moved: {status:?}");
}

fn number_of_nanos(seconds: &str) -> i64 {
    let (whole, rest) = seconds.split_once('.').unwrap();
    whole.parse::<i64>().unwrap() * 1_000_000_000 + rest.parse::<i64>().unwrap()
}
