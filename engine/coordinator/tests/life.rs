//! A running coordinator: one event a step, counted losses, and the end of its calls when it is stopped.

use std::sync::{Arc, Mutex};

use asmotion_component::{
    Activity, Component, Cycle, Fault, Interface, Losses, NOTICE_REPORT, Operation, Policy,
    Provided, ServiceFault, Span, Time, Transition, Wire,
};
use asmotion_coordinator::{
    Action, Argument, Binding, BoundOperation, Call, Case, Coordinator, CoordinatorStatus, Effect,
    Interfaces, LOSSES_REPORT, Monitored, Out, PublishWhen, Published, Receive, STEP_REPORT,
    Source, StepRecord,
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
		else if command = WORK then
			command := NONE
		endif endif
default init s0:
	function seen = []
	function command = NONE
";

/// A coordinator that receives events, and calls a service that replies with a fault of the code `fault`, or never. `other` are
/// the actions of its command beside the call.
fn system(activity: Activity, fault: Option<&'static str>, other: Option<Case>) -> System {
    let mut files = MemoryFiles::new();
    files.add("worker.asm", WORKER);
    let specification = asmotion_lang::open("worker.asm", &files).unwrap();
    let named = |name: &str| Some(name.to_owned());
    let work = Case {
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
    };
    let binding = Binding {
        monitored: vec![Monitored {
            receive: Receive::All,
            ..Monitored::new("event", Source::Port("event".to_owned()))
        }],
        out: vec![Out {
            location: "command".into(),
            effect: Effect::Literals(std::iter::once(work).chain(other).collect()),
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
    simulate_system(system(activity, None, None))
}

fn simulate_system(mut system: System) -> (Simulation, Told) {
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
    // of the first burst one did not fit the port; 63 arrived with the misfit, 5 were consumed, 63 wait
    let by_coordinator = 63 + 4 * 64 - 5 - 63;
    assert_eq!(lost.dropped, by_coordinator + 1);
    assert_eq!(run.lost("Worker"), [lost.dropped]);
    let told = told.lock().unwrap();
    let last = told.iter().rfind(|(kind, _)| kind == LOSSES_REPORT);
    let reported = last.unwrap().1.to::<Losses>().unwrap();
    assert_eq!((reported.dropped, reported.misfits), (by_coordinator, 1));
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
        let (mut run, told) =
            simulate_system(system(Activity::periodic(10.ms()), Some(code), None));
        let now = run.now();
        tell(&mut run, now, "GO");
        run.run_for(1.s());
        assert_eq!(seen(&told), ["[GO]", &format!("[GO, {literal}]")]);
    }
}

#[test]
fn an_update_to_a_value_without_an_action_leaves_the_call_under_way() {
    let no_action = || Case {
        literal: "NONE".to_owned(),
        actions: Vec::new(),
    };
    let cancels = |cancels| Case {
        actions: vec![Action::Cancel(cancels)],
        ..no_action()
    };
    let (ends, is_cancelled) = (vec!["[GO]", "[GO, FAILED]"], vec!["[GO]"]);
    let cases = [
        (None, &ends),
        (Some(no_action()), &ends),
        (Some(cancels(false)), &ends),
        (Some(cancels(true)), &is_cancelled),
    ];
    for (other, wanted) in cases {
        // `command` is WORK for one step, and the call ends at its deadline
        let made = format!("{other:?}");
        let (mut run, told) = simulate_system(system(Activity::periodic(10.ms()), None, other));
        let now = run.now();
        tell(&mut run, now, "GO");
        run.run_for(100.s());
        assert_eq!(seen(&told), *wanted, "{made}");
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

const FLEET: &str = "
asm fleet
import StandardLibrary
signature:
	enum domain Robot = {ROB1 | ROB2}
	monitored wants: Robot -> Boolean
	controlled asked: Seq(Robot)
	out order: Robot -> Integer
definitions:
	main rule r_Main =
		let ($all = {$r in Robot | wants($r) : $r}) in
			if notEmpty($all) then
				par
					forall $r in $all do order($r) := size($all)
					asked := union(asked, asSequence($all))
				endpar
			endif
		endlet
default init s0:
	function asked = []
";

/// A fleet whose robots send their wishes on one topic, and the orders that it publishes.
fn fleet() -> (Simulation, Told, Arc<Mutex<Vec<Datum>>>) {
    let mut files = MemoryFiles::new();
    files.add("fleet.asm", FLEET);
    let specification = asmotion_lang::open("fleet.asm", &files).unwrap();
    let key = vec![("r".to_owned(), "robot".to_owned())];
    let binding = Binding {
        monitored: vec![Monitored {
            key: key.clone(),
            field: Some("wants".to_owned()),
            none: Some(Datum::Bool(false).into()),
            ..Monitored::new("wants($r)", Source::Port("wishes".to_owned()))
        }],
        out: vec![Out {
            location: "order($r)".into(),
            effect: Effect::Publish(Published {
                port: "orders".to_owned(),
                field: Some("number".to_owned()),
                key,
                when: PublishWhen::OnUpdate,
            }),
        }],
    };
    let interfaces = Interfaces {
        inputs: vec![("wishes".to_owned(), Schema::opaque("test/Wish"))],
        outputs: vec![("orders".to_owned(), Schema::opaque("test/Order"))],
        ..Interfaces::default()
    };
    let mut system = System::new();
    let made = system.add("Fleet", Activity::event(), |interface| {
        let made = Coordinator::new(specification, &binding, &interfaces, 1, interface);
        Box::new(made.unwrap())
    });
    made.unwrap();
    system
        .subscribe("wishes", "Fleet.wishes", Policy::buffer(64))
        .unwrap();
    let (told, sent) = (Told::default(), Arc::new(Mutex::new(Vec::new())));
    let (teller, orders) = (Arc::clone(&told), Arc::clone(&sent));
    system.observe(move |_: Time, event: &Event<'_>| {
        if let Event::Report { kind, data, .. } = event {
            let report = ((*kind).to_owned(), (*data).clone());
            teller.lock().unwrap().push(report);
        } else if let Event::Published { sample, .. } = event {
            orders.lock().unwrap().push(sample.to_datum().unwrap());
        }
    });
    (system.simulate(), told, sent)
}

fn wish(run: &mut Simulation, robot: &str, wants: bool) {
    let (robot, wants) = (Datum::text(robot), Datum::Bool(wants));
    let sample = Arc::new(Datum::record([("robot", robot), ("wants", wants)]));
    let now = run.now();
    run.publish_sample(now, "wishes", sample).unwrap();
}

#[test]
fn a_field_of_the_message_selects_the_location() {
    let (mut run, told, sent) = fleet();
    run.run_for(1.ms());
    // none of them hides another, although they come together and only the newest value counts
    wish(&mut run, "ROB1", true);
    wish(&mut run, "ROB2", true);
    wish(&mut run, "ROB1", false);
    run.run_for(1.ms());
    wish(&mut run, "ROB1", true);
    run.run_for(1.ms());
    let order = |robot: &str, number| {
        Datum::record([
            ("robot", Datum::text(robot)),
            ("number", Datum::Int(number)),
        ])
    };
    let wanted = [order("ROB2", 1), order("ROB1", 2), order("ROB2", 2)];
    assert_eq!(*sent.lock().unwrap(), wanted);
    assert_eq!(run.losses("Fleet"), Losses::default());
    assert!(
        told.lock()
            .unwrap()
            .iter()
            .all(|(kind, _)| kind == STEP_REPORT)
    );
}

#[test]
fn a_key_that_names_no_element_is_counted_and_reported_once() {
    let (mut run, told, _) = fleet();
    run.run_for(1.ms());
    for robot in ["ROB3", "", "ROB3"] {
        wish(&mut run, robot, true);
    }
    wish(&mut run, "ROB2", true);
    run.run_for(1.ms());
    assert_eq!(run.losses("Fleet").misfits, 3);
    let told = told.lock().unwrap();
    let mut notices = told.iter().filter(|(kind, _)| kind == NOTICE_REPORT);
    let notice = notices.next().unwrap().1.as_text().unwrap();
    assert!(
        notice.contains("wants") && notice.contains("ROB3"),
        "{notice}"
    );
    assert!(notices.next().is_none());
    // the message behind them is not lost
    let steps = told.iter().filter(|(kind, _)| kind == STEP_REPORT);
    let steps: Vec<StepRecord> = steps.map(|(_, step)| step.to().unwrap()).collect();
    let updates = steps.iter().flat_map(|step| &step.updates);
    assert!(updates.into_iter().any(|it| it.location == "order(ROB2)"));
}

#[test]
fn a_fleet_that_was_frozen_goes_on_with_what_each_robot_said_last() {
    let (mut run, ..) = fleet();
    run.run_for(1.ms());
    wish(&mut run, "ROB1", true);
    wish(&mut run, "ROB9", true);
    run.run_for(1.ms());
    let frozen = run.freeze().unwrap();
    let (mut other, told, sent) = fleet();
    other.run_for(1.ms());
    other.thaw(&frozen).unwrap();
    wish(&mut other, "ROB2", true);
    wish(&mut other, "ROB9", true);
    other.run_for(1.ms());
    let orders = sent.lock().unwrap().len();
    assert_eq!(orders, 2, "both robots have orders");
    assert_eq!(other.losses("Fleet").misfits, 2);
    let told = told.lock().unwrap();
    assert!(told.iter().all(|(kind, _)| kind != NOTICE_REPORT));
}

fn status(run: &mut Simulation) -> CoordinatorStatus {
    CoordinatorStatus::of(&run.inspect("Worker").unwrap()).unwrap()
}

#[test]
fn its_state_is_described_to_observers() {
    let (mut run, told) = simulate(Activity::periodic(10.ms()));
    run.run_for(25.ms());
    let before = status(&mut run);
    assert_eq!(before.control_state(), Some(("command", "NONE")));
    assert!(before.silent.contains("event") && before.last_update.is_none());
    assert_eq!(before.read["event"], "undef");
    let now = run.now();
    for event in ["GO", "DONE", "DONE"] {
        tell(&mut run, now, event);
    }
    run.trigger("Worker").unwrap();
    run.run_for(1.ms());
    let after = status(&mut run);
    assert_eq!(after.control_state(), Some(("command", "WORK")));
    assert_eq!(after.calls, ["works.work"]);
    assert!(after.silent.is_empty());
    let last = after.last_update.as_ref().unwrap();
    assert!(last.updates.contains_key("seen") && last.step <= after.step);
    // an observer changes nothing
    let steps = seen(&told).len();
    for _ in 0..100 {
        status(&mut run);
    }
    assert_eq!((seen(&told).len(), status(&mut run)), (steps, after));
    assert!(run.inspect("Deaf").unwrap().is_empty());
    assert!(run.inspect("Nobody").is_err());
}

#[test]
fn its_last_update_is_the_same_with_and_without_observers() {
    let (mut observed, _) = simulate(Activity::event());
    let mut alone = system(Activity::event(), None, None).simulate();
    for run in [&mut observed, &mut alone] {
        run.run_for(1.ms());
        let now = run.now();
        for event in ["DONE", "GO"] {
            tell(run, now, event);
        }
        run.run_for(5.ms());
    }
    let [with, without] = [&mut observed, &mut alone].map(status);
    assert_eq!(with, without);
    let last = without.last_update.unwrap();
    assert_eq!(last.updates["seen"], "[DONE, GO]");
    // a new machine has made no step yet
    for to in [Transition::Stop, Transition::Cleanup, Transition::Configure] {
        alone.transition("Worker", to).unwrap();
    }
    let status = status(&mut alone);
    assert_eq!((status.step, status.last_update), (0, Some(last)));
}

const CHARGER: &str = "
asm charger
import StandardLibrary
signature:
	enum domain Mode = {DRIVING | CHARGING | GIVEN_UP}
	enum domain Order = {NONE | GO}
	monitored full: Boolean
	monitored chargeTimeout: Boolean
	monitored tour: Seq(Prod(Integer, String))
	controlled mode: Mode
	controlled left: Seq(Prod(Integer, String))
	controlled goal: Prod(Integer, String)
	out order: Order
definitions:
	rule r_next =
		if length(left) > 0 then
			par
				goal := first(left)
				left := tail(left)
				order := GO
			endpar
		endif
	main rule r_Main =
		switch mode
			case DRIVING: par mode := CHARGING  left := tour endpar
			case CHARGING:
				if chargeTimeout then mode := GIVEN_UP
				else if full then mode := DRIVING else r_next[] endif endif
			case GIVEN_UP: if full then mode := DRIVING endif
		endswitch
default init s0:
	function mode = DRIVING
	function order = NONE
";

/// A charger that steps every 100 ms, gives up after 500 ms of charging, and sends its tour meanwhile.
fn charger() -> (Simulation, Told, Arc<Mutex<Vec<Datum>>>) {
    let mut files = MemoryFiles::new();
    files.add("charger.asm", CHARGER);
    let specification = asmotion_lang::open("charger.asm", &files).unwrap();
    let stop = |number, name: &str| Datum::List(vec![Datum::Int(number), Datum::text(name)]);
    let tour = Datum::List(vec![stop(1, "hall"), stop(2, "lab"), stop(3, "dock")]);
    let term = |text: &str| Argument::Term(text.to_owned());
    let goal = vec![
        ("number".to_owned(), term("first(goal)")),
        ("name".to_owned(), term("second(goal)")),
        ("mode".to_owned(), term("mode")),
    ];
    let timer = Source::Timer {
        running: "mode = CHARGING".to_owned(),
        ms: 500,
    };
    let binding = Binding {
        monitored: vec![
            Monitored {
                none: Some(Datum::Bool(false).into()),
                ..Monitored::new("full", Source::Port("full".to_owned()))
            },
            Monitored::new("chargeTimeout", timer),
            Monitored::new("tour", Source::Value(tour.into())),
        ],
        out: vec![Out {
            location: "order".into(),
            effect: Effect::Literals(vec![Case {
                literal: "GO".to_owned(),
                actions: vec![Action::Publish {
                    port: "goal".to_owned(),
                    value: Argument::Record(goal),
                }],
            }]),
        }],
    };
    let interfaces = Interfaces {
        inputs: vec![("full".to_owned(), Schema::opaque("test/Full"))],
        outputs: vec![("goal".to_owned(), Schema::opaque("test/Goal"))],
        ..Interfaces::default()
    };
    let mut system = System::new();
    let made = system.add("Charger", Activity::periodic(100.ms()), |interface| {
        let made = Coordinator::new(specification, &binding, &interfaces, 1, interface);
        Box::new(made.unwrap())
    });
    made.unwrap();
    system
        .subscribe("full", "Charger.full", Policy::data())
        .unwrap();
    let (told, sent) = (Told::default(), Arc::new(Mutex::new(Vec::new())));
    let (teller, goals) = (Arc::clone(&told), Arc::clone(&sent));
    system.observe(move |now: Time, event: &Event<'_>| {
        if let Event::Report { kind, data, .. } = event
            && *kind == STEP_REPORT
        {
            let at = format!("{} ms", now.nanos() / 1_000_000);
            teller.lock().unwrap().push((at, (*data).clone()));
        } else if let Event::Published { sample, .. } = event {
            goals.lock().unwrap().push(sample.to_datum().unwrap());
        }
    });
    (system.simulate(), told, sent)
}

/// The modes that the charger entered, with their times.
fn modes(told: &Told) -> Vec<(String, String)> {
    let mut modes = Vec::new();
    for (at, step) in told.lock().unwrap().iter() {
        let step: StepRecord = step.to().unwrap();
        let entered = step.updates.iter().filter(|it| it.location == "mode");
        modes.extend(entered.map(|it| (at.clone(), it.after.clone())));
    }
    modes
}

fn mode(at: &str, mode: &str) -> (String, String) {
    (at.to_owned(), mode.to_owned())
}

#[test]
fn a_timer_starts_with_its_condition_and_stops_without_it() {
    let (mut run, told, _) = charger();
    run.run_for(350.ms());
    // charging ends in time, begins again, and lasts too long
    let full = |run: &mut Simulation, full: bool| {
        let now = run.now();
        let sample = Arc::new(Datum::Bool(full));
        run.publish_sample(now, "full", sample).unwrap();
    };
    full(&mut run, true);
    run.run_for(100.ms());
    full(&mut run, false);
    run.run_for(1.s());
    let entered = modes(&told);
    let expected = [
        mode("0 ms", "CHARGING"),
        mode("400 ms", "DRIVING"),
        mode("500 ms", "CHARGING"),
        mode("1000 ms", "GIVEN_UP"),
    ];
    assert_eq!(entered, expected);
}

#[test]
fn a_timer_that_was_frozen_elapses_at_the_same_time() {
    let (mut run, told, _) = charger();
    run.run_for(250.ms());
    let frozen = run.freeze().unwrap();
    let (mut other, again, _) = charger();
    other.thaw(&frozen).unwrap();
    run.run_for(1.s());
    other.run_for(1.s());
    let last = modes(&told).pop().unwrap();
    assert_eq!(last.1, "GIVEN_UP");
    assert_eq!(modes(&again), [last]);
}

#[test]
fn a_message_takes_values_of_the_specification() {
    let (mut run, _, sent) = charger();
    run.run_for(2.s());
    let goal = |number, name: &str| {
        Datum::record([
            ("number", Datum::Int(number)),
            ("name", Datum::text(name)),
            ("mode", Datum::text("CHARGING")),
        ])
    };
    let tour = [goal(1, "hall"), goal(2, "lab"), goal(3, "dock")];
    assert_eq!(*sent.lock().unwrap(), tour);
}

#[test]
fn a_term_that_does_not_fit_is_an_error_of_the_binding() {
    let mut files = MemoryFiles::new();
    files.add("charger.asm", CHARGER);
    let specification = asmotion_lang::open("charger.asm", &files).unwrap();
    let timer = Source::Timer {
        running: "mode = CHARGED".to_owned(),
        ms: 500,
    };
    let binding = Binding {
        monitored: vec![Monitored::new("chargeTimeout", timer)],
        out: Vec::new(),
    };
    let mut system = System::new();
    let mut error = None;
    let _ = system.add("Charger", Activity::event(), |interface| {
        let interfaces = Interfaces::default();
        error = Coordinator::new(specification, &binding, &interfaces, 1, interface).err();
        Box::new(Idle)
    });
    let error = error.unwrap().to_string();
    assert!(error.contains("mode = CHARGED"), "{error}");
}

struct Idle;

impl Component for Idle {
    fn update(&mut self, _: &mut Cycle<'_>) -> Result<(), Fault> {
        Ok(())
    }
}
