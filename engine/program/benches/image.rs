//! Processor time of images of 1 MB that a program in C++ and the engine exchange at 30 Hz, in both processes together, beyond
//! that of empty images: over the socket alone, and in shared memory.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "a benchmark"
)]

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::{AtomicI64, Ordering};
use std::time::Duration;

use asmotion_component::{Activity, Component, Cycle, Fault, In, Interface, Out, Policy, Time};
use asmotion_datum::{Datum, Schema};
use asmotion_program::{ProgramCommand, ProgramComponent, ask};
use asmotion_runtime::{Event, Run, System};
use rustix::time::{ClockId, clock_gettime};

/// Size of an image in bytes.
const SIZE: usize = 1_000_000;

/// Time between two images: 30 Hz.
const PERIOD: Duration = Duration::from_nanos(33_333_333);

/// Duration of a measurement.
const LENGTH: Duration = Duration::from_secs(10);

/// Rounds of all measurements in turns, of which the table shows the medians.
const ROUNDS: usize = 3;

/// The other end in the engine.
enum ImagePeer {
    Source { to: Out<Datum>, image: Arc<[u8]> },
    Sink { from: In<Datum> },
}

impl Component for ImagePeer {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        match self {
            Self::Source { to, image } => {
                let image = Datum::Bytes(Arc::clone(image));
                cycle.write(*to, Datum::record([("data", image)]));
            }
            Self::Sink { from } => drop(cycle.all(*from)),
        }
        Ok(())
    }
}

/// Compiles the program, with options.
fn compiled(folder: &Path, name: &str, options: &[&str]) -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let program = folder.join(name);
    let mut compiler = Command::new("c++");
    compiler.args(["-std=c++17", "-O2"]).args(options).arg("-I");
    compiler.arg(here.join("../../cpp")).arg("-o").arg(&program);
    compiler.arg(here.join("benches/image.cpp"));
    assert!(compiler.status().unwrap().success(), "{compiler:?}");
    program
}

/// The share of a core, in percent, that both processes use.
fn share(program: &Path, role: &str, size: usize) -> f64 {
    let words = [program.to_str().unwrap(), role, &size.to_string()].map(str::to_owned);
    let command = ProgramCommand {
        words: words.to_vec(),
        directory: PathBuf::from("."),
        start_timeout: Duration::from_secs(10),
        timeout: Duration::from_secs(2),
    };
    let mut system = System::new();
    let declared = ask(&command, "Program").unwrap();
    let declared = declared.complete(&|_| None).unwrap();
    let make = move |interface: &mut Interface| {
        Box::new(ProgramComponent::new(command, declared, interface)) as Box<dyn Component>
    };
    let activity = || Activity::periodic(PERIOD);
    system.add("Program", activity(), make).unwrap();
    let is_camera = role == "camera";
    let image: Arc<[u8]> = vec![7; size].into();
    let peer = move |interface: &mut Interface| {
        let schema = Schema::opaque("acme/Image");
        let peer = if is_camera {
            let from = interface.input_of("image", schema, "");
            ImagePeer::Sink { from }
        } else {
            let to = interface.output_of("image", schema, "");
            ImagePeer::Source { to, image }
        };
        Box::new(peer) as Box<dyn Component>
    };
    system.add("Peer", activity(), peer).unwrap();
    let (from, to) = if is_camera {
        ("Program.image", "Peer.image")
    } else {
        ("Peer.image", "Program.image")
    };
    system.connect(from, to, Policy::data()).unwrap();
    // the processor time that the program has reported, ns
    let reported = Arc::new(AtomicI64::new(0));
    let report = Arc::clone(&reported);
    system.observe(move |_: Time, event: &Event<'_>| {
        if let Event::Report {
            kind: "used", data, ..
        } = event
            && let Some(used) = data.as_int()
        {
            report.store(used, Ordering::Relaxed);
        }
    });
    let mut run = system.live();
    let used = || {
        let own = clock_gettime(ClockId::ProcessCPUTime);
        let own = own.tv_sec as f64 + own.tv_nsec as f64 * 1e-9;
        own + reported.load(Ordering::Relaxed) as f64 * 1e-9
    };
    run.run_for(Duration::from_secs(1));
    let before = used();
    run.run_for(LENGTH);
    100.0 * (used() - before) / LENGTH.as_secs_f64()
}

fn main() {
    let folder = tempfile::tempdir().unwrap();
    let shared = compiled(folder.path(), "shared", &[]);
    let socket = compiled(folder.path(), "socket", &["-DASMOTION_SOCKET_ONLY"]);
    println!("| 1 MB at 30 Hz | idle, % of a core | socket | shared memory |\n|---|---|---|---|");
    for (role, title) in [("camera", "from a program"), ("screen", "to a program")] {
        let mut rounds = [(); 3].map(|()| Vec::new());
        for _ in 0..ROUNDS {
            rounds[0].push(share(&shared, role, 0));
            rounds[1].push(share(&socket, role, SIZE));
            rounds[2].push(share(&shared, role, SIZE));
        }
        let [idle, socket, shared] = rounds.map(|mut all| {
            all.sort_by(f64::total_cmp);
            all[ROUNDS / 2]
        });
        let (socket, shared) = (socket - idle, shared - idle);
        println!("| {title} | {idle:.2} | +{socket:.2} | +{shared:.2} |");
    }
}
