//! Steps per second of a coordinator in simulated time with and without monitors, in turn in one process; prints the ratios.
//!
//! *idle*: nothing that a property reads changes. *busy*: inputs and locations of every property change in every step.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a benchmark")]

use std::sync::Arc;
use std::time::Instant;

use asmotion_component::{Activity, Policy, Span};
use asmotion_coordinator::{Binding, Coordinator, Interfaces, Monitored, Source, Watch};
use asmotion_datum::{Datum, Schema};
use asmotion_lang::MemoryFiles;
use asmotion_runtime::{Run, Simulation, System};

const ROUNDS: usize = 41;
const STEPS: u64 = 2_000;

/// The properties are those of the navigation, and a response; the main rule drives and stops.
const ROVER: &str = "
asm rover
import StandardLibrary
import CTLLibrary
import LTLLibrary
signature:
	enum domain Mode = {IDLE | WAITING | FOLLOWING}
	monitored estop: Boolean
	monitored contact: Boolean
	controlled mode: Mode
	controlled moving: Boolean
	controlled rounds: Integer
definitions:
	CTLSPEC ag(estop implies ax(not moving))
	CTLSPEC ag((mode = FOLLOWING and contact) implies ax(not moving))
	CTLSPEC ag(moving iff mode = FOLLOWING)
	CTLSPEC aw(not moving, mode = WAITING)
	LTLSPEC g(moving implies o(mode = WAITING))
	//@Within 10 s
	CTLSPEC ag(mode = WAITING implies af(mode != WAITING))
	rule r_stop = par mode := IDLE moving := false endpar
	main rule r_Main =
		par
			rounds := rounds + 1
			if estop or contact then
				par mode := IDLE moving := false endpar
			else
				switch mode
					case IDLE: mode := WAITING
					case WAITING: par mode := FOLLOWING moving := true endpar
					case FOLLOWING: par mode := WAITING moving := false endpar
				endswitch
			endif
		endpar
default init s0:
	function mode = IDLE
	function moving = false
	function rounds = 0
";

fn rover(watch: &Watch, text: &str) -> Simulation {
    let mut files = MemoryFiles::new();
    files.add("rover.asm", text);
    let specification = asmotion_lang::open("rover.asm", &files).unwrap();
    let port = |name: &str| Monitored {
        field: Some("data".to_owned()),
        none: Some(Datum::Bool(false).into()),
        ..Monitored::new(name, Source::Port(name.to_owned()))
    };
    let binding = Binding {
        monitored: vec![port("estop"), port("contact")],
        out: Vec::new(),
    };
    let inputs = ["estop", "contact"].map(|it| (it.to_owned(), Schema::opaque("test/Bool")));
    let interfaces = Interfaces {
        inputs: inputs.to_vec(),
        ..Interfaces::default()
    };
    let mut system = System::new();
    let made = system.add("Rover", Activity::periodic(1.ms()), |interface| {
        let made = Coordinator::watching(specification, &binding, watch, &interfaces, 1, interface);
        Box::new(made.unwrap())
    });
    made.unwrap();
    for name in ["estop", "contact"] {
        let port = format!("Rover.{name}");
        system.subscribe(name, &port, Policy::data()).unwrap();
    }
    system.simulate()
}

/// Seconds that a number of steps takes. If busy, each step has another input.
fn time(run: &mut Simulation, is_busy: bool) -> f64 {
    let begin = Instant::now();
    for step in 0..STEPS {
        if is_busy {
            let topic = ["estop", "contact"][(step / 2 % 2) as usize];
            let sample = Arc::new(Datum::record([("data", Datum::Bool(step % 2 == 0))]));
            let now = run.now();
            run.publish_sample(now, topic, sample).unwrap();
        }
        run.run_for(1.ms());
    }
    begin.elapsed().as_secs_f64()
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn main() {
    let off = Watch {
        is_off: true,
        ..Watch::default()
    };
    let safe = Watch {
        safe_rule: Some("r_stop[]".to_owned()),
        ..Watch::default()
    };
    // in the idle case no location that a property reads changes
    let idle = ROVER.replace("case IDLE: mode := WAITING", "case IDLE: skip");
    for (name, text, is_busy) in [("idle", idle.as_str(), false), ("busy", ROVER, true)] {
        let mut runs = [&off, &Watch::default(), &safe].map(|watch| rover(watch, text));
        let mut times = [Vec::new(), Vec::new(), Vec::new()];
        for _ in 0..ROUNDS {
            for (run, times) in runs.iter_mut().zip(&mut times) {
                times.push(time(run, is_busy));
            }
        }
        let without = times[0].clone();
        for (label, times) in ["without", "monitors", "monitors and safe rule"]
            .iter()
            .zip(&mut times)
        {
            let ratios = times
                .iter()
                .zip(&without)
                .map(|(with, without)| with / without);
            let mut ratios: Vec<f64> = ratios.collect();
            println!(
                "{name:5} {label:23} {:8.0} steps/s, time ratio {:.3}",
                STEPS as f64 / median(times),
                median(&mut ratios)
            );
        }
    }
}
