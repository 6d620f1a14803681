//! Calls and timers of a specification while the system is changed (C18): no outcome is lost, and no timer that is removed ends.

use asmotion_assembly::reconfigure::Version;
use asmotion_component::{Span, Time};
use asmotion_lang::MemoryFiles;
use asmotion_runtime::{Log, Run};

use crate::replacement::{apply, replaced, start, status, version};

/// Asks for a number at once and counts what it learns of its calls: in each step at most one event.
const ASKER: &str = "asm asker
import StandardLibrary
signature:
	enum domain Action = {NOACT | ASK}
	enum domain Ev = {NOEV | ANSWER | FAILED | GONE}
	enum domain Mode = {WAITING | LATE}
	enum domain Count = {C0 | C1 | C2 | C3}
	derived next: Count -> Count
	monitored ev: Ev
	monitored late: Boolean
	controlled mode: Mode
	controlled asked: Boolean
	controlled answers: Count
	controlled gone: Count
	controlled failures: Count
	out first: Action
	out second: Action
	out third: Action
definitions:
	function next($c in Count) = if $c = C0 then C1 else if $c = C1 then C2 else C3 endif endif
	main rule r_Main =
		par
			if not asked then par asked := true first := ASK second := ASK third := ASK endpar endif
			if ev = ANSWER then answers := next(answers) endif
			if ev = GONE then gone := next(gone) endif
			if ev = FAILED then failures := next(failures) endif
			if late then mode := LATE endif
		endpar
default init s0:
	function mode = WAITING
	function asked = false
	function answers = C0
	function gone = C0
	function failures = C0
	function first = NOACT
	function second = NOACT
	function third = NOACT
";

/// `Slow` and `Spare` reply after a second.
const COMPOSITE: &str = r#"
schema = "composite/1"
[composite]
name = "asker"

[components.Slow]
implementation = { rust = "test::Slow" }
task = { period_ms = 50 }

[components.Spare]
implementation = { rust = "test::Slow" }
task = { period_ms = 50 }

[components.Asker]
implementation = { asm = "brain.asm" }
task = { period_ms = 100, delay_ms = 20 }
references = { sums = "test/Arithmetic" }
bind.monitored.late = { timer = "asked", ms = 1500 }

[components.Asker.bind.out]
first.ASK = { call = "sums.double", with = { n = 1 }, ok = "ANSWER", unavailable = "GONE", failed = "FAILED", event = "ev" }
second.ASK = { call = "sums.double", with = { n = 2 }, ok = "ANSWER", unavailable = "GONE", failed = "FAILED", event = "ev" }
third.ASK = { call = "sums.double", with = { n = 3 }, ok = "ANSWER", unavailable = "GONE", failed = "FAILED", event = "ev" }

[[wires]]
reference = "Asker.sums"
service = "Slow.sums"
timeout_ms = 5000
"#;

const TIMER: &str = "bind.monitored.late = { timer = \"asked\", ms = 1500 }";
const WIRE: &str = "service = \"Slow.sums\"";

/// The composite without `Slow`, whose calls `Spare` takes.
fn without_slow() -> String {
    let slow = "[components.Slow]\nimplementation = { rust = \"test::Slow\" }\ntask = { period_ms = 50 }\n";
    replaced(COMPOSITE, &[(slow, ""), (WIRE, "service = \"Spare.sums\"")])
}

fn at(ms: u64) -> Time {
    Time::ZERO + ms.ms()
}

/// The values of the asker: its mode, and the numbers of answers, of calls without a provider, and of other failures.
fn learnt(run: &mut dyn Run) -> [String; 4] {
    let asker = status(run, "Asker");
    ["mode", "answers", "gone", "failures"].map(|name| asker.state[name].replace('C', ""))
}

/// The next version: another element before those of the events, and a new function.
fn next() -> String {
    replaced(
        ASKER,
        &[
            (
                "{NOEV | ANSWER | FAILED | GONE}",
                "{GONE | LOST | FAILED | ANSWER | NOEV}",
            ),
            ("\tout first", "\tcontrolled laps: Integer\n\tout first"),
        ],
    )
}

fn begun(first: &(MemoryFiles, Version), ms: u64) -> (impl Run + use<>, Log) {
    let (system, log) = start(first);
    let mut run = system.simulate();
    run.run_until(at(ms));
    (run, log)
}

