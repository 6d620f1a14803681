//! Replacement of the specifications of a running system (C18): it continues in its state, or the old one keeps running.

use std::sync::Arc;

use asmotion_assembly::reconfigure::{Version, changes};
use asmotion_assembly::{CoordinatorOptions, Standard};
use asmotion_component::{
    Component, Cycle, Fault, In, Interface, Operation, Out, Provided, Span, Time, Transition,
};
use asmotion_composite::{AsmFiles, Context, Tables};
use asmotion_coordinator::CoordinatorStatus;
use asmotion_datum::{Message, Schema};
use asmotion_lang::MemoryFiles;
use asmotion_plan::Part;
use asmotion_runtime::{Event, FrozenSystem, Log, REPLACEMENT_REPORT, Run, System};

asmotion_datum::message! {
    /// A test message with a number.
    #[derive(Copy)]
    pub struct Number = "test/Number" {
        /// Payload of the message.
        pub n: i64,
    }
}

struct Double;

impl Operation for Double {
    type Request = Number;
    type Response = Number;
    const INTERFACE: &'static str = "test/Arithmetic";
    const NAME: &'static str = "double";
}

/// An operation of the same interface.
struct Halve;

impl Operation for Halve {
    type Request = Number;
    type Response = Number;
    const INTERFACE: &'static str = "test/Arithmetic";
    const NAME: &'static str = "halve";
}

/// Counts its cycles.
struct Counter {
    n: i64,
    out: Out<Number>,
}

impl Component for Counter {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        self.n += 1;
        cycle.write(self.out, Number { n: self.n });
        Ok(())
    }
}

/// Doubles each number after a second, and halves it at once.
struct Slow {
    double: Provided<Double>,
    halve: Provided<Halve>,
    waiting: Vec<(Time, asmotion_component::Request<Number>)>,
}

impl Component for Slow {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        let due = cycle.now() + 1.s();
        let requests = cycle.requests(self.double);
        self.waiting
            .extend(requests.into_iter().map(|it| (due, it)));
        let now = cycle.now();
        for (_, request) in self.waiting.extract_if(.., |(due, _)| *due <= now) {
            let n = request.argument.n * 2;
            cycle.reply(self.double, request.id, Ok(Number { n }));
        }
        for request in cycle.requests(self.halve) {
            let n = request.argument.n / 2;
            cycle.reply(self.halve, request.id, Ok(Number { n }));
        }
        Ok(())
    }
}

/// Publishes the messages it receives.
struct Echo {
    input: In<Number>,
    out: Out<Number>,
}

impl Component for Echo {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        for number in cycle.all(self.input).to_vec() {
            cycle.write(self.out, number);
        }
        Ok(())
    }
}

