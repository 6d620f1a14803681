//! Topics of components that stay while the system is reconfigured (C18): a specification is bound to further topics, and continues
//! in its state.

use std::sync::Arc;

use asmotion_assembly::reconfigure::{Version, changes};
use asmotion_assembly::{Assembled, CoordinatorOptions, Standard};
use asmotion_bus::{Bus, LocalBus, Payload, PublishOptions, SenderId};
use asmotion_component::Span;
use asmotion_datum::{Datum, Message};
use asmotion_plan::{Part, Plan};
use asmotion_runtime::{Log, Run};

use crate::additions::{deployed, heard, until};
use crate::replacement::{
    BRAIN, BUILD, COMPOSITE, Number, apply, replaced, said, start, status, version,
};

/// A second counter, whose topic nobody reads.
const LIMITER: (&str, &str) = (
    "[components.Slow]",
    "[components.Limiter]\nimplementation = { rust = \"test::Counter\" }\ntask = { period_ms = 100 }\n\
     ports.out = { number = \"test/Number\" }\n\n[[connections]]\nfrom = \"Limiter.number\"\n\
     to = \"topic:limit\"\n\n[components.Slow]",
);

/// The specification reads that topic and publishes on a new one, which a component that stays reads, too.
const LIMITED: &[(&str, &str)] = &[
    (
        "subscribe = { number = \"test/Number\" }",
        "subscribe = { limit = \"test/Number\", number = \"test/Number\" }",
    ),
    (
        "publish = { sums = \"test/Number\" }",
        "publish = { bounds = \"test/Number\", sums = \"test/Number\" }",
    ),
    (
        "bind.out.sum =",
        "bind.monitored.limit = { topic = \"limit\", receive = \"all\", field = \"n\", none = 0 }\n\
         bind.out.bound = { topic = \"bounds\", field = \"n\" }\nbind.out.sum =",
    ),
    (
        "[[wires]]",
        "[[connections]]\nfrom = \"topic:bounds\"\nto = \"Echo.heard\"\n\
         policy = { type = \"buffer\", size = 64 }\n\n[[wires]]",
    ),
];

const BOUNDED: &[(&str, &str)] = &[
    (
        "\tmonitored ev: Ev\n",
        "\tmonitored ev: Ev\n\tmonitored limit: Integer\n",
    ),
    (
        "\tout sum: Integer\n",
        "\tout sum: Integer\n\tout bound: Integer\n",
    ),
    (
        "\t\t\tif ev = ANSWER",
        "\t\t\tif limit > 0 then bound := 1000000 + limit endif\n\t\t\tif ev = ANSWER",
    ),
];

/// The composite with the second counter, and the same with a specification that uses its topic.
fn versions() -> (String, String) {
    let first = replaced(COMPOSITE, &[LIMITER]);
    let second = replaced(&first, LIMITED);
    (first, second)
}

/// The bounds among the numbers that the echo has heard.
fn bounds(log: &Log) -> Vec<i64> {
    let numbers = said(log).into_iter().filter(|it| *it > 1_000_000);
    numbers.map(|it| it - 1_000_000).collect()
}

/// Checks that no message is lost, except those that a version left unread.
fn is_nothing_dropped(log: &Log) {
    let dropped = log.lines_with("dropped").into_iter();
    // the notes of a replacement, and the losses that it counts
    let is_noted = |it: &String| it.contains(": notice: ") || it.contains("asm/Losses");
    let dropped: Vec<_> = dropped.filter(|it| !is_noted(it)).collect();
    assert!(dropped.is_empty(), "{dropped:?}");
}

#[test]
fn c18_a_specification_is_bound_to_further_topics_and_continues_in_its_state() {
    let (first, second) = versions();
    let first = version(&first, BRAIN);
    let (_, second) = version(&second, &replaced(BRAIN, BOUNDED));
    let (system, log) = start(&first);
    let mut run = system.simulate();
    // until the call has ended: other out functions end it
    run.run_for(2050.ms());
    let planned = changes(&first.1, &second, &run).expect("no new start is needed");
    let words: Vec<_> = planned.iter().map(ToString::to_string).collect();
    assert_eq!(
        words,
        [
            "`Brain` runs another version of `brain.asm`",
            "`Brain.bounds` is published on topic `bounds`",
            "`Brain.limit` subscribes to topic `limit`",
            "`Echo.heard` subscribes to topic `bounds`"
        ]
    );
    apply(&mut run, &first.1, &second).expect("it continues");
    run.run_for(1.s());
    assert_eq!(status(&mut run, "Brain").step, 31, "steps are counted on");
    assert_eq!(bounds(&log), Vec::from_iter(22..=31));
    let sums: Vec<_> = said(&log)
        .into_iter()
        .filter(|it| *it < 1_000_000)
        .collect();
    assert_eq!(sums.last(), Some(&(1..=31).sum()), "{sums:?}");
    // what a tool writes to the new input arrives, too
    let number = Arc::new(Datum::of(&Number { n: 500 }).expect("a datum"));
    let now = run.now();
    run.inject_sample(now, "Brain.limit", number)
        .expect("an input");
    run.run_for(100.ms());
    assert!(bounds(&log).contains(&500), "{:?}", bounds(&log));
    // and back: the ports stay, without a use
    apply(&mut run, &second, &first.1).expect("it continues");
    let before = bounds(&log).len();
    run.run_for(1.s());
    assert_eq!(bounds(&log).len(), before);
    assert_eq!(status(&mut run, "Brain").step, 42);
    let declared = run.declaration("Brain").expect("a component");
    assert!(declared.input("limit").is_some() && declared.output("bounds").is_some());
    // once more, with the ports of before
    apply(&mut run, &first.1, &second).expect("it continues");
    run.run_for(1.s());
    assert_eq!(bounds(&log).len(), before + 10);
    is_nothing_dropped(&log);
}

