//! Watched properties of a specification that is replaced while it runs.

use asmotion_component::{Span, Time};
use asmotion_coordinator::{VIOLATION_REPORT, ViolationReaction, ViolationRecord};
use asmotion_runtime::{Event, Run, System};
use std::sync::{Arc, Mutex};

use crate::replacement::{Number, apply, replaced, start, status, version};

/// Adds the numbers that it receives up to a limit, which it does not know.
const BRAIN: &str = "asm brain
import StandardLibrary
import CTLLibrary
signature:
	monitored number: Integer
	controlled total: Integer
	controlled isOver: Boolean
definitions:
	CTLSPEC ag(total <= 30)
	//@Within 300 ms
	CTLSPEC ag(total > 10 implies af(isOver))
	rule r_stop = isOver := true
	main rule r_Main = if not isOver then total := total + number endif
default init s0:
	function total = 0
	function isOver = false
";

const COMPOSITE: &str = r#"
schema = "composite/1"
[composite]
name = "thinker"

[components.Counter]
implementation = { rust = "test::Counter" }
task = { period_ms = 100 }
publish = { number = "test/Number" }

[components.Brain]
implementation = { asm = "brain.asm" }
task = { period_ms = 100, delay_ms = 20 }
subscribe = { number = "test/Number" }
bind.monitored.number = { topic = "number", receive = "all", field = "n", none = 0 }
watch = { temporal = true }
"#;

const SAFE: (&str, &str) = ("{ temporal = true }", "{ safe_rule = \"r_stop[]\" }");

type Violations = Arc<Mutex<Vec<ViolationRecord>>>;

fn observed(system: &mut System) -> Violations {
    let found = Violations::default();
    let kept = Arc::clone(&found);
    system.observe(move |_, event: &Event<'_>| {
        if let Event::Report { kind, data, .. } = event
            && *kind == VIOLATION_REPORT
        {
            let record = data.to().expect("a record");
            kept.lock().expect("no panic").push(record);
        }
    });
    found
}

#[test]
fn a_property_that_both_versions_state_is_watched_on() {
    let first = version(COMPOSITE, BRAIN);
    let (mut system, _) = start(&first);
    let found = observed(&mut system);
    let mut run = system.simulate();
    // after 5 numbers the total is 15: the response is due 300 ms later
    run.run_for(600.ms());
    assert!(found.lock().expect("no panic").is_empty());
    let safe = version(&replaced(COMPOSITE, &[SAFE]), BRAIN);
    let notes = apply(&mut run, &first.1, &safe.1).expect("it continues");
    assert_eq!(notes, [""; 0]);
    run.run_for(1.s());
    let violations = found.lock().expect("no panic").clone();
    let [late] = violations.as_slice() else {
        panic!("{violations:?}");
    };
    // the time has begun in the first version
    assert_eq!(late.late_after_s, Some(0.3));
    assert_eq!(late.reaction, ViolationReaction::SafeRule);
    assert_eq!(late.step, 8);
    let brain = status(&mut run, "Brain");
    assert_eq!(brain.violated.len(), 1, "{brain:?}");
}

#[test]
fn a_property_that_is_dropped_is_named() {
    let first = version(COMPOSITE, BRAIN);
    let (mut system, _) = start(&first);
    let found = observed(&mut system);
    let mut run = system.simulate();
    run.run_for(1.s());
    assert_eq!(found.lock().expect("no panic").len(), 2);
    let dropped = [("\tCTLSPEC ag(total <= 30)\n", "")];
    let second = version(COMPOSITE, &replaced(BRAIN, &dropped));
    let notes = apply(&mut run, &first.1, &second.1).expect("it continues");
    assert_eq!(
        notes,
        ["`ag(total <= 30)` is not watched any more: the new version has no such property"]
    );
    // `watch` alone is no new start either
    let off = [("{ temporal = true }", "{ temporal = false }")];
    let third = version(&replaced(COMPOSITE, &off), &replaced(BRAIN, &dropped));
    let notes = apply(&mut run, &second.1, &third.1).expect("it continues");
    assert_eq!(notes.len(), 1, "{notes:?}");
    assert!(status(&mut run, "Brain").violated.is_empty());
}

/// Brains without anybody who sends them numbers.
const BRAINS: &str = r#"
schema = "composite/1"
[composite]
name = "brains"

[components.Brain]
for = "$r in 1..1"
implementation = { asm = "brain.asm" }
task = { period_ms = 100 }
subscribe = { number = "test/Number" }
bind.monitored.number = { topic = "number", receive = "all", field = "n", none = 0 }
"#;

#[test]
fn what_the_monitors_of_instances_know_is_frozen_after_one_is_added() {
    let first = version(BRAINS, BRAIN);
    let second = version(&replaced(BRAINS, &[("1..1", "1..2")]), BRAIN);
    let (mut system, _) = start(&first);
    let found = observed(&mut system);
    let mut run = system.simulate();
    for n in 1..=5 {
        run.inject(Time::ZERO + 1.ms(), "Brain1.number", Number { n })
            .expect("a number");
    }
    // the total of 15 is reached: the response is due 300 ms later
    run.run_for(550.ms());
    assert!(found.lock().expect("no panic").is_empty());
    apply(&mut run, &first.1, &second.1).expect("it continues");
    run.run_for(20.ms());
    let frozen = run.freeze().expect("it can be frozen");
    let mut continued = || {
        run.run_for(1.s());
        assert_eq!(status(&mut run, "Brain1").violated.len(), 1);
        assert!(status(&mut run, "Brain2").violated.is_empty());
        run.thaw(&frozen).expect("it can be thawed");
        assert!(status(&mut run, "Brain1").violated.is_empty());
        std::mem::take(&mut *found.lock().expect("no panic"))
    };
    let violations = continued();
    let first = violations.first().expect("a late response");
    // the time has begun before the instance was added
    assert_eq!((first.step, first.late_after_s), (9, Some(0.3)));
    assert_eq!(continued(), violations);
}