pub(crate) const BUILD: Tables = Tables {
    components: &[
        ("test::Counter", |interface: &mut Interface| {
            Box::new(Counter {
                n: 0,
                out: interface.output("number", "the count"),
            })
        }),
        ("test::Slow", |interface: &mut Interface| {
            Box::new(Slow {
                double: interface.serve("sums", "doubles a number, slowly"),
                halve: interface.serve("sums", "halves a number"),
                waiting: Vec::new(),
            })
        }),
        ("test::Echo", |interface: &mut Interface| {
            let input = interface.input("heard", "numbers");
            Box::new(Echo {
                input,
                out: interface.output("said", "the same"),
            })
        }),
    ],
    messages: &[(Number::NAME, Number::schema as fn() -> &'static Schema)],
    ..Tables::EMPTY
};

/// Sums the numbers it receives, one in each step; creates a box for each of the first three; asks for the double of the first.
pub(crate) const BRAIN: &str = "asm brain
import StandardLibrary
signature:
	enum domain Action = {NOACT | ASK}
	enum domain Ev = {NOEV | ANSWER | FAILED}
	enum domain Mode = {COLLECTING | DONE}
	dynamic abstract domain Box
	domain Total subsetof Integer
	monitored number: Integer
	monitored ev: Ev
	controlled mode: Mode
	controlled total: Total
	controlled boxes: Seq(Box)
	controlled content: Box -> Integer
	controlled answered: Boolean
	out command: Action
	out sum: Integer
definitions:
	domain Total = {-100000 .. 100000}
	main rule r_Main =
		par
			if number > 0 then
				par
					total := total + number
					sum := total + number
					if number <= 3 then
						extend Box with $b do
							par
								boxes := append(boxes, $b)
								content($b) := number
							endpar
					endif
					if number = 1 then command := ASK endif
				endpar
			endif
			if ev = ANSWER then answered := true endif
		endpar
default init s0:
	function mode = COLLECTING
	function total = 0
	function sum = 0
	function boxes = []
	function content($b in Box) = 0
	function answered = false
	function command = NOACT
";

/// Subtracts instead of adding, and counts.
const NEXT: &[(&str, &str)] = &[
    ("total := total + number\n", "total := total - number\n"),
    (
        "sum := total + number\n",
        "sum := total - number\n\t\t\t\t\tcount := count + 1\n",
    ),
    (
        "\tout sum: Integer\n",
        "\tout sum: Integer\n\tcontrolled count: Integer\n",
    ),
    (
        "\tfunction sum = 0\n",
        "\tfunction sum = 0\n\tfunction count = 100\n",
    ),
    // other numbers for all elements
    ("{NOACT | ASK}", "{WAIT | NOACT | ASK}"),
    ("{COLLECTING | DONE}", "{PAUSED | DONE | COLLECTING}"),
];

pub(crate) const COMPOSITE: &str = r#"
schema = "composite/1"
[composite]
name = "thinker"

[components.Counter]
implementation = { rust = "test::Counter" }
task = { period_ms = 100 }
publish = { number = "test/Number" }

[components.Slow]
implementation = { rust = "test::Slow" }
task = { period_ms = 50 }

[components.Brain]
implementation = { asm = "brain.asm" }
task = { period_ms = 100, delay_ms = 20 }
subscribe = { number = "test/Number" }
publish = { sums = "test/Number" }
references = { sums = "test/Arithmetic" }
bind.monitored.number = { topic = "number", receive = "all", field = "n", none = 0 }
bind.out.sum = { topic = "sums", field = "n" }

[components.Brain.bind.out.command]
ASK = { call = "sums.double", with = { n = 4 }, ok = "ANSWER", failed = "FAILED", event = "ev" }

[components.Echo]
implementation = { rust = "test::Echo" }

[[connections]]
from = "topic:sums"
to = "Echo.heard"
policy = { type = "buffer", size = 64 }

[[wires]]
reference = "Brain.sums"
service = "Slow.sums"
timeout_ms = 5000
"#;

/// Returns a text after replacements.
pub(crate) fn replaced(text: &str, changes: &[(&str, &str)]) -> String {
    let mut text = text.to_owned();
    for (from, to) in changes {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, to);
    }
    text
}

/// Returns the files and version of a composite and its specification.
pub(crate) fn version(composite: &str, specification: &str) -> (MemoryFiles, Version) {
    version_of(&[
        ("main.toml", composite),
        ("brain.asm", specification),
        ("replier.asm", REPLIER),
    ])
}

/// Returns files and the version that they make; the composite is `main.toml`.
pub(crate) fn version_of(texts: &[(&str, &str)]) -> (MemoryFiles, Version) {
    let mut files = MemoryFiles::new();
    for (path, text) in texts {
        files.add(path, *text);
    }
    let specifications = AsmFiles::new(&files);
    let context = Context {
        catalogue: &BUILD,
        specifications: &specifications,
        programs: &asmotion_composite::NoPrograms,
        ..Context::files(&files)
    };
    let opened = asmotion_plan::open("main.toml", &context);
    let said = crate::render::report(&opened.sources, &opened.report);
    let plan = opened.plan(None).unwrap_or_else(|| panic!("{said}"));
    let plan = plan.clone();
    let version = Version::new(
        plan,
        Part::Whole,
        Arc::new(BUILD),
        Arc::new(files.clone()),
        CoordinatorOptions::seeded(1),
    );
    (files, version)
}

pub(crate) fn start((files, version): &(MemoryFiles, Version)) -> (System, Log) {
    let mut workshop = Standard::new(&BUILD, files, CoordinatorOptions::seeded(1));
    let mut system = asmotion_assembly::start(&version.plan, &mut workshop).expect("a system");
    let log = Log::new();
    system.observe(log.clone());
    (system, log)
}

pub(crate) fn status(run: &mut dyn Run, component: &str) -> CoordinatorStatus {
    let entries = run.inspect(component).expect("a coordinator");
    CoordinatorStatus::of(&entries).expect("its status")
}

pub(crate) fn said(log: &Log) -> Vec<i64> {
    let samples = log.samples::<Number>("Echo.said").into_iter();
    samples.map(|(_, number)| number.n).collect()
}

/// Applies a version. Returns the notes, or the refusal.
pub(crate) fn apply(
    run: &mut dyn Run,
    from: &Version,
    to: &Version,
) -> Result<Vec<String>, String> {
    let planned = changes(from, to, run).expect("no new start is needed");
    let tried = run.check_change(&planned).map_err(|it| it.to_string());
    let done = run.change(&planned).map_err(|it| it.to_string());
    assert_eq!(tried, done, "a check says the same");
    done
}

/// Runs the system for 1.05 s, replaces its specification, and runs it for two more seconds.
fn swapped(run: &mut dyn Run, first: &Version) -> Vec<String> {
    let (_, next) = version(COMPOSITE, &replaced(BRAIN, NEXT));
    run.run_for(1050.ms());
    let notes = apply(run, first, &next).expect("it continues");
    run.run_for(2.s());
    notes
}

#[test]
fn c18_a_new_version_of_a_specification_continues_in_the_state_of_the_old_one() {
    let first = version(COMPOSITE, BRAIN);
    let (system, log) = start(&first);
    let mut run = system.simulate();
    let notes = swapped(&mut run, &first.1);
    assert_eq!(notes, ["`count` begins with its initial value"]);
    let numbers = said(&log);
    let added: i64 = (1..=11).sum();
    assert_eq!(numbers[9..13], [55, added, added - 12, added - 12 - 13]);
    let brain = status(&mut run, "Brain");
    assert_eq!(brain.state["mode"], "COLLECTING");
    assert_eq!(brain.step, 31, "steps are counted on");
    let update = brain.last_update.expect("an update");
    assert_eq!(update.updates["count"], "120");
}

#[test]
fn c18_elements_and_calls_under_way_continue_in_the_new_version() {
    let first = version(COMPOSITE, BRAIN);
    let (system, _) = start(&first);
    let mut run = system.simulate();
    run.run_for(500.ms());
    assert_eq!(status(&mut run, "Brain").calls, ["sums.double"]);
    let seen = "\t\t\tif ev = ANSWER then par answered := true boxes := append(boxes, last(boxes)) \
                mode := if content(last(boxes)) = 3 then DONE else PAUSED endif endpar endif\n";
    let answers = ("\t\t\tif ev = ANSWER then answered := true endif\n", seen);
    let text = replaced(&replaced(BRAIN, NEXT), &[answers]);
    let (_, next) = version(COMPOSITE, &text);
    apply(&mut run, &first.1, &next).expect("it continues");
    assert_eq!(status(&mut run, "Brain").calls, ["sums.double"]);
    run.run_for(1.s());
    let brain = status(&mut run, "Brain");
    assert_eq!(brain.state["mode"], "DONE", "the answer and the third box");
    assert!(brain.calls.is_empty());
}

#[test]
fn c18_equal_runs_with_a_replacement_have_equal_traces() {
    let trace = || {
        let first = version(COMPOSITE, BRAIN);
        let (mut system, _) = start(&first);
        let lines = Arc::new(std::sync::Mutex::new(Vec::new()));
        let written = Arc::clone(&lines);
        system.observe(move |at: Time, event: &Event<'_>| {
            written
                .lock()
                .expect("a list")
                .push(format!("{at:?} {event}"));
        });
        let mut run = system.simulate();
        swapped(&mut run, &first.1);
        drop(run);
        lines.lock().expect("a list").clone()
    };
    let lines = trace();
    assert_eq!(lines, trace());
    let report = lines.iter().find(|it| it.contains(REPLACEMENT_REPORT));
    let report = report.expect("it is reported");
    assert!(
        report.contains("another version of `brain.asm`"),
        "{report}"
    );
}

