//! C18: changes of a running system are applied all or none.

use std::any::Any;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use crate::common::{Double, Number, Words, behaviour, counter, doubler, in_real_time, number};
use asmotion_component::{
    Activity, CallError, Component, Cycle, Fault, In, Interface, Out, Policy, Span, Time, Wire,
};
use asmotion_datum::Datum;
use asmotion_runtime::{Change, Log, Replacement, Run, System};

/// The values that a reader has seen, in order.
type Seen = Arc<Mutex<Vec<i64>>>;

fn reader(seen: &Seen) -> impl FnOnce(&mut Interface) -> Box<dyn Component> {
    let seen = Arc::clone(seen);
    behaviour(move |interface| {
        let input = interface.input::<Number>("n", "numbers");
        interface
            .setting("gain", 1.0, "of what is read")
            .range(0.0..=10.0)
            .declare();
        move |cycle| {
            let all = cycle.all(input).iter().map(|sample| sample.n);
            seen.lock().unwrap().extend(all);
            Ok(())
        }
    })
}

/// Two counters, of which `Steady` is read by `Witness` and `Other` by `Guest`.
fn system(witness: &Seen, guest: &Seen) -> System {
    let mut system = System::new();
    for name in ["Steady", "Other"] {
        let activity = Activity::periodic(1.ms());
        system.add(name, activity, counter()).unwrap();
    }
    let activity = Activity::periodic(5.ms());
    system.add("Witness", activity, reader(witness)).unwrap();
    system
        .add("Guest", Activity::event(), reader(guest))
        .unwrap();
    let policy = Policy::buffer(1000);
    system
        .connect("Steady.n", "Witness.n", policy.clone())
        .unwrap();
    system.connect("Other.n", "Guest.n", policy).unwrap();
    system
}

fn connect(from: &str, to: &str) -> Change {
    Change::Connect {
        from: from.to_owned(),
        to: to.to_owned(),
        policy: Policy::buffer(1000),
    }
}

fn disconnect(from: &str, to: &str) -> Change {
    Change::Disconnect {
        from: from.to_owned(),
        to: to.to_owned(),
    }
}

fn gain(value: f64) -> Change {
    Change::Set {
        component: "Guest".to_owned(),
        values: vec![("gain".to_owned(), Datum::Float(value))],
    }
}

/// Moves `Guest` from `Other` to `Steady`, and changes a gain and a period.
fn good() -> [Change; 4] {
    [
        disconnect("Other.n", "Guest.n"),
        connect("Steady.n", "Guest.n"),
        gain(2.0),
        Change::SetPeriod {
            component: "Other".to_owned(),
            period: 10.ms(),
        },
    ]
}