#[test]
fn c18_a_version_with_further_topics_that_does_not_fit_the_state_changes_nothing() {
    let (first, second) = versions();
    let first = version(&first, BRAIN);
    let broken = [(
        "default init",
        "\tinvariant over total: total < 10\ndefault init",
    )];
    let wrong = replaced(&replaced(BRAIN, BOUNDED), &broken);
    let (_, wrong) = version(&second, &wrong);
    let (_, second) = version(&second, &replaced(BRAIN, BOUNDED));
    let (system, log) = start(&first);
    let mut run = system.simulate();
    run.run_for(1050.ms());
    let refusal = apply(&mut run, &first.1, &wrong).expect_err("an invariant does not hold");
    assert!(refusal.contains("`Brain` cannot be replaced"), "{refusal}");
    run.run_for(500.ms());
    let declared = run.declaration("Brain").expect("a component");
    assert!(declared.input("limit").is_none(), "no port is left");
    assert!(bounds(&log).is_empty());
    // the refused version leaves nothing in the way of the next one
    apply(&mut run, &first.1, &second).expect("it continues");
    run.run_for(500.ms());
    assert_eq!(bounds(&log).len(), 5);
}

/// The same over a bus, to which further readers and writers are connected.
fn is_bound(part: fn(&Plan) -> Part, is_live: bool) {
    let bus = LocalBus::new();
    let (first, second) = versions();
    let (files, first) = version(&first, BRAIN);
    let (_, second) = version(&second, &replaced(BRAIN, BOUNDED));
    let (first, second) = (deployed(&first, part), deployed(&second, part));
    let mut workshop = Standard::new(&BUILD, &files, CoordinatorOptions::seeded(1));
    let assembled = asmotion_assembly::start_part(&first.plan, &first.part, &mut workshop);
    let Assembled {
        mut system,
        mut network,
    } = assembled.expect("a system");
    let log = Log::new();
    system.observe(log.clone());
    let attached = network.attach(&mut system, Arc::new(bus.clone()), 1);
    attached.expect("a bus");
    let joined = |version: Version| version.on_buses(network.running());
    let (first, second) = (joined(first), joined(second));
    drop(network);
    let mut run: Box<dyn Run> = if is_live {
        Box::new(system.live())
    } else {
        Box::new(system.simulate())
    };
    let run = &mut *run;
    // until the call has ended: other out functions end it
    run.run_for(2.s());
    let received = heard(&bus, "bounds");
    let at_first = format!("{bus:?}");
    let origin = SenderId::new("Stranger", 99);
    let options = PublishOptions::default();
    let stranger = bus.publisher("limit", &origin, Number::schema(), options);
    let mut stranger = stranger.expect("a publisher");
    for _ in 1..=2 {
        let step = status(run, "Brain").step;
        apply(run, &first, &second).expect("it continues");
        let before = bounds(&log).len();
        until(run, |_| bounds(&log).len() >= before + 4);
        assert!(status(run, "Brain").step >= step);
        let number = Payload::of(Datum::of(&Number { n: 7000 }).expect("a datum"));
        stranger.publish(0, number).expect("published");
        until(run, |_| bounds(&log)[before..].contains(&7000));
        let messages: Vec<_> = std::iter::from_fn(|| received.try_next()).collect();
        assert!(messages.len() >= 4, "{}", messages.len());
        assert!(messages.iter().all(|it| &*it.source == "Brain"));
        apply(run, &second, &first).expect("it continues");
        run.run_for(50.ms());
        assert_eq!(format!("{bus:?}"), at_first, "no subscription is left");
        while received.try_next().is_some() {}
        let before = bounds(&log).len();
        run.run_for(500.ms());
        assert!(received.try_next().is_none());
        assert_eq!(bounds(&log).len(), before);
    }
    is_nothing_dropped(&log);
    run.stop();
}

#[test]
fn c18_a_specification_is_bound_to_further_topics_of_an_embedded_bus() {
    is_bound(|_| Part::WholeOverBus, false);
    is_bound(Part::with_brokers, false);
    is_bound(Part::with_brokers, true);
}
