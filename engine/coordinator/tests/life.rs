//! A running coordinator: one event a step, counted losses, and the end of its calls when it is stopped.
#![allow(clippy::unwrap_used, reason = "tests")]

use std::sync::{Arc, Mutex};

use asmotion_component::{
    Activity, Component, Cycle, Fault, Interface, Losses, Operation, Policy, Provided,
    ServiceFault, Span, Time, Transition, Wire,
};
use asmotion_coordinator::{
    Action, Binding, BoundOperation, Call, Case, Coordinator, Effect, Interfaces, LOSSES_REPORT,
    Monitored, Out, Receive, STEP_REPORT, Source, StepRecord,
};
use asmotion_datum::{Datum, Schema};
use asmotion_lang::MemoryFiles;
use asmotion_runtime::{Event, Run, Simulation, System};

asmotion_datum::message! {
    /// A message of which only the arrival matters.
    #[derive(Copy)]
    pub struct Nothing = "test/Nothing" {
        /// nothing
        pub n: i64,
    }
}

struct Work;

impl Operation for Work {
    type Request = Nothing;
    type Response = Nothing;
    const INTERFACE: &'static str = "test/Works";
    const NAME: &'static str = "work";
}

/// Takes requests; replies with a fault of a certain code, or never.
struct Deaf(Provided<Work>, Option<&'static str>);

impl Component for Deaf {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        for request in cycle.requests(self.0) {
            if let Some(code) = self.1 {
                let fault = ServiceFault::new(code, "of no use");
                cycle.reply(self.0, request.id, Err(fault));
            }
        }
        Ok(())
    }
}

const WORKER: &str = "
asm worker
import StandardLibrary
signature:
	enum domain Event = {GO | DONE | FAILED | TOO_HEAVY | NOBODY}
	enum domain Command = {NONE | WORK}
	monitored event: Event
	controlled seen: Seq(Event)
	out command: Command
definitions:
	main rule r_Main =
		if isDef(event) then
			par
				seen := append(seen, event)
				if event = GO and isEmpty(seen) then command := WORK endif
			endpar
		endif
default init s0:
	function seen = []
	function command = NONE
";

/// A coordinator that receives events, and calls a service that replies with a fault of the code `fault`, or never.
fn system(activity: Activity, fault: Option<&'static str>) -> System {
    let mut files = MemoryFiles::new();
    files.add("worker.asm", WORKER);
    let specification = Arc::new(asmotion_lang::open("worker.asm", &files).unwrap());
    let named = |name: &str| Some(name.to_owned());
    let binding = Binding {
        monitored: vec![Monitored {
            receive: Receive::All,
            ..Monitored::new("event", Source::Port("event".to_owned()))
        }],
        out: vec![Out {
            function: "command".to_owned(),
            effect: Effect::Literals(vec![Case {
                literal: "WORK".to_owned(),
                actions: vec![Action::Call(Call {
                    event: named("event"),
                    ok: named("DONE"),
                    failed: named("FAILED"),
                    faults: vec![("WEIGHT".to_owned(), "TOO_HEAVY".to_owned())],
                    unavailable: named("NOBODY"),
                    ..Call::new(BoundOperation {
                        service: "works".to_owned(),
                        operation: "work".to_owned(),
                    })
                })],
            }]),
        }],
    };
    let interfaces = Interfaces {
        inputs: vec![("event".to_owned(), Schema::opaque("test/Text"))],
        references: vec![("works".to_owned(), "test/Works".to_owned())],
        ..Interfaces::default()
    };
    let mut system = System::new();
    let made = system.add("Worker", activity, |interface| {
        let made = Coordinator::new(specification, &binding, &interfaces, 1, interface);
        Box::new(made.unwrap())
    });
    made.unwrap();
    let deaf = |interface: &mut Interface| {
        let work = interface.serve("works", "answers none");
        Box::new(Deaf(work, fault)) as Box<dyn Component>
    };
    system.add("Deaf", Activity::event(), deaf).unwrap();
    let wire = Wire::timeout(60.s());
    system.wire("Worker.works", "Deaf.works", wire).unwrap();
    system
        .subscribe("event", "Worker.event", Policy::buffer(64))
        .unwrap();
    system
}

type Told = Arc<Mutex<Vec<(String, Datum)>>>;