/// Refuses each of these versions, and continues as if there had been none.
#[test]
fn c18_a_version_that_does_not_fit_the_state_is_refused_and_the_old_one_runs_on() {
    let refused = [
        (
            vec![(
                "default init",
                "\tinvariant over total: total < 50\ndefault init",
            )],
            "the invariant `total < 50` does not hold in the state after step 11, in which the new version begins\n  --> brain.asm:38:24",
        ),
        (
            vec![
                ("{COLLECTING | DONE}", "{READY | DONE}"),
                ("mode = COLLECTING", "mode = READY"),
            ],
            "`mode` is COLLECTING, which does not exist in the new version",
        ),
        (
            vec![("{-100000 .. 100000}", "{0 .. 40}")],
            "66 is not an element of `Total`",
        ),
    ];
    let first = version(COMPOSITE, BRAIN);
    let undisturbed = {
        let (system, log) = start(&first);
        system.simulate().run_for(2.s());
        said(&log)
    };
    let (system, log) = start(&first);
    let mut run = system.simulate();
    run.run_for(1050.ms());
    for (changed, reason) in refused {
        let (_, next) = version(COMPOSITE, &replaced(BRAIN, &changed));
        let refusal = apply(&mut run, &first.1, &next).expect_err(reason);
        assert!(refusal.contains("`Brain` cannot be replaced"), "{refusal}");
        assert!(refusal.contains(reason), "{refusal}");
    }
    run.run_until(Time::ZERO + 2.s());
    assert_eq!(said(&log), undisturbed);
}