/// Lists of changes of which only the last is impossible, with the expected errors.
fn bad() -> [(Vec<Change>, &'static str); 4] {
    let all_but = |last: Change| {
        let mut changes = good().to_vec();
        changes.push(last);
        changes
    };
    [
        (
            all_but(gain(11.0)),
            "property `gain` of `Guest` must be between 0.0 and 10.0, not 11.0",
        ),
        (
            all_but(connect("Steady.n", "Gest.n")),
            "unknown component `Gest`; did you mean `Guest`?",
        ),
        (
            all_but(connect("Steady.n", "Guest.n")),
            "`Steady.n` is already connected to `Guest.n`",
        ),
        (
            all_but(disconnect("Other.n", "Guest.n")),
            "`Other.n` is not connected to `Guest.n`",
        ),
    ]
}

/// Runs the system, tries all bad lists, then the good one, and checks that connections not concerned lose no sample.
fn changes(run: &mut impl Run, [witness, guest]: [&Seen; 2]) {
    run.run_for(50.ms());
    for (changes, reason) in bad() {
        assert_eq!(run.change(&changes).unwrap_err().to_string(), reason);
    }
    run.run_for(50.ms());
    let before = guest.lock().unwrap().len();
    assert!(before > 20, "the old connection is as it was: {before}");
    run.change(&good()).unwrap();
    run.run_for(100.ms());
    assert_eq!(
        run.properties("Guest").unwrap(),
        [("gain".to_owned(), Datum::Float(2.0))]
    );
    run.stop();
    let witness = witness.lock().unwrap();
    assert!(witness.len() > 100, "{}", witness.len());
    assert!(witness.iter().zip(1..).all(|(n, expected)| *n == expected));
    let guest = guest.lock().unwrap();
    let jumps = guest.windows(2).filter(|pair| pair[1] != pair[0] + 1);
    assert!(jumps.count() <= 1, "from one count to the other: {guest:?}");
    assert!(guest.len() > before + 20, "{guest:?}");
}

#[test]
fn c18_a_simulated_system_changes_as_a_whole_or_not_at_all() {
    let (witness, guest) = (Seen::default(), Seen::default());
    let mut run = system(&witness, &guest).simulate();
    changes(&mut run, [&witness, &guest]);
    // 100 periods of 1 ms, then 10 of 10 ms
    assert_eq!(run.cycles("Other"), 111);
}

#[test]
fn c18_a_live_system_changes_as_a_whole_or_not_at_all() {
    in_real_time(|| {
        let (witness, guest) = (Seen::default(), Seen::default());
        let mut run = system(&witness, &guest).live();
        changes(&mut run, [&witness, &guest]);
        assert!(run.cycles("Other") < 150, "{}", run.cycles("Other"));
    });
}

/// Calls `double` for its count in every cycle, and writes the results.
fn asker() -> impl FnOnce(&mut Interface) -> Box<dyn Component> {
    behaviour(|interface| {
        let double = interface.require::<Double>("sums", "who doubles");
        let mut n = 0;
        move |cycle| {
            for reply in cycle.replies(double) {
                let text = match reply.result {
                    Ok(Number { n }) => n.to_string(),
                    Err(CallError::Unavailable | CallError::Stopped) => "nobody".to_owned(),
                    Err(error) => error.to_string(),
                };
                cycle.report("reply", Datum::text(text));
            }
            n += 1;
            cycle.call(double, number(n));
            Ok(())
        }
    })
}

/// Provides the service of `doubler`, and never replies.
fn idler() -> impl FnOnce(&mut Interface) -> Box<dyn Component> {
    behaviour(|interface| {
        let double = interface.serve::<Double>("sums", "does not double");
        move |cycle| {
            cycle.requests(double);
            Ok(())
        }
    })
}

#[test]
fn c18_a_reference_leaves_a_service_for_another() {
    let log = Log::new();
    let mut system = System::new();
    system.observe(log.clone());
    let activity = Activity::periodic(10.ms());
    system.add("Asker", activity, asker()).unwrap();
    system.add("Idler", Activity::event(), idler()).unwrap();
    system.add("Doubler", Activity::event(), doubler()).unwrap();
    let wire = Wire::default();
    system.wire("Asker.sums", "Idler.sums", wire).unwrap();
    let mut run = system.simulate();
    run.run_for(15.ms());
    let [reference, from, to] = ["Asker.sums", "Idler.sums", "Doubler.sums"].map(str::to_owned);
    let unwire = Change::Unwire {
        reference: reference.clone(),
        service: from,
    };
    let wire = Change::Wire {
        reference,
        service: to,
        wire,
    };
    let refused = run.change(std::slice::from_ref(&wire)).unwrap_err();
    assert_eq!(
        refused.to_string(),
        "`Asker.sums` is already connected to `Idler.sums`"
    );
    run.change(&[unwire, wire]).unwrap();
    run.run_for(20.ms());
    assert_eq!(
        log.lines_with("reply: "),
        [
            "0.02 s Asker: reply: \"nobody\"",
            "0.02 s Asker: reply: \"nobody\"",
            "0.03 s Asker: reply: \"6\"",
        ]
    );
}

/// O12: two gains set together are never seen half applied.
#[test]
fn o12_two_gains_are_never_seen_half_applied() {
    let torn = Arc::new(AtomicBool::new(false));
    let seen = Arc::clone(&torn);
    let mut system = System::new();
    let pid = behaviour(move |interface| {
        let kp = interface.property("kp", 0.0, "for the error");
        let ki = interface.property("ki", 0.0, "for its sum");
        move |cycle| {
            let before = cycle.property(kp);
            std::thread::sleep(Duration::from_micros(100));
            if cycle.property(ki) != before {
                seen.store(true, Ordering::Relaxed);
            }
            Ok(())
        }
    });
    system.add("Pid", Activity::periodic(1.ms()), pid).unwrap();
    let mut run = system.live();
    for gain in 1..=200 {
        let value = Datum::Float(f64::from(gain));
        let values = ["kp", "ki"].map(|name| (name.to_owned(), value.clone()));
        run.set_properties("Pid", &values).unwrap();
    }
    run.run_for(20.ms());
    assert!(run.cycles("Pid") > 5);
    assert!(!torn.load(Ordering::Relaxed));
    assert_eq!(run.properties("Pid").unwrap()[0].1, Datum::Float(200.0));
}

/// Adds `step` to its count in each cycle, and takes over the count of its predecessor as often as it is permitted.
struct Tally {
    n: i64,
    step: i64,
    nap: Duration,
    permits: Arc<AtomicU32>,
    out: Out<Number>,
}

impl Component for Tally {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        std::thread::sleep(self.nap);
        self.n += self.step;
        cycle.write(self.out, number(self.n));
        Ok(())
    }

    fn take_over(&mut self, predecessor: &dyn Component, _: Time) -> Result<Vec<String>, Fault> {
        let predecessor: &dyn Any = predecessor;
        let predecessor = predecessor.downcast_ref::<Self>();
        let predecessor = predecessor.ok_or_else(|| Fault::new("it does not count"))?;
        let permits = |permits: u32| permits.checked_sub(1);
        let permitted = self
            .permits
            .fetch_update(Ordering::Relaxed, Ordering::Relaxed, permits);
        permitted.map_err(|_| Fault::new("it is not permitted any more"))?;
        self.n = predecessor.n;
        Ok(vec![format!("continues from {}", self.n)])
    }
}