/// Runs the system in simulated time and collects its reports.
fn simulate(activity: Activity) -> (Simulation, Told) {
    simulate_with(activity, None)
}

fn simulate_with(activity: Activity, fault: Option<&'static str>) -> (Simulation, Told) {
    let mut system = system(activity, fault);
    let told = Told::default();
    let teller = Arc::clone(&told);
    system.observe(move |_: Time, event: &Event<'_>| {
        if let Event::Report {
            kind, data: what, ..
        } = event
        {
            let report = ((*kind).to_owned(), (*what).clone());
            teller.lock().unwrap().push(report);
        }
    });
    (system.simulate(), told)
}

/// The values that `seen` took, one a step.
fn seen(told: &Told) -> Vec<String> {
    let told = told.lock().unwrap();
    let steps = told.iter().filter(|(kind, _)| kind == STEP_REPORT);
    let steps = steps.map(|(_, what)| what.to::<StepRecord>().unwrap());
    let updates = steps.flat_map(|step| step.updates);
    updates
        .filter(|update| update.location == "seen")
        .map(|update| update.after)
        .collect()
}

fn tell(run: &mut Simulation, at: Time, event: &str) {
    let sample = Arc::new(Datum::text(event));
    run.publish_sample(at, "event", sample).unwrap();
}

#[test]
fn events_that_come_together_are_taken_one_a_step_without_waiting_for_another() {
    let (mut run, told) = simulate(Activity::event());
    run.run_for(1.ms());
    let now = run.now();
    for event in ["DONE", "FAILED", "DONE"] {
        tell(&mut run, now, event);
    }
    run.run_for(1.ms());
    let wanted = ["[DONE]", "[DONE, FAILED]", "[DONE, FAILED, DONE]"];
    assert_eq!(seen(&told), wanted);
}

#[test]
fn what_is_lost_is_counted_and_told() {
    let (mut run, told) = simulate(Activity::periodic(100.s()));
    run.run_for(1.ms());
    assert_eq!(run.losses("Worker"), Losses::default());
    let now = run.now();
    tell(&mut run, now, "NONSENSE");
    // one event is consumed a step, and none was waiting before
    for _ in 0..5 {
        for _ in 0..64 {
            tell(&mut run, now, "DONE");
        }
        run.trigger("Worker").unwrap();
        run.run_for(1.ms());
    }
    let lost = run.losses("Worker");
    assert_eq!(lost.misfits, 1);
    // the first 63 arrived with the misfit; 5 were consumed, 256 wait
    assert_eq!(lost.dropped, 63 + 4 * 64 - 5 - 256 + 1);
    let told = told.lock().unwrap();
    let last = told.iter().rfind(|(kind, _)| kind == LOSSES_REPORT);
    assert_eq!(last.unwrap().1.to::<Losses>().unwrap(), lost);
}

#[test]
fn a_call_that_nobody_takes_has_a_literal_of_its_own() {
    let (mut run, told) = simulate(Activity::periodic(10.ms()));
    run.transition("Deaf", Transition::Stop).unwrap();
    let now = run.now();
    tell(&mut run, now, "GO");
    run.run_for(1.s());
    assert_eq!(seen(&told), ["[GO]", "[GO, NOBODY]"]);
}

#[test]
fn a_fault_has_the_literal_of_its_code() {
    for (code, literal) in [("WEIGHT", "TOO_HEAVY"), ("COLOUR", "FAILED")] {
        let (mut run, told) = simulate_with(Activity::periodic(10.ms()), Some(code));
        let now = run.now();
        tell(&mut run, now, "GO");
        run.run_for(1.s());
        assert_eq!(seen(&told), ["[GO]", &format!("[GO, {literal}]")]);
    }
}

#[test]
fn a_call_does_not_outlive_a_stop() {
    let (mut run, told) = simulate(Activity::periodic(10.ms()));
    let now = run.now();
    tell(&mut run, now, "GO");
    run.run_for(1.s());
    assert_eq!(seen(&told), ["[GO]"]);
    run.transition("Worker", Transition::Stop).unwrap();
    run.run_for(1.s());
    run.transition("Worker", Transition::Start).unwrap();
    run.run_for(100.s());
    assert_eq!(seen(&told), ["[GO]", "[GO, FAILED]"]);
}