/// The events of a run in text form.
fn lines(system: &mut System) -> Arc<std::sync::Mutex<Vec<String>>> {
    let lines = Arc::new(std::sync::Mutex::new(Vec::new()));
    let written = Arc::clone(&lines);
    system.observe(move |at: Time, event: &Event<'_>| {
        let mut written = written.lock().expect("a list");
        written.push(format!("{at:?} {event}"));
    });
    lines
}

#[test]
fn c18_messages_of_an_input_with_another_binding_are_dropped_and_reported() {
    let newest = replaced(COMPOSITE, &[("receive = \"all\"", "receive = \"last\"")]);
    // five messages for each step, of which four wait
    let queued = [(
        "period_ms = 100 }\npublish = { number",
        "period_ms = 20 }\npublish = { number",
    )];
    let queued = replaced(COMPOSITE, &queued);
    let cases = [
        (
            newest,
            vec!["the last message of `number` is dropped: its binding differs"],
            0,
        ),
        (
            queued,
            vec!["37 unread messages of `number` are dropped: its binding differs"],
            37,
        ),
    ];
    for (composite, expected, lost) in cases {
        let first = version(&composite, BRAIN);
        let (mut system, _) = start(&first);
        let lines = lines(&mut system);
        let mut run = system.simulate();
        run.run_for(1.s());
        let (_, next) = version(&replaced(&composite, &[("none = 0", "none = -7")]), BRAIN);
        let notes = apply(&mut run, &first.1, &next).expect("it continues");
        assert_eq!(notes, expected);
        run.run_for(200.ms());
        drop(run);
        let lines = lines.lock().expect("a list").join("\n");
        assert!(
            lines.contains(&format!("Brain: notice: {:?}", expected[0])),
            "{lines}"
        );
        let losses = format!("asm/Losses: {{dropped: {lost},");
        assert_eq!(lines.contains(&losses), lost > 0, "{losses}: {lines}");
    }
}

#[test]
fn c18_an_input_whose_connection_is_removed_is_as_before_its_first_message() {
    let direct = [
        (
            "subscribe = { number = \"test/Number\" }",
            "ports.in = { number = \"test/Number\" }",
        ),
        ("publish = { number = \"test/Number\" }\n", ""),
        ("receive = \"all\"", "receive = \"last\""),
        ("none = 0", "none = -1000"),
        (
            "[[wires]]",
            "[[connections]]\nfrom = \"Counter.number\"\nto = \"Brain.number\"\n\n[[wires]]",
        ),
    ];
    let composite = replaced(COMPOSITE, &direct);
    let brain = replaced(
        BRAIN,
        &[(
            "if number > 0 then",
            "if number = -1000 then mode := DONE else",
        )],
    );
    let first = version(&composite, &brain);
    let (mut system, _) = start(&first);
    let lines = lines(&mut system);
    let mut run = system.simulate();
    run.run_for(1050.ms());
    assert_eq!(status(&mut run, "Brain").state["mode"], "COLLECTING");
    // what it receives from now on depends on what it sends
    let (_, next) = version(
        &replaced(
            &composite,
            &[("from = \"Counter.number\"", "from = \"Echo.said\"")],
        ),
        &brain,
    );
    assert_eq!(apply(&mut run, &first.1, &next), Ok(Vec::new()));
    run.run_for(200.ms());
    assert_eq!(status(&mut run, "Brain").state["mode"], "DONE");
    drop(run);
    let lines = lines.lock().expect("a list").join("\n");
    let notice =
        "`number` is without a message: the connection of its last one does not exist any more";
    assert_eq!(lines.matches(notice).count(), 1, "{lines}");
}

