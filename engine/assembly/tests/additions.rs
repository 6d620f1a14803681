//! Components that are added to a running system and removed from it, with their topics, services and connections (C18).

use std::sync::Arc;

use asmotion_assembly::reconfigure::{Version, changes};
use asmotion_assembly::{Assembled, CoordinatorOptions, Standard};
use asmotion_bus::{
    Bus, LocalBus, Notifier, Overflow, Pattern, Payload, PublishOptions, QueuePolicy, SenderId,
    Subscription,
};
use asmotion_component::Span;
use asmotion_datum::{Datum, Message};
use asmotion_plan::{Part, Plan};
use asmotion_runtime::{Log, Run};

use crate::replacement::{
    BRAIN, BUILD, COMPOSITE, Number, apply, replaced, said, start, status, version,
};

/// The composite without its specification.
fn without_brain() -> String {
    let (before, rest) = COMPOSITE.split_once("[components.Brain]").expect("a brain");
    let (_, after) = rest.split_once("[components.Echo]").expect("an echo");
    let (after, _) = after.split_once("[[wires]]").expect("a wire");
    format!("{before}[components.Echo]{after}")
}

#[test]
fn c18_a_specification_is_added_with_its_topics_and_wires_and_removed() {
    let first = version(&without_brain(), BRAIN);
    let brain = replaced(BRAIN, &[("number = 1 then", "number = 6 then")]);
    let (_, with_brain) = version(COMPOSITE, &brain);
    let (system, log) = start(&first);
    let mut run = system.simulate();
    run.run_for(450.ms());
    apply(&mut run, &first.1, &with_brain).expect("added");
    run.run_for(1.s());
    assert_eq!(run.components(), ["Counter", "Slow", "Echo", "Brain"]);
    let sums = [6, 6 + 7, 6 + 7 + 8, 6 + 7 + 8 + 9];
    assert_eq!(said(&log)[..4], sums, "of what it has received");
    assert_eq!(status(&mut run, "Brain").calls, ["sums.double"]);
    run.run_for(1.s());
    assert!(status(&mut run, "Brain").calls.is_empty());
    let replies = log.lines_with("sums.double").into_iter();
    let replied: Vec<_> = replies.filter(|line| line.contains("8")).collect();
    assert!(!replied.is_empty(), "{:?}", log.lines_with("sums.double"));
    apply(&mut run, &with_brain, &first.1).expect("removed");
    assert_eq!(run.components(), ["Counter", "Slow", "Echo"]);
    let before = said(&log).len();
    run.run_for(1.s());
    assert_eq!(said(&log).len(), before);
    apply(&mut run, &first.1, &with_brain).expect("added again");
    run.run_for(1.s());
    assert_eq!(said(&log).len(), before + 9);
    let again = status(&mut run, "Brain");
    assert_eq!(again.step, 10, "it begins anew");
    assert!(log.lines_with("dropped").is_empty());
}

/// The composite without its specification and the service that it calls.
fn without_brain_and_slow() -> String {
    let without = without_brain();
    let (before, rest) = without.split_once("[components.Slow]").expect("a service");
    let (_, after) = rest.split_once("[components.Echo]").expect("an echo");
    format!("{before}[components.Echo]{after}")
}

/// A version whose part is chosen by its plan.
pub(crate) fn deployed(version: &Version, part: fn(&Plan) -> Part) -> Version {
    let mut version = version.clone();
    version.part = part(&version.plan);
    version
}

#[test]
fn c18_a_slave_is_neither_added_nor_removed() {
    let slave = "\n[components.Late]\nimplementation = { rust = \"test::Echo\" }\n\
                 activity = { master = \"Counter\" }\n";
    let (files, first) = version(&without_brain(), BRAIN);
    let (_, next) = version(&(COMPOSITE.to_owned() + slave), BRAIN);
    let (first, next) = (
        deployed(&first, Part::with_brokers),
        deployed(&next, Part::with_brokers),
    );
    let (system, _) = start(&(files, first.clone()));
    let fixed = changes(&first, &next, &system.simulate()).expect_err("a new start is needed");
    let fixed: Vec<_> = fixed.iter().map(ToString::to_string).collect();
    assert_eq!(
        fixed,
        ["`Late` is new and runs in the thread of `Counter`; without `master` it can be added"]
    );
}

/// All messages of a topic of the bus.
pub(crate) fn heard(bus: &LocalBus, topic: &str) -> Subscription {
    let queue = QueuePolicy::All {
        size: 256,
        overflow: Overflow::DropOldest,
    };
    let pattern = Pattern::new(topic);
    let subscribed = bus.subscribe("Tester", &pattern, queue, Arc::new(Notifier::new()));
    subscribed.expect("a subscription")
}