/// All three replies arrive in the cycle at 1.12 s, and each step takes one of them.
#[test]
fn c18_outcomes_that_wait_for_a_step_reach_the_new_version() {
    let first = version(COMPOSITE, ASKER);
    let (mut run, _) = begun(&first, 1150);
    assert_eq!(learnt(&mut run), ["WAITING", "1", "0", "0"]);
    let (_, next) = version(COMPOSITE, &next());
    let notes = apply(&mut run, &first.1, &next).expect("it continues");
    assert_eq!(notes, ["`laps` begins with its initial value"]);
    run.run_until(at(1350));
    assert_eq!(learnt(&mut run), ["WAITING", "3", "0", "0"]);
}

/// They do not depend on the binding of the messages of their location, nor on whether it has one.
#[test]
fn c18_outcomes_survive_another_binding_of_their_location() {
    let first = version(COMPOSITE, ASKER);
    let bound = "bind.monitored.ev = { value = \"NOEV\" }\nbind.monitored.late";
    let bound = replaced(COMPOSITE, &[("bind.monitored.late", bound)]);
    let (mut run, _) = begun(&first, 1150);
    let (_, next) = version(&bound, ASKER);
    assert_eq!(apply(&mut run, &first.1, &next), Ok(Vec::new()));
    run.run_until(at(1350));
    assert_eq!(learnt(&mut run), ["WAITING", "3", "0", "0"]);
}

#[test]
fn c18_a_version_that_cannot_take_a_waiting_outcome_is_refused_until_it_is_taken() {
    let first = version(COMPOSITE, ASKER);
    let renamed = replaced(
        ASKER,
        &[("domain Ev ", "domain Event "), ("ev: Ev\n", "ev: Event\n")],
    );
    let later = replaced(COMPOSITE, &[("ok = \"ANSWER\"", "ok = \"FAILED\"")]);
    for (composite, text, reason) in [
        (COMPOSITE, &*renamed, "the location that takes it differs"),
        (&later, ASKER, "the bindings of out functions differ"),
    ] {
        let (mut run, _) = begun(&first, 1150);
        let (_, next) = version(composite, text);
        let refusal = apply(&mut run, &first.1, &next).expect_err(reason);
        assert!(
            refusal.contains("the outcome of a call waits") && refusal.contains(reason),
            "{refusal}"
        );
        run.run_until(at(1350));
        assert_eq!(learnt(&mut run), ["WAITING", "3", "0", "0"]);
        apply(&mut run, &first.1, &next).expect("no outcome waits any more");
        run.run_until(at(2000));
        assert_eq!(learnt(&mut run), ["LATE", "3", "0", "0"]);
    }
}

/// The calls end where they were made: those to the removed component without a provider, and no reply follows.
#[test]
fn c18_calls_to_a_removed_component_end_as_unavailable_for_the_old_and_for_the_new_version() {
    for text in [ASKER.to_owned(), next()] {
        let first = version(COMPOSITE, ASKER);
        let (mut run, _) = begun(&first, 550);
        assert_eq!(status(&mut run, "Asker").calls.len(), 3);
        let (_, next) = version(&without_slow(), &text);
        apply(&mut run, &first.1, &next).expect("it is removed");
        run.run_until(at(950));
        assert_eq!(learnt(&mut run), ["WAITING", "0", "3", "0"]);
        assert!(status(&mut run, "Asker").calls.is_empty());
        run.run_until(at(3000));
        assert_eq!(
            learnt(&mut run),
            ["LATE", "0", "3", "0"],
            "no reply comes later"
        );
    }
}

/// A component that takes the place of another one gets no calls of its predecessor.
#[test]
fn c18_calls_under_way_end_when_their_wire_leads_elsewhere() {
    let first = version(COMPOSITE, ASKER);
    let rewired = replaced(COMPOSITE, &[(WIRE, "service = \"Spare.sums\"")]);
    let (mut run, log) = begun(&first, 550);
    let (_, next) = version(&rewired, ASKER);
    apply(&mut run, &first.1, &next).expect("it is rewired");
    run.run_until(at(3000));
    assert_eq!(learnt(&mut run), ["LATE", "0", "3", "0"]);
    let unavailable = log.lines_with("no server is available");
    assert_eq!(
        unavailable.len(),
        3,
        "each is reported once: {unavailable:?}"
    );
}