#[test]
fn c18_other_bindings_take_effect() {
    let first = version(COMPOSITE, BRAIN);
    let (system, _) = start(&first);
    let mut run = system.simulate();
    run.run_for(1.s());
    let (_, other) = version(&replaced(COMPOSITE, &[("none = 0", "none = -1")]), BRAIN);
    let planned = changes(&first.1, &other, &run).expect("no new start is needed");
    let words: Vec<_> = planned.iter().map(ToString::to_string).collect();
    assert_eq!(words, ["`Brain` runs `brain.asm` with other bindings"]);
    assert_eq!(apply(&mut run, &first.1, &other), Ok(Vec::new()));
    run.run_for(1.s());
    let total = status(&mut run, "Brain").step;
    assert_eq!(total, 20);
    // a queue of one message in place of many
    let all_to_last = ("receive = \"all\"", "receive = \"last\"");
    let (_, last) = version(&replaced(COMPOSITE, &[all_to_last]), BRAIN);
    let planned = changes(&other, &last, &run).expect("no new start is needed");
    let words: Vec<_> = planned.iter().map(ToString::to_string).collect();
    assert_eq!(
        words,
        [
            "`Brain.number` no longer subscribes to topic `number`",
            "`Brain` runs `brain.asm` with other bindings",
            "`Brain.number` subscribes to topic `number`"
        ]
    );
    apply(&mut run, &other, &last).expect("another queue");
    run.run_for(1.s());
    assert_eq!(status(&mut run, "Brain").step, 30);
    apply(&mut run, &last, &other).expect("the queue of before");
}

#[test]
fn c18_several_specifications_are_replaced_all_or_none() {
    let second = COMPOSITE[COMPOSITE.find("[components.Brain]").expect("a brain")..]
        .split("[components.Echo]")
        .next()
        .expect("the brain")
        .replace("Brain", "Other")
        .replace("{ number =", "{ others =")
        .replace("topic = \"number\"", "topic = \"others\"")
        .replace("{ sums = \"test/Number\"", "{ other_sums = \"test/Number\"")
        .replace("topic = \"sums\"", "topic = \"other_sums\"");
    let wire =
        "[[wires]]\nreference = \"Other.sums\"\nservice = \"Slow.sums\"\ntimeout_ms = 5000\n";
    let composite = format!("{COMPOSITE}\n{second}\n{wire}");
    let first = version(&composite, BRAIN);
    let (system, log) = start(&first);
    let mut run = system.simulate();
    run.run_for(1050.ms());
    // holds for `Brain`, which has received numbers, and not for `Other`
    let invariant = [(
        "default init",
        "\tinvariant over total: total > 0\ndefault init",
    )];
    let text = replaced(&replaced(BRAIN, NEXT), &invariant);
    let text = replaced(&text, &[("function total = 0", "function total = 1")]);
    let (_, next) = version(&composite, &text);
    let refusal = apply(&mut run, &first.1, &next).expect_err("`Other` refuses");
    assert!(refusal.contains("`Other` cannot be replaced"), "{refusal}");
    run.run_for(200.ms());
    assert_eq!(said(&log)[10..], [66, 78, 91], "the old version adds");
    let (_, next) = version(&composite, &replaced(BRAIN, NEXT));
    apply(&mut run, &first.1, &next).expect("both continue");
    run.run_for(100.ms());
    assert_eq!(said(&log)[13..], [91 - 14]);
}

#[test]
fn c18_a_faulty_coordinator_begins_anew_with_its_new_version() {
    let fails = [(
        "default init",
        "\tinvariant over total: total < 20\ndefault init",
    )];
    let first = version(COMPOSITE, &replaced(BRAIN, &fails));
    let (system, log) = start(&first);
    let mut run = system.simulate();
    run.run_for(1050.ms());
    assert!(!run.is_running("Brain"));
    let (_, repaired) = version(COMPOSITE, BRAIN);
    assert_eq!(apply(&mut run, &first.1, &repaired), Ok(Vec::new()));
    let before = said(&log).len();
    for transition in [
        Transition::ResetException,
        Transition::Configure,
        Transition::Start,
    ] {
        run.transition("Brain", transition).expect("a transition");
    }
    run.run_for(1.s());
    assert!(run.is_running("Brain"));
    assert!(said(&log).len() > before);
}

