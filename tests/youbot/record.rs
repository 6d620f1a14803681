//! The recorded table of the arm's motion.

use std::path::Path;
use std::process::Command;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex};

use asmotion::mission::Mission;
use asmotion_component::Time;
use asmotion_messages::JointStatus;
use asmotion_runtime::Event;

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

#[test]
fn o15_csv_columns_equal_published_values() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.csv");
    let mut run = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    run.current_dir(env!("CARGO_MANIFEST_DIR"));
    run.args(["run", COMPOSITE, "--for", "2", "--quiet", "--record"]);
    run.arg(&file);
    run.args(["--ports", "Driver/*.jointStatus", "--ports", "Nobody.*"]);
    let said = String::from_utf8(run.output().unwrap().stderr).unwrap();
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

fn number_of_nanos(seconds: &str) -> i64 {
    let (whole, rest) = seconds.split_once('.').unwrap();
    whole.parse::<i64>().unwrap() * 1_000_000_000 + rest.parse::<i64>().unwrap()
}