fn tally(
    step: i64,
    nap: Duration,
    permits: u32,
) -> impl Fn(&mut Interface) -> Result<Box<dyn Component>, String> + Send + Sync + 'static {
    let permits = Arc::new(AtomicU32::new(permits));
    move |interface| {
        Ok(Box::new(Tally {
            n: 0,
            step,
            nap,
            permits: Arc::clone(&permits),
            out: interface.output("n", "the count"),
        }))
    }
}

/// Two tallies with a period of 10 ms, and an idler.
fn tallies(nap: Duration) -> (System, Log) {
    let (log, mut system) = (Log::new(), System::new());
    system.observe(log.clone());
    for name in ["One", "Two"] {
        let made = |interface: &mut Interface| tally(1, nap, 9)(interface).unwrap();
        system.add(name, Activity::periodic(10.ms()), made).unwrap();
    }
    system.add("Idler", Activity::event(), idler()).unwrap();
    (system, log)
}

fn replace(component: &str, step: i64, permits: u32) -> Change {
    Change::Replace {
        component: component.to_owned(),
        by: Replacement::new("another tally", tally(step, Duration::ZERO, permits)),
    }
}

fn counts(log: &Log, port: &str) -> Vec<i64> {
    let samples = log.samples::<Number>(port).into_iter();
    samples.map(|(_, number)| number.n).collect()
}

#[test]
fn c18_a_component_is_replaced_between_two_of_its_cycles() {
    let (system, log) = tallies(Duration::ZERO);
    let mut run = system.simulate();
    run.run_for(25.ms());
    let changes = [replace("One", 100, 9), replace("Two", -1, 9)];
    let notes = ["continues from 3", "continues from 3"].map(str::to_owned);
    assert_eq!(run.check_change(&changes).unwrap(), notes);
    run.run_for(10.ms());
    assert_eq!(run.change(&changes).unwrap()[0], "continues from 4");
    run.run_for(20.ms());
    assert_eq!(counts(&log, "One.n"), [1, 2, 3, 4, 104, 204]);
    assert_eq!(counts(&log, "Two.n"), [1, 2, 3, 4, 3, 2]);
    assert_eq!(
        log.lines_with("replaced"),
        [
            "0.035 s One: replaced: \"another tally\"",
            "0.035 s Two: replaced: \"another tally\"",
        ]
    );
}

#[test]
fn c18_a_component_that_was_replaced_before_another_one_refused_is_put_back() {
    let (system, log) = tallies(Duration::ZERO);
    let mut run = system.simulate();
    run.run_for(25.ms());
    // the check before the replacement uses up the only permit
    let refused = run.change(&[replace("One", 100, 9), replace("Two", 100, 1)]);
    assert_eq!(
        refused.unwrap_err().to_string(),
        "`Two` cannot be replaced: it is not permitted any more"
    );
    run.run_for(20.ms());
    for port in ["One.n", "Two.n"] {
        assert_eq!(counts(&log, port), [1, 2, 3, 4, 5]);
    }
    let back = log.lines_with("its previous version again");
    assert_eq!(back.len(), 1, "{back:?}");
}

/// Adds what it reads to its count, which continues in a successor.
struct Sum {
    n: i64,
    input: In<Number>,
    out: Out<Number>,
    /// The count of samples, which only a successor writes.
    samples: Option<Out<Number>>,
}