#[test]
fn c18_a_frozen_system_with_a_new_version_thaws_in_a_system_of_that_version() {
    let alone = "schema = \"composite/1\"\n[composite]\nname = \"alone\"\n[components.Brain]\n\
        implementation = { asm = \"brain.asm\" }\ntask = { period_ms = 100 }\n\
        subscribe = { number = \"test/Number\" }\npublish = { sums = \"test/Number\" }\n\
        bind.monitored.number = { topic = \"number\", receive = \"all\", field = \"n\", none = 0 }\n\
        bind.out.sum = { topic = \"sums\", field = \"n\" }\n";
    let first = version(alone, BRAIN);
    let next = version(alone, &replaced(BRAIN, NEXT));
    let (system, log) = start(&first);
    let mut run = system.simulate();
    for n in 1..=3 {
        run.inject(Time::ZERO + 1.ms(), "Brain.number", Number { n })
            .expect("a number");
    }
    run.run_for(250.ms());
    apply(&mut run, &first.1, &next.1).expect("it continues");
    run.run_for(20.ms());
    let frozen: FrozenSystem = run.freeze().expect("it can be frozen");
    let (system, thawed_log) = start(&next);
    let mut thawed = system.simulate();
    thawed.thaw(&frozen).expect("it can be thawed");
    run.run_for(500.ms());
    thawed.run_for(500.ms());
    let sums = |log: &Log| log.samples::<Number>("Brain.sums");
    let sums = (sums(&log), sums(&thawed_log));
    assert_eq!(sums.0[2..], sums.1[..]);
    let [one, other] = [&mut run, &mut thawed].map(|run| status(run, "Brain"));
    assert_eq!((one.step, one.state), (other.step, other.state));
    assert_eq!(one.last_update, other.last_update);
}

#[test]
fn c18_on_the_wall_clock_no_event_is_lost_by_a_replacement() {
    let composite = replaced(
        COMPOSITE,
        &[
            ("period_ms = 100", "period_ms = 5"),
            (", delay_ms = 20", ""),
        ],
    );
    let first = version(&composite, BRAIN);
    let (_, next) = version(
        &composite,
        &replaced(
            BRAIN,
            &[("sum := total + number", "sum := 0 - total - number")],
        ),
    );
    let (system, log) = start(&first);
    let mut run = system.live();
    run.run_for(150.ms());
    apply(&mut run, &first.1, &next).expect("it continues");
    run.run_for(150.ms());
    run.stop();
    let totals = said(&log);
    assert!(totals.first().is_some_and(|it| *it > 0), "{totals:?}");
    assert!(totals.last().is_some_and(|it| *it < 0), "{totals:?}");
    let sums = (1..).scan(0, |sum, n| {
        *sum += n;
        Some(*sum)
    });
    assert!(
        totals.iter().zip(sums).all(|(seen, sum)| seen.abs() == sum),
        "{totals:?}"
    );
}

#[test]
fn c18_timers_run_on_and_new_initial_values_use_the_present_inputs() {
    let first = version(COMPOSITE, BRAIN);
    let (system, log) = start(&first);
    let mut run = system.simulate();
    run.run_for(1050.ms());
    let timer = "bind.monitored.late = { timer = \"total > 0\", ms = 540 }\nbind.out.sum";
    let composite = replaced(COMPOSITE, &[("bind.out.sum", timer)]);
    let late = [
        (
            "\tmonitored number",
            "\tmonitored late: Boolean\n\tmonitored number",
        ),
        (
            "\tcontrolled mode",
            "\tcontrolled base: Integer\n\tcontrolled mode",
        ),
        (
            "\tfunction mode",
            "\tfunction base = number + 5\n\tfunction mode",
        ),
        ("sum := total + number", "sum := total + number + base"),
        (
            "\t\t\tif ev",
            "\t\t\tif late then mode := DONE endif\n\t\t\tif ev",
        ),
    ];
    let next = version(&composite, &replaced(BRAIN, &late));
    let notes = apply(&mut run, &first.1, &next.1).expect("it continues");
    assert_eq!(notes, ["`base` begins with its initial value"]);
    run.run_for(200.ms());
    assert_eq!(said(&log)[11..], [78 + 5, 91 + 5]);
    let paused = replaced(
        &replaced(BRAIN, &late),
        &[("{COLLECTING |", "{PAUSED | COLLECTING |")],
    );
    let last = version(&composite, &paused);
    apply(&mut run, &next.1, &last.1).expect("it continues");
    run.run_until(Time::ZERO + 1600.ms());
    assert_eq!(status(&mut run, "Brain").state["mode"], "COLLECTING");
    run.run_until(Time::ZERO + 1650.ms());
    assert_eq!(status(&mut run, "Brain").state["mode"], "DONE");
}

