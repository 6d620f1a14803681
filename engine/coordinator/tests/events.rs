//! Events of a specification: how many wait, what is said about those that are lost, and which ones are refused.

use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use asmotion_component::{Activity, Losses, NOTICE_REPORT, Policy, Span, Time};
use asmotion_coordinator::{
    Argument, Binding, Coordinator, Effect, Interfaces, Monitored, Out, PublishWhen, Published,
    Receive, STEP_REPORT, Source, StepRecord,
};
use asmotion_datum::{Datum, Schema};
use asmotion_lang::MemoryFiles;
use asmotion_runtime::{Event, Run, Simulation, System};

const WATCHER: &str = "
asm watcher
import StandardLibrary
signature:
	enum domain Event = {NOTHING | DONE}
	monitored event: Event
	monitored lost: Natural
	monitored anyLost: Boolean
	monitored go: Boolean
	controlled seen: Integer
	controlled total: Integer
	controlled alarms: Integer
	out order: Integer
definitions:
	main rule r_Main =
		par
			if event = DONE then seen := seen + 1 endif
			if lost > 0n then total := total + ntoi(lost) endif
			if anyLost then alarms := alarms + 1 endif
			if go then order := order + 1 endif
		endpar
default init s0:
	function seen = 0
	function total = 0
	function alarms = 0
	function order = 0
";

/// The last value of each location that the specification wrote, and the notices.
type Told = Arc<Mutex<(Vec<(String, String)>, Vec<String>)>>;

/// A specification that counts its events and its losses; `matching` is the condition on its messages.
fn system(matching: Vec<(String, Argument)>, policy: Option<Policy>) -> (System, Told) {
    let mut files = MemoryFiles::new();
    files.add("watcher.asm", WATCHER);
    let specification = asmotion_lang::open("watcher.asm", &files).unwrap();
    let port = || "event".to_owned();
    let binding = Binding {
        monitored: vec![
            Monitored {
                receive: Receive::All,
                map: Some("code".to_owned()),
                none: Some(Datum::text("NOTHING").into()),
                matching,
                ..Monitored::new("event", Source::Port(port()))
            },
            Monitored::new("lost", Source::Losses(port())),
            Monitored::new("anyLost", Source::Losses(port())),
            Monitored {
                receive: Receive::Edge,
                ..Monitored::new("go", Source::Port("go".to_owned()))
            },
        ],
        out: vec![Out {
            location: "order".into(),
            effect: Effect::Publish(Published {
                port: "order".to_owned(),
                field: Some("id".to_owned()),
                key: Vec::new(),
                when: PublishWhen::OnUpdate,
            }),
        }],
    };
    let typed = |name: &str| (name.to_owned(), Schema::opaque(format!("test/{name}")));
    let interfaces = Interfaces {
        inputs: vec![typed("event"), typed("go")],
        outputs: vec![typed("order")],
        ..Interfaces::default()
    };
    let mut system = System::new();
    let made = system.add("Watcher", Activity::periodic(1.ms()), |interface| {
        let made = Coordinator::new(specification, &binding, &interfaces, 1, interface);
        Box::new(made.unwrap())
    });
    made.unwrap();
    let event = policy.unwrap_or_else(Policy::data);
    system.subscribe("event", "Watcher.event", event).unwrap();
    system
        .subscribe("go", "Watcher.go", Policy::data())
        .unwrap();
    let told = Told::default();
    let teller = Arc::clone(&told);
    system.observe(move |_: Time, event: &Event<'_>| {
        let Event::Report { kind, data, .. } = event else {
            return;
        };
        let mut told = teller.lock().unwrap();
        if *kind == STEP_REPORT {
            for update in data.to::<StepRecord>().unwrap().updates {
                told.0.retain(|(location, _)| *location != update.location);
                told.0.push((update.location, update.after));
            }
        } else if *kind == NOTICE_REPORT {
            told.1.push(data.as_text().unwrap().to_owned());
        }
    });
    (system, told)
}

/// The last value of an integer location; 0 if it was never written.
fn value(told: &Told, location: &str) -> u64 {
    let told = told.lock().unwrap();
    let found = told.0.iter().find(|(known, _)| known == location);
    found.map_or(0, |(_, value)| value.parse().unwrap())
}

fn send(run: &mut dyn Run, topic: &str, plan: i64) {
    let fields = [("code", Datum::text("DONE")), ("plan", Datum::Int(plan))];
    let now = run.now();
    let sample = Arc::new(Datum::record(fields));
    run.publish_sample(now, topic, sample).unwrap();
}

/// Sends bursts of events, some of which come while others wait for a step. Returns the numbers of events that were sent,
/// seen by the specification, and lost according to it.
fn bursts(run: &mut dyn Run, told: &Told, sizes: &[u64], between: Duration) -> [u64; 3] {
    for size in sizes {
        (0..*size).for_each(|_| send(run, "event", 0));
        run.run_for(between);
    }
    let sent = sizes.iter().sum();
    let settled = || value(told, "seen") + value(told, "total") == sent;
    let begun = Instant::now();
    while !settled() && begun.elapsed() < Duration::from_secs(20) {
        run.run_for(100.ms());
    }
    [sent, value(told, "seen"), value(told, "total")]
}