/// Runs until a condition holds.
pub(crate) fn until(run: &mut dyn Run, mut holds: impl FnMut(&mut dyn Run) -> bool) {
    let limit = run.now() + 30.s();
    while !holds(run) {
        assert!(run.now() < limit, "it does not hold");
        run.run_for(50.ms());
    }
}

/// Topics and services use an embedded bus. Components are added with theirs, removed and added again; nothing stays on the bus.
fn comes_and_goes(part: fn(&Plan) -> Part, is_live: bool) {
    let bus = LocalBus::new();
    let (files, none) = version(&without_brain_and_slow(), BRAIN);
    let brain = replaced(BRAIN, &[("number = 1 then", "total = 0 then")]);
    let (none, all) = (
        deployed(&none, part),
        deployed(&version(COMPOSITE, &brain).1, part),
    );
    let mut workshop = Standard::new(&BUILD, &files, CoordinatorOptions::seeded(1));
    let assembled = asmotion_assembly::start_part(&none.plan, &none.part, &mut workshop);
    let Assembled {
        mut system,
        mut network,
    } = assembled.expect("a system");
    let log = Log::new();
    system.observe(log.clone());
    let attached = network.attach(&mut system, Arc::new(bus.clone()), 1);
    attached.expect("a bus");
    let all = all.on_buses(network.running());
    let none = none.on_buses(network.running());
    drop(network);
    let mut run: Box<dyn Run> = if is_live {
        Box::new(system.live())
    } else {
        Box::new(system.simulate())
    };
    let run = &mut *run;
    run.run_for(450.ms());
    let sums = heard(&bus, "sums");
    let at_first = format!("{bus:?}");
    let served = || {
        let notifier = Arc::new(Notifier::new());
        bus.serve("Slow.sums.double", 4, notifier).is_err()
    };
    let origin = SenderId::new("Stranger", 99);
    let mut stranger = bus
        .publisher(
            "number",
            &origin,
            Number::schema(),
            PublishOptions::default(),
        )
        .expect("a publisher");
    let answers = || {
        let lines = log.lines_with("Brain.sums.double call").into_iter();
        lines
            .filter(|it| it.contains("ends: ") && it.contains('8'))
            .count()
    };
    for round in 1..=2 {
        apply(run, &none, &all).expect("added");
        assert_eq!(run.components(), ["Counter", "Echo", "Slow", "Brain"]);
        assert!(served());
        let before = said(&log).len();
        until(run, |_| said(&log).len() >= before + 4);
        let received: Vec<_> = std::iter::from_fn(|| sums.try_next()).collect();
        assert!(received.len() >= 4, "{}", received.len());
        assert!(received.iter().all(|it| &*it.source == "Brain"));
        let number = Payload::of(Datum::of(&Number { n: 7000 }).expect("a datum"));
        stranger.publish(0, number).expect("published");
        until(run, |_| {
            said(&log).iter().skip(before).any(|sum| *sum >= 7000)
        });
        until(run, |_| answers() == round);
        apply(run, &all, &none).expect("removed");
        run.run_for(50.ms());
        assert_eq!(run.components(), ["Counter", "Echo"]);
        assert!(!served());
        assert_eq!(format!("{bus:?}"), at_first, "no subscription is left");
        while sums.try_next().is_some() {}
        let before = said(&log).len();
        run.run_for(500.ms());
        assert!(sums.try_next().is_none());
        assert_eq!(said(&log).len(), before);
    }
    assert!(
        log.lines_with("dropped").is_empty(),
        "{:?}",
        log.lines_with("dropped")
    );
    run.stop();
}

#[test]
fn c18_components_on_an_embedded_bus_are_added_and_removed_with_their_topics_and_services() {
    comes_and_goes(|_| Part::WholeOverBus, false);
    comes_and_goes(Part::with_brokers, false);
    comes_and_goes(Part::with_brokers, true);
}

#[test]
fn c18_an_address_that_another_process_serves_refuses_a_new_provider_and_changes_nothing() {
    let bus = LocalBus::new();
    let (files, none) = version(&without_brain_and_slow(), BRAIN);
    let all = deployed(&version(COMPOSITE, BRAIN).1, Part::with_brokers);
    let none = deployed(&none, Part::with_brokers);
    let mut workshop = Standard::new(&BUILD, &files, CoordinatorOptions::seeded(1));
    let assembled = asmotion_assembly::start_part(&none.plan, &none.part, &mut workshop);
    let Assembled {
        mut system,
        mut network,
    } = assembled.expect("a system");
    let attached = network.attach(&mut system, Arc::new(bus.clone()), 1);
    attached.expect("a bus");
    let all = all.on_buses(network.running());
    let mut run = system.simulate();
    let at_first = format!("{bus:?}");
    let taken = bus.serve("Slow.sums.double", 4, Arc::new(Notifier::new()));
    let planned = changes(&none, &all, &run).expect("changes");
    let refused = run.change(&planned).expect_err("it is taken");
    assert_eq!(
        refused.to_string(),
        "`Slow` cannot be added: `Slow.sums.double` is already served"
    );
    assert_eq!(run.components(), ["Counter", "Echo"]);
    assert_eq!(format!("{bus:?}"), at_first);
    drop(taken);
    run.change(&planned).expect("it is free");
    run.run_for(500.ms());
    assert_eq!(run.components(), ["Counter", "Echo", "Slow", "Brain"]);
}