impl Component for Sum {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        let all = cycle.all(self.input);
        self.n += all.iter().map(|it| it.n).sum::<i64>();
        let samples = all.len();
        cycle.write(self.out, number(self.n));
        if let Some(out) = self.samples {
            cycle.write(out, number(i64::try_from(samples).unwrap()));
        }
        Ok(())
    }

    fn take_over(&mut self, predecessor: &dyn Component, _: Time) -> Result<Vec<String>, Fault> {
        let predecessor: &dyn Any = predecessor;
        self.n = predecessor.downcast_ref::<Self>().unwrap().n;
        Ok(Vec::new())
    }
}

#[test]
fn c18_a_successor_with_ports_in_another_order_keeps_the_connections_of_each() {
    let (log, mut system) = (Log::new(), System::new());
    system.observe(log.clone());
    let periodic = || Activity::periodic(10.ms());
    system.add("Counter", periodic(), counter()).unwrap();
    let made = |interface: &mut Interface| -> Box<dyn Component> {
        let _ = interface.input::<Words>("note", "unused");
        Box::new(Sum {
            n: 0,
            input: interface.input("n", "numbers"),
            out: interface.output("sum", "their sum"),
            samples: None,
        })
    };
    system.add("Sum", periodic(), made).unwrap();
    let policy = Policy::buffer(10);
    system
        .connect("Counter.n", "Sum.n", policy.clone())
        .unwrap();
    let mut run = system.simulate();
    run.run_until(Time::ZERO + 25.ms());
    let successor = |interface: &mut Interface| -> Result<Box<dyn Component>, String> {
        let samples = Some(interface.output("samples", "read in the cycle"));
        let input = interface.input("n", "numbers");
        let _ = interface.input::<Words>("note", "unused");
        Ok(Box::new(Sum {
            n: 0,
            input,
            out: interface.output("sum", "their sum"),
            samples,
        }))
    };
    let change = Change::Replace {
        component: "Sum".to_owned(),
        by: Replacement::new("another sum", successor),
    };
    run.change(&[change]).unwrap();
    run.run_until(Time::ZERO + 45.ms());
    assert_eq!(counts(&log, "Sum.sum"), [1, 3, 6, 10, 15]);
    assert_eq!(counts(&log, "Sum.samples"), [1, 1]);
    let declared = run.declaration("Sum").unwrap();
    let inputs: Vec<_> = declared.inputs.iter().map(|it| &it.name).collect();
    let outputs: Vec<_> = declared.outputs.iter().map(|it| &it.name).collect();
    assert_eq!(inputs, ["note", "n"]);
    assert_eq!(outputs, ["sum", "samples"]);
}

#[test]
fn c18_a_component_of_another_kind_or_interface_replaces_none() {
    let (system, log) = tallies(Duration::ZERO);
    let mut run = system.simulate();
    run.run_for(25.ms());
    let refused = [
        (
            "Idler",
            "it provides other operations, which needs a new start of the process",
        ),
        ("Three", "unknown component `Three`"),
    ];
    for (component, reason) in refused {
        let changes = [gain(2.0), replace(component, 100, 9)];
        let refusal = run.change(&changes[1..]).unwrap_err().to_string();
        assert!(refusal.contains(reason), "{refusal}");
    }
    let by = Replacement::new("a counter", |interface: &mut Interface| {
        Ok(behaviour(|interface| {
            let out = interface.output::<Number>("n", "the count");
            move |cycle| {
                cycle.write(out, number(0));
                Ok(())
            }
        })(interface))
    });
    let component = "One".to_owned();
    let refusal = run
        .change(&[Change::Replace { component, by }])
        .unwrap_err();
    assert_eq!(
        refusal.to_string(),
        "`One` cannot be replaced: components of this kind cannot be replaced while they run"
    );
    run.run_for(10.ms());
    assert_eq!(counts(&log, "One.n"), [1, 2, 3, 4]);
    assert!(log.lines_with("replaced").is_empty());
}

#[test]
fn c18_a_busy_component_is_not_replaced_later() {
    let (system, log) = tallies(300.ms());
    let mut run = system.live();
    run.set_grace_period(10.ms());
    run.run_for(50.ms());
    let refusal = run.change(&[replace("One", 100, 9)]).unwrap_err();
    assert!(refusal.to_string().contains("One"), "{refusal}");
    run.set_grace_period(5.s());
    run.run_for(700.ms());
    run.stop();
    let counts = counts(&log, "One.n");
    assert!(
        counts.len() >= 2 && counts.iter().all(|n| *n < 100),
        "{counts:?}"
    );
    assert!(log.lines_with("replaced").is_empty());
}
