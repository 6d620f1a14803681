//! Frozen systems contain everything in transit; systems with connections to the outside are rejected.

use std::sync::Arc;

use crate::common::{Double, Number, doubler, number};
use asmotion_component::{
    Activity, Component, Cycle, Fault, Freeze, FrozenState, In, Lock, OnStale, Out, Policy,
    Provided, RequestId, Required, Sharing, Span, Time, Wire, freeze_by_fields,
};
use asmotion_datum::{Datum, cbor};
use asmotion_runtime::{FrozenSystem, Log, Run, Simulation, System};

/// Publishes two consecutive numbers per cycle.
#[derive(Freeze)]
#[freeze(component = "test::Source", version = 1)]
struct Source {
    #[freeze(skip)]
    out: Out<Number>,
    n: i64,
}

impl Component for Source {
    freeze_by_fields!();

    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        for _ in 0..2 {
            self.n += 1;
            cycle.write(self.out, number(self.n));
        }
        Ok(())
    }
}

/// Adds up the numbers it reads.
#[derive(Freeze)]
#[freeze(component = "test::Adder", version = 1)]
struct Adder {
    #[freeze(skip)]
    input: In<Number>,
    #[freeze(skip)]
    out: Out<Number>,
    sum: i64,
}

impl Component for Adder {
    freeze_by_fields!();

    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        self.sum += cycle.all(self.input).iter().map(|it| it.n).sum::<i64>();
        // includes earlier and stale samples and their time
        let newest = cycle.read(self.input).any().map_or(0, |it| it.n);
        let stale = i64::from(cycle.is_stale(self.input));
        let age = cycle.written_at(self.input).map_or(0, Time::nanos);
        cycle.write(self.out, number(self.sum * 1000 + newest + stale + age));
        Ok(())
    }
}

/// Makes a call in every cycle and cancels every third.
#[derive(Freeze)]
#[freeze(component = "test::Caller", version = 1)]
struct Caller {
    #[freeze(skip)]
    double: Required<Double>,
    n: i64,
}

impl Component for Caller {
    freeze_by_fields!();

    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        for reply in cycle.replies(self.double) {
            let heard = reply.result.map_or(-1, |it| it.n);
            cycle.report("heard", heard.into());
        }
        self.n += 1;
        let call = cycle.call(self.double, number(self.n));
        if self.n % 3 == 0 {
            cycle.cancel(call);
        }
        Ok(())
    }
}

/// Replies to one request per cycle, newest first.
#[derive(Freeze)]
#[freeze(component = "test::SlowDoubler", version = 1)]
struct SlowDoubler {
    #[freeze(skip)]
    double: Provided<Double>,
    open: Vec<(RequestId, i64)>,
}

impl Component for SlowDoubler {
    freeze_by_fields!();

    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        let gone = cycle.cancelled(self.double).to_vec();
        self.open.retain(|(id, _)| !gone.contains(id));
        let requests = cycle.requests(self.double).into_iter();
        self.open
            .extend(requests.map(|request| (request.id, request.argument.n)));
        if let Some((id, n)) = self.open.pop() {
            cycle.reply(self.double, id, Ok(number(2 * n)));
        }
        Ok(())
    }
}

/// Creates two sources with a common reader over connections of this policy, and calls with retries.
fn system(policy: &Policy, log: &Log) -> Simulation {
    let mut system = System::new();
    system.observe(log.clone());
    for name in ["One", "Other"] {
        system
            .add(name, Activity::periodic(10.ms()), |interface| {
                let out = interface.output("n", "the count");
                Box::new(Source { out, n: 0 })
            })
            .unwrap();
    }
    system
        .add("Adder", Activity::periodic(35.ms()), |interface| {
            let (input, out) = (interface.input("n", "in"), interface.output("sum", "out"));
            Box::new(Adder { input, out, sum: 0 })
        })
        .unwrap();
    system
        .add("Caller", Activity::periodic(15.ms()), |interface| {
            let double = interface.require("sums", "to double");
            Box::new(Caller { double, n: 0 })
        })
        .unwrap();
    system
        .add("Doubler", Activity::periodic(25.ms()), |interface| {
            let double = interface.serve("sums", "doubles");
            let open = Vec::new();
            Box::new(SlowDoubler { double, open })
        })
        .unwrap();
    for from in ["One.n", "Other.n"] {
        system.connect(from, "Adder.n", policy.clone()).unwrap();
    }
    let wire = Wire {
        backoff: 7.ms(),
        ..Wire::timeout(40.ms()).retries(2)
    };
    system.wire("Caller.sums", "Doubler.sums", wire).unwrap();
    let mut run = system.simulate();
    let sample = Arc::new(number(1_000_000));
    run.inject_sample(Time::ZERO + 210.ms(), "Adder.n", sample)
        .unwrap();
    run
}