/// Two components of two processes, without a connection.
const APART: &str = r#"
schema = "composite/1"
[composite]
name = "apart"
[components.Counter]
implementation = { rust = "test::Counter" }
task = { period_ms = 100 }
[components.Echo]
implementation = { rust = "test::Echo" }
"#;

/// A connection of them.
const ACROSS: &str = r#"
[[connections]]
from = "Counter.number"
to = "Echo.heard"
policy = { type = "buffer", size = 64 }
"#;

#[test]
fn c18_a_connection_of_components_of_two_processes_is_added_and_removed() {
    let bus = LocalBus::new();
    let (files, apart) = version(APART, BRAIN);
    let versions = [
        apart,
        version(&format!("{APART}{ACROSS}"), BRAIN).1,
        version(&format!("{APART}{}", ACROSS.replace("64", "32")), BRAIN).1,
        version(&format!("{APART}{}", ACROSS.replace("64", "6400")), BRAIN).1,
    ];
    let part = |component: &str| Part::Components([component.to_owned()].into());
    let start = |incarnation: u64, component: &str| {
        let mut workshop = Standard::new(&BUILD, &files, CoordinatorOptions::seeded(1));
        let assembled =
            asmotion_assembly::start_part(&versions[0].plan, &part(component), &mut workshop);
        let Assembled {
            mut system,
            mut network,
        } = assembled.expect("a system");
        let log = Log::new();
        system.observe(log.clone());
        let attached = network.attach(&mut system, Arc::new(bus.clone()), incarnation);
        attached.expect("a bus");
        let versions = versions.clone().map(|mut it| {
            it.part = part(component);
            it.on_buses(network.running())
        });
        (system.simulate(), log, versions)
    };
    let (mut here, _, of_counter) = start(1, "Counter");
    let (mut there, log, of_echo) = start(2, "Echo");
    let at_first = format!("{bus:?}");
    let run_both = |here: &mut dyn Run, there: &mut dyn Run| {
        for _ in 0..10 {
            here.run_for(100.ms());
            there.run_for(100.ms());
        }
        said(&log).len()
    };
    assert_eq!(run_both(&mut here, &mut there), 0);
    for round in 1..=2 {
        let listed = |from: &Version, to: &Version, run: &dyn Run| -> Vec<String> {
            let changes = changes(from, to, run).expect("no new start is needed");
            changes.iter().map(ToString::to_string).collect()
        };
        assert_eq!(
            listed(&of_counter[0], &of_counter[1], &here),
            ["`Counter.number` is sent to bus topic port.Counter.number"]
        );
        assert_eq!(
            listed(&of_echo[1], &of_echo[0], &there),
            ["`Echo.heard` no longer receives bus topic port.Counter.number"]
        );
        apply(&mut there, &of_echo[0], &of_echo[1]).expect("connected");
        apply(&mut here, &of_counter[0], &of_counter[1]).expect("connected");
        assert_eq!(run_both(&mut here, &mut there), 20 * round - 10);
        // a queue of another length at the bus is not replaced without loss
        let fixed = changes(&of_echo[1], &of_echo[3], &there).expect_err("a new start is needed");
        let reason = "the connection from `Counter.number` to `Echo.heard` needs another queue at the broker: remove it, and add \
                      it with its new policy in a second step";
        assert_eq!(fixed[0].to_string(), reason);
        // the same queue at the bus passes its messages on, none twice
        apply(&mut there, &of_echo[1], &of_echo[2]).expect("another policy");
        apply(&mut here, &of_counter[1], &of_counter[2]).expect("another policy");
        assert_eq!(run_both(&mut here, &mut there), 20 * round);
        let heard = said(&log);
        let last = &heard[heard.len() - 20..];
        assert!(last.windows(2).all(|it| it[1] == it[0] + 1), "{last:?}");
        apply(&mut here, &of_counter[2], &of_counter[0]).expect("disconnected");
        apply(&mut there, &of_echo[2], &of_echo[0]).expect("disconnected");
        assert_eq!(run_both(&mut here, &mut there), 20 * round);
        assert_eq!(format!("{bus:?}"), at_first);
    }
}
