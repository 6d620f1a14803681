//! Cost of components in programs, next to components of the same executable and to plain echo processes.
//!
//! `cargo bench -p asmotion-program --bench programs` prints two tables: round trips of a sample of 56 bytes, all in one run and
//! in turns, and fifty components at 200 Hz with a program each. With names after `--` (`round-trips`, `load-rust`,
//! `load-python`) it prints only those. The programs are this executable itself, which shows the cost of
//! the engine and the protocol, and one in Python with the package `asmotion`. ZeroMQ is left out, with a note, where its library
//! is missing.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "a bench fails by panicking and prints its figures"
)]

#[path = "programs/echo.rs"]
mod echo;
#[path = "programs/load.rs"]
mod load;
#[path = "programs/plain.rs"]
mod plain;
#[path = "programs/round_trip.rs"]
mod round_trip;

use std::path::Path;
use std::time::Duration;

use asmotion_program::ProgramCommand;
use plain::{EchoProcess, echo_socket};
use round_trip::{Kind, LiveTrips, VirtualTrips};

/// Many short rounds, so that other load on the machine affects all measurements.
const ROUNDS: usize = 40;

/// Round trips in a round.
const TRIPS: usize = 250;

/// A way to send a sample and to receive it again.
trait Trips {
    /// The duration of each of `count` round trips.
    fn measure(&mut self, count: usize) -> Vec<Duration>;
}

fn main() {
    let words: Vec<String> = std::env::args().collect();
    match words.get(1).map(String::as_str) {
        Some("echo-program") => echo::serve(),
        Some("echo-socket") => echo_socket(&words[2]),
        _ => tables(&words[1..]),
    }
}

/// Prints the tables of these names, or all.
fn tables(words: &[String]) {
    let names: Vec<&String> = words.iter().filter(|it| !it.starts_with('-')).collect();
    let is_chosen = |name| names.is_empty() || names.iter().any(|it| *it == name);
    if is_chosen("round-trips") {
        round_trips();
    }
    if is_chosen("load-rust") {
        load::table("Rust", &this_program());
    }
    if is_chosen("load-python") {
        load::table("Python", &python_program());
    }
}

/// This executable as a program.
fn this_program() -> ProgramCommand {
    let executable = std::env::current_exe().unwrap();
    let executable = executable.to_str().unwrap().to_owned();
    program(vec![executable, "echo-program".to_owned()])
}

fn python_program() -> ProgramCommand {
    let package = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../python");
    let package = format!("PYTHONPATH={}", package.display());
    let words = ["env", &package, "python3", "echo.py"];
    program(words.map(str::to_owned).to_vec())
}

fn program(words: Vec<String>) -> ProgramCommand {
    ProgramCommand {
        words,
        directory: Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/programs"),
        start_timeout: Duration::from_secs(60),
        timeout: Duration::from_secs(10),
    }
}

fn round_trips() {
    let mut rows: Vec<(&str, Box<dyn Trips>)> = vec![
        (
            "component of the executable",
            Box::new(LiveTrips::new(Kind::Component)),
        ),
        (
            "program in Rust",
            Box::new(LiveTrips::new(Kind::Program(this_program()))),
        ),
        (
            "program in Python",
            Box::new(LiveTrips::new(Kind::Program(python_program()))),
        ),
        (
            "program in Rust, virtual time",
            Box::new(VirtualTrips::new(&this_program())),
        ),
        (
            "program in Python, virtual time",
            Box::new(VirtualTrips::new(&python_program())),
        ),
        ("plain socket, Rust", Box::new(EchoProcess::socket())),
    ];
    for (name, process) in [
        ("ZeroMQ, C", EchoProcess::zeromq_c()),
        ("ZeroMQ, Python", EchoProcess::zeromq_python()),
    ] {
        match process {
            Ok(process) => rows.push((name, Box::new(process))),
            Err(reason) => println!("{name}: left out, {reason}"),
        }
    }
    let mut times = vec![Vec::new(); rows.len()];
    for _ in 0..ROUNDS {
        for ((_, trips), times) in rows.iter_mut().zip(&mut times) {
            trips.measure(TRIPS / 10);
            times.extend(trips.measure(TRIPS));
        }
    }
    println!("\n| round trip | p50, µs | p99, µs |\n|---|---|---|");
    for ((name, _), times) in rows.iter().zip(&mut times) {
        times.sort();
        let at = |part: f64| times[(times.len() as f64 * part) as usize].as_secs_f64() * 1e6;
        println!("| {name} | {:.1} | {:.1} |", at(0.5), at(0.99));
    }
}