fn policies() -> Vec<Policy> {
    vec![
        Policy::data(),
        Policy::buffer(3),
        Policy::circular(3),
        Policy::data().lock(Lock::Locked),
        Policy::buffer(3).lock(Lock::Locked),
        Policy::data().pull(),
        Policy::buffer(9).pull(),
        Policy::buffer(5).sharing(Sharing::PerInput),
        Policy::circular(5).shared("common"),
        Policy::data().max_age(2.ms()).on_stale(OnStale::Zero),
        Policy::buffer(5).max_age(2.ms()).on_stale(OnStale::NoData),
    ]
}

const END: Time = Time::from_nanos(400_000_000);

#[test]
fn everything_on_its_way_goes_on_after_any_step_and_with_any_policy() {
    for policy in policies() {
        let whole = Log::new();
        system(&policy, &whole).run_until(END);
        for steps in (0..120).step_by(7) {
            let log = Log::new();
            let mut run = system(&policy, &log);
            for _ in 0..steps {
                run.step();
            }
            let frozen = run.freeze().unwrap();
            assert_eq!(run.freeze().unwrap(), frozen);
            let mut other = system(&policy, &Log::new());
            other.run_until(Time::ZERO + 33.ms());
            other.thaw(&frozen).unwrap();
            assert_eq!(other.freeze().unwrap(), frozen, "{policy:?} {steps}");
            other.observe(log.clone());
            other.run_until(END);
            assert_eq!(log.lines(), whole.lines(), "{policy:?} {steps}");
        }
    }
}

#[test]
fn a_system_with_another_policy_is_another_one() {
    let mut run = system(&Policy::buffer(3), &Log::new());
    let frozen = run.freeze().unwrap();
    let mut other = system(&Policy::buffer(4), &Log::new());
    assert_eq!(
        other.thaw(&frozen).unwrap_err().to_string(),
        "the frozen state belongs to another system: `Adder` is declared or connected differently"
    );
}

#[test]
fn bytes_that_are_no_system_are_refused() {
    let mut run = system(&Policy::data(), &Log::new());
    for bytes in [
        &b""[..],
        b"{}",
        b"\xa0",
        b"\x9f",
        b"\xbb\x7f\xff\xff\xff\xff\xff\xff\xff",
    ] {
        let refused = run.thaw(&FrozenSystem::from_bytes(bytes)).unwrap_err();
        let text = refused.to_string();
        assert!(text.starts_with("not a frozen system: "), "{text}");
    }
}

fn refusal(run: &mut Simulation) -> String {
    run.freeze().unwrap_err().to_string()
}

#[test]
fn a_component_that_does_not_freeze_refuses_for_the_system() {
    let mut system = System::new();
    system.add("Doubler", Activity::event(), doubler()).unwrap();
    let refusal = refusal(&mut system.simulate());
    assert!(
        refusal.starts_with("`Doubler`: ") && refusal.contains("does not implement"),
        "{refusal}"
    );
}

#[test]
fn what_leads_out_of_the_system_is_refused_by_name() {
    let fresh = || system(&Policy::data(), &Log::new());

    let mut run = fresh();
    let reader = run.reader::<Number>("Adder.sum", Policy::data()).unwrap();
    assert_eq!(
        refusal(&mut run),
        "`Adder.sum` writes to a reader outside, which is outside the system and cannot be frozen with it"
    );
    drop(reader);

    let mut run = fresh();
    let writer = run.writer::<Number>("Adder.n", Policy::data()).unwrap();
    assert!(refusal(&mut run).contains("into an input of `Adder` has a writer on another thread"));
    drop(writer);

    let mut run = fresh();
    let sent = run
        .send::<Double>("Doubler.sums", number(4), 1.s())
        .unwrap();
    assert!(refusal(&mut run).starts_with("a caller waits for an answer of `sums`"));
    assert_eq!(run.collect(sent), Ok(number(8)));
    // once the reply has arrived, nothing refers to the outside
    run.freeze().unwrap();
}