/// Asks once, and greets when the answer has come.
const ASKER: &str = "asm asker
import StandardLibrary
import CommonBehavior
signature:
	enum domain Word = {YES | NO}
	domain Services subsetof Agent
	static sums: Services
	controlled answer: Integer
	controlled greeting: Word
	out double: Prod(Services, Integer) -> Integer
definitions:
	main rule r_Main =
		if not isDef(answer) then r_wcall[sums, \"double\", 4, 5000, answer]
		else if answer = 8 then greeting := NO endif endif
default init s0:
	function greeting = YES
";

const REPLIER: &str = "asm replier
import StandardLibrary
import CommonBehavior
signature:
	controlled asked: Integer
	out double: Prod(Agent, Integer) -> Integer
definitions:
	main rule r_Main =
		if nextRequest(self) = \"double\" then
			seq
				r_wreceive[undef, \"double\", asked]
				r_wreply[undef, \"double\", asked + asked]
			endseq
		endif
default init s0:
	function asked = 0
";

const ASKED: &str = r#"
schema = "composite/1"
[composite]
name = "asked"
[components.Asker]
implementation = { asm = "brain.asm" }
task = { period_ms = 10 }
references = { sums = "test/Adds" }
[components.Replier]
implementation = { asm = "replier.asm" }
task = { period_ms = 200, delay_ms = 100 }
services = { adding = "test/Adds" }
[[wires]]
reference = "Asker.sums"
service = "Replier.adding"
timeout_ms = 5000
"#;

#[test]
fn c18_messages_on_their_way_reach_the_new_versions_of_both_partners() {
    let first = version(ASKED, ASKER);
    let (system, _) = start(&first);
    let mut run = system.simulate();
    run.run_for(50.ms());
    assert_eq!(status(&mut run, "Asker").calls, ["sums.double"]);
    let other_numbers = [("{YES | NO}", "{MAYBE | PERHAPS | NO | YES}")];
    let next = version(ASKED, &replaced(ASKER, &other_numbers));
    assert_eq!(apply(&mut run, &first.1, &next.1), Ok(Vec::new()));
    run.run_for(250.ms());
    let asker = status(&mut run, "Asker");
    assert_eq!(
        (asker.state["greeting"].as_str(), asker.calls.len()),
        ("NO", 0)
    );
}

const DICE: &str = "asm dice
import StandardLibrary
signature:
	enum domain Side = {HEADS | TAILS}
	controlled side: Side
	out pick: Integer
definitions:
	main rule r_Main = choose $n in {1 : 1000} with true do pick := $n
default init s0:
	function side = HEADS
";

const ROLLED: &str = r#"
schema = "composite/1"
[composite]
name = "rolled"
[components.Dice]
implementation = { asm = "brain.asm" }
task = { period_ms = 100 }
publish = { picks = "test/Number" }
bind.out.pick = { topic = "picks", field = "n" }
"#;

#[test]
fn c18_random_choices_continue_in_the_new_version() {
    let picks = |is_replaced: bool| {
        let first = version(ROLLED, DICE);
        let (system, log) = start(&first);
        let mut run = system.simulate();
        run.run_for(450.ms());
        if is_replaced {
            let next = version(ROLLED, &replaced(DICE, &[("{HEADS", "{EDGE | HEADS")]));
            apply(&mut run, &first.1, &next.1).expect("it continues");
        }
        run.run_for(1.s());
        let picks = log.samples::<Number>("Dice.picks").into_iter();
        picks.map(|(_, number)| number.n).collect::<Vec<_>>()
    };
    let undisturbed = picks(false);
    assert_eq!(undisturbed.len(), 15);
    assert_eq!(picks(true), undisturbed);
}