#[test]
fn c18_a_version_that_does_not_make_a_call_under_way_is_refused() {
    let first = version(COMPOSITE, ASKER);
    let (mut run, _) = begun(&first, 550);
    let other = replaced(COMPOSITE, &[("with = { n = 3 }", "with = { n = 4 }")]);
    let (_, next) = version(&other, ASKER);
    let refusal = apply(&mut run, &first.1, &next).expect_err("a call is under way");
    assert!(
        refusal.contains("a call of `sums.double` is under way"),
        "{refusal}"
    );
    run.run_until(at(1350));
    assert_eq!(
        learnt(&mut run),
        ["WAITING", "3", "0", "0"],
        "no outcome is lost"
    );
    apply(&mut run, &first.1, &next).expect("it has ended");
}

/// Runs until `ms`, changes the timer, and returns the notes and the first time at which the timer has ended.
fn changed(ms: u64, to: &str, text: &str) -> (Vec<String>, Option<u64>) {
    let first = version(COMPOSITE, ASKER);
    let (mut run, _) = begun(&first, ms);
    let (_, next) = version(&replaced(COMPOSITE, &[(TIMER, to)]), text);
    let notes = apply(&mut run, &first.1, &next).expect("it continues");
    let mut times = (ms..6000).filter(|ms| ms % 100 == 50);
    let ended = times.find(|ms| {
        run.run_until(at(*ms));
        learnt(&mut run)[0] == "LATE"
    });
    (notes, ended)
}

/// The timer starts with the first step, at 0.02 s.
#[test]
fn c18_a_timer_keeps_the_time_that_its_condition_has_held() {
    let timer = |ms: u64| format!("bind.monitored.late = {{ timer = \"asked\", ms = {ms} }}");
    let undisturbed = changed(750, TIMER, ASKER).1;
    assert_eq!(undisturbed, Some(1550));
    assert_eq!(changed(750, TIMER, &next()).1, undisturbed);
    for (ms, ends) in [(2500, 2550), (1000, 1050), (300, 850)] {
        assert_eq!(
            changed(750, &timer(ms), ASKER),
            (Vec::new(), Some(ends)),
            "{ms} ms"
        );
    }
}

#[test]
fn c18_a_timer_with_another_condition_begins_anew() {
    let other = "bind.monitored.late = { timer = \"asked and gone != C3\", ms = 1500 }";
    let note = "the timer of `late` begins anew: its binding differs".to_owned();
    assert_eq!(changed(750, other, ASKER), (vec![note.clone()], Some(2350)));
    // the condition does not hold any more
    let never = "bind.monitored.late = { timer = \"gone = C3\", ms = 1500 }";
    assert_eq!(changed(750, never, ASKER), (vec![note], None));
}

#[test]
fn c18_a_timer_that_is_removed_never_ends() {
    let note = |reason: &str| vec![format!("the timer of `late` ends: {reason}")];
    let constant = "bind.monitored.late = { value = false }";
    assert_eq!(
        changed(750, constant, ASKER),
        (note("its binding differs"), None)
    );
    let unread = replaced(
        ASKER,
        &[
            ("\tmonitored late: Boolean\n", ""),
            ("\t\t\tif late then mode := LATE endif\n", ""),
        ],
    );
    assert_eq!(
        changed(750, "", &unread),
        (note("the new version does not read it"), None)
    );
}

#[test]
fn c18_a_timer_begins_with_the_version_that_adds_it() {
    let without = version(
        &replaced(
            COMPOSITE,
            &[(TIMER, "bind.monitored.late = { value = false }")],
        ),
        ASKER,
    );
    let (mut run, _) = begun(&without, 750);
    let (_, next) = version(COMPOSITE, ASKER);
    assert_eq!(apply(&mut run, &without.1, &next), Ok(Vec::new()));
    run.run_until(at(2200));
    assert_eq!(learnt(&mut run)[0], "WAITING");
    run.run_until(at(2350));
    assert_eq!(learnt(&mut run)[0], "LATE");
}