#[test]
fn a_failed_component_stays_failed() {
    let start = || {
        let mut system = System::new();
        system
            .add("Failing", Activity::periodic(10.ms()), |_| {
                Box::new(Failing { cycles: 0 })
            })
            .unwrap();
        system.simulate()
    };
    let mut run = start();
    run.run_for(1.s());
    let frozen = run.freeze().unwrap();
    let mut other = start();
    other.thaw(&frozen).unwrap();
    assert_eq!(other.fault("Failing"), Some(Fault::new("broken")));
    assert_eq!(other.state("Failing"), run.state("Failing"));
    other.run_for(1.s());
    assert_eq!(other.cycles("Failing"), 5);
}

/// Fails in its fifth cycle.
#[derive(Freeze)]
#[freeze(component = "test::Failing", version = 1)]
struct Failing {
    cycles: u32,
}

impl Component for Failing {
    freeze_by_fields!();

    fn update(&mut self, _: &mut Cycle<'_>) -> Result<(), Fault> {
        self.cycles += 1;
        match self.cycles {
            5 => Err(Fault::new("broken")),
            _ => Ok(()),
        }
    }
}

/// Cycles at growing intervals, at times that it requests itself.
#[derive(Freeze)]
#[freeze(component = "test::Sleeper", version = 1)]
struct Sleeper {
    #[freeze(skip)]
    out: Out<Number>,
    n: i64,
}

impl Component for Sleeper {
    freeze_by_fields!();

    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        self.n += 1;
        cycle.write(self.out, number(self.n));
        cycle.request_cycle_at(cycle.now() + (self.n.unsigned_abs() * 10).ms());
        Ok(())
    }
}

#[test]
fn a_requested_cycle_takes_place_after_thawing() {
    let sleeper = |log: &Log| {
        let mut system = System::new();
        system.observe(log.clone());
        system
            .add("Sleeper", Activity::event(), |interface| {
                let out = interface.output("n", "the count");
                Box::new(Sleeper { out, n: 0 })
            })
            .unwrap();
        system.simulate()
    };
    let whole = Log::new();
    sleeper(&whole).run_until(END);
    assert_eq!(whole.samples::<Number>("Sleeper.n").len(), 9);
    let log = Log::new();
    let mut run = sleeper(&log);
    run.run_until(Time::ZERO + 125.ms());
    let frozen = run.freeze().unwrap();
    let mut other = sleeper(&Log::new());
    other.thaw(&frozen).unwrap();
    assert_eq!(other.freeze().unwrap(), frozen);
    other.observe(log.clone());
    other.run_until(END);
    assert_eq!(log.lines(), whole.lines());
}

#[test]
fn a_frozen_state_names_its_component_and_version_and_has_the_bytes_of_its_fields() {
    let fields = std::collections::BTreeMap::from([("count", 3)]);
    let state = FrozenState::of("test::Counter", 7, &fields).unwrap();
    assert_eq!(state.component(), "test::Counter");
    assert_eq!(state.version(), 7);
    assert_eq!(state.as_bytes(), cbor::encode(&fields).unwrap());
    assert_eq!(state.to_datum().unwrap(), Datum::of(&fields).unwrap());
    let read = state.read::<Datum>("test::Counter", 7).unwrap();
    assert_eq!(read, Datum::of(&fields).unwrap());
    let other = state.read::<Datum>("test::Adder", 7).unwrap_err();
    assert!(other.to_string().contains("test::Counter"), "{other}");
    let newer = state.read::<Datum>("test::Counter", 8).unwrap_err();
    assert!(newer.to_string().contains('7'), "{newer}");
    let debug = format!("{state:?}");
    assert!(debug.contains("test::Counter"), "{debug}");
}

#[test]
fn a_component_without_a_frozen_state_is_neither_frozen_nor_thawed() {
    struct Silent;
    impl Component for Silent {
        fn update(&mut self, _: &mut Cycle<'_>) -> Result<(), Fault> {
            Ok(())
        }
    }
    assert!(Silent.freeze().is_err());
    let state = FrozenState::of("test::Silent", 1, &()).unwrap();
    assert!(Silent.thaw(&state).is_err());
}