#[test]
fn the_written_queue_holds_up_to_the_specification() {
    let sizes = [600, 300, 300];
    for (policy, lost) in [
        (Policy::buffer(1200), 0),
        (Policy::circular(1200), 0),
        // of the first burst 100 reach the port; of the others, as many as steps were made meanwhile
        (Policy::buffer(100), 500 + 2 * 290),
        (Policy::circular(100), 500 + 2 * 290),
    ] {
        let (system, told) = system(Vec::new(), Some(policy.clone()));
        let mut run = system.simulate();
        run.run_for(1.ms());
        let found = bursts(&mut run, &told, &sizes, 10.ms());
        assert_eq!(found, [1200, 1200 - lost, lost], "{policy:?}");
        let losses = run.losses("Watcher");
        assert_eq!((losses.dropped, losses.misfits), (lost, 0), "{policy:?}");
        assert_eq!(run.lost("Watcher"), [lost, 0], "{policy:?}");
        // once in a step, whatever the number
        assert_eq!(value(&told, "alarms") > 0, lost > 0);
        assert!(value(&told, "alarms") < 40);
    }
}

#[test]
fn on_the_wall_clock_every_event_is_seen_or_reported_as_lost() {
    for (size, loses) in [(1200, false), (50, true)] {
        let (system, told) = system(Vec::new(), Some(Policy::buffer(size)));
        let mut run = system.live();
        run.run_for(10.ms());
        let [sent, seen, lost] = bursts(&mut run, &told, &[600, 300, 300], 5.ms());
        run.stop();
        assert_eq!((sent, lost > 0), (seen + lost, loses), "{size}");
        assert_eq!(run.losses("Watcher").dropped, lost);
    }
}

#[test]
fn frozen_losses_are_reported_once() {
    let start = || {
        let (system, told) = system(Vec::new(), Some(Policy::circular(100)));
        (system.simulate(), told)
    };
    let (mut run, told) = start();
    run.run_for(1.ms());
    (0..150).for_each(|_| send(&mut run, "event", 0));
    // before the step that sees them, and after it
    for _ in 0..2 {
        let (before, frozen) = (value(&told, "total"), run.freeze().unwrap());
        let (mut other, again) = start();
        other.thaw(&frozen).unwrap();
        run.run_for(5.ms());
        other.run_for(5.ms());
        assert_eq!(value(&told, "total"), 50);
        assert_eq!(value(&again, "total"), if before == 0 { 50 } else { 0 });
        assert_eq!(run.losses("Watcher"), other.losses("Watcher"));
    }
}

/// The number of events that the specification saw, of the messages that were refused, and of notices.
fn refusals(run: &Simulation, told: &Told) -> (u64, u64, usize) {
    let Losses { misfits, dropped } = run.losses("Watcher");
    assert_eq!(dropped, 0);
    (value(told, "seen"), misfits, told.lock().unwrap().1.len())
}

fn about_the_last_order() -> (System, Told) {
    let plan = Argument::Kept {
        name: "order".to_owned(),
        path: Some("id".to_owned()),
    };
    system(vec![("plan".to_owned(), plan)], Some(Policy::buffer(100)))
}

#[test]
fn an_event_about_another_order_is_refused() {
    let (system, told) = about_the_last_order();
    let mut run = system.simulate();
    run.run_for(1.ms());
    // nothing is expected before the first order
    for plan in [0, 1] {
        send(&mut run, "event", plan);
    }
    run.run_for(5.ms());
    assert_eq!(refusals(&run, &told), (0, 2, 1));
    send(&mut run, "go", 0);
    run.run_for(5.ms());
    for plan in [1, 0, 2, 1] {
        send(&mut run, "event", plan);
    }
    run.run_for(5.ms());
    assert_eq!(refusals(&run, &told), (2, 4, 1));
    // a late one about the first order
    send(&mut run, "go", 0);
    run.run_for(5.ms());
    for plan in [1, 2] {
        send(&mut run, "event", plan);
    }
    run.run_for(5.ms());
    assert_eq!(refusals(&run, &told), (3, 5, 1));
}

#[test]
fn waiting_events_about_the_previous_order_are_refused_with_a_new_one() {
    let start = || {
        let (system, told) = about_the_last_order();
        (system.simulate(), told)
    };
    let (mut run, told) = start();
    run.run_for(1.ms());
    send(&mut run, "go", 0);
    run.run_for(5.ms());
    (0..10).for_each(|_| send(&mut run, "event", 1));
    run.run_for(2.ms());
    send(&mut run, "go", 0);
    let frozen = run.freeze().unwrap();
    let (mut other, again) = start();
    other.thaw(&frozen).unwrap();
    run.run_for(20.ms());
    other.run_for(20.ms());
    // two were seen before the order and one in the step that gave it
    assert_eq!(refusals(&run, &told), (3, 7, 0));
    assert_eq!(refusals(&other, &again), (3, 7, 0));
}
