//! Reconfiguration (C18): a running composite is changed to its next version or remains unchanged.

use std::sync::Arc;

use asmotion_assembly::reconfigure::{Version, changes};
use asmotion_assembly::{CoordinatorOptions, Standard};
use asmotion_component::{Component, Cycle, Fault, In, Interface, Out, Property, Span};
use asmotion_composite::{Context, Tables};
use asmotion_datum::{Message, Schema};
use asmotion_lang::MemoryFiles;
use asmotion_plan::{Opened, Part};
use asmotion_runtime::{Log, Run};

asmotion_datum::message! {
    /// A test message with a number.
    #[derive(Copy)]
    pub struct Number = "test/Number" {
        /// Payload of the message.
        pub n: i64,
    }
}

/// Increments its output by the property `step`.
struct Counter {
    step: Property<i64>,
    n: i64,
    out: Out<Number>,
}

impl Component for Counter {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        self.n += cycle.property(self.step);
        cycle.write(self.out, Number { n: self.n });
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

const BUILD: Tables = Tables {
    components: &[
        ("test::Counter", |interface: &mut Interface| {
            Box::new(Counter {
                step: interface.property("step", 1, "from number to number"),
                n: 0,
                out: interface.output("number", "the count"),
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

const COMPOSITE: &str = r#"
schema = "composite/1"
[composite]
name = "next"

[components.One]
implementation = { rust = "test::Counter" }
task = { period_ms = 10 }
properties = { step = 2 }

[components.Other]
implementation = { rust = "test::Counter" }
task = { period_ms = 10 }

[components.Echo]
implementation = { rust = "test::Echo" }

[components.Witness]
implementation = { rust = "test::Echo" }

[[connections]]
from = "One.number"
to = "Echo.heard"
policy = { type = "buffer", size = 8 }

[[connections]]
from = "Other.number"
to = "Witness.heard"
policy = { type = "buffer", size = 8 }

[[promote]]
port = "Echo.said"
as = "echo"

[[promote]]
port = "Witness.said"
as = "witness"
"#;

fn open(text: &str) -> (MemoryFiles, Opened) {
    let mut files = MemoryFiles::new();
    files.add("main.toml", text);
    let context = Context {
        catalogue: &BUILD,
        ..Context::files(&files)
    };
    let opened = asmotion_plan::open("main.toml", &context);
    (files, opened)
}

/// Returns the composite after textual replacements.
fn version(replaced: &[(&str, &str)]) -> Version {
    let mut text = COMPOSITE.to_owned();
    for (from, to) in replaced {
        assert!(text.contains(from), "{from}");
        text = text.replacen(from, to, 1);
    }
    let (files, opened) = open(&text);
    let said = crate::render::report(&opened.sources, &opened.report);
    let plan = opened.plan(None).unwrap_or_else(|| panic!("{said}"));
    Version::new(
        plan.clone(),
        Part::Whole,
        Arc::new(BUILD),
        Arc::new(files),
        CoordinatorOptions::seeded(0),
    )
}

/// Starts the composite; returns its version, system and log.
fn running() -> (Version, asmotion_runtime::System, Log) {
    let (files, opened) = open(COMPOSITE);
    let plan = opened.plan(None).expect("a plan").clone();
    let mut workshop = Standard::new(&BUILD, &files, CoordinatorOptions::seeded(0));
    let mut system = asmotion_assembly::start(&plan, &mut workshop).expect("a system");
    let log = Log::new();
    system.observe(log.clone());
    let version = Version::new(
        plan,
        Part::Whole,
        Arc::new(BUILD),
        Arc::new(files),
        CoordinatorOptions::seeded(0),
    );
    (version, system, log)
}

/// Replacements: Echo reads from the other counter; the first counter has a longer period and the default step.
const NEXT: &[(&str, &str)] = &[
    ("from = \"One.number\"", "from = \"Other.number\""),
    ("period_ms = 10", "period_ms = 40"),
    ("properties = { step = 2 }", ""),
];

#[test]
fn c18_what_differs_changes_and_nothing_else() {
    let (plan, system, log) = running();
    let mut run = system.simulate();
    run.run_for(35.ms());
    let wanted = version(NEXT);
    let planned = changes(&plan, &wanted, &run).expect("changes");
    let planned_words: Vec<_> = planned.iter().map(ToString::to_string).collect();
    assert_eq!(
        planned_words,
        [
            "`One.number` is disconnected from `Echo.heard`",
            "`One` has step = 1",
            "`One` cycles every 40ms",
            "`Other.number` is connected to `Echo.heard`",
        ]
    );
    run.change(&planned).expect("it can change");
    run.run_for(80.ms());
    let said = |port: &str| -> Vec<i64> {
        let samples = log.samples::<Number>(port).into_iter();
        samples.map(|(_, number)| number.n).collect()
    };
    assert_eq!(said("Witness.said"), (1..=12).collect::<Vec<_>>());
    let echo = said("Echo.said");
    assert_eq!(echo[..4], [2, 4, 6, 8], "of the one");
    assert_eq!(echo[4..], [5, 6, 7, 8, 9, 10, 11, 12], "of the other");
    assert_eq!(said("One.number")[4..], [9, 10], "from 30 ms, every 40");
    assert!(changes(&wanted, &wanted, &run).is_ok_and(|none| none.is_empty()));
}

#[test]
fn c18_what_cannot_change_is_said_all_of_it() {
    let (plan, system, _) = running();
    let run = system.simulate();
    let wanted = version(&[
        ("[components.Witness]", "[components.Guard]"),
        ("to = \"Witness.heard\"", "to = \"Guard.heard\""),
        ("port = \"Witness.said\"", "port = \"Guard.said\""),
        (
            "implementation = { rust = \"test::Echo\" }",
            "implementation = { rust = \"test::Echo\" }\ntask = { delay_ms = 5 }",
        ),
    ]);
    let fixed = changes(&plan, &wanted, &run).expect_err("it cannot");
    let fixed: Vec<_> = fixed.iter().map(ToString::to_string).collect();
    assert_eq!(
        fixed,
        [
            "`promote` of the composite",
            "`Echo` differs in `delay_ms`; only its properties, its period and its topics can change while it runs",
        ]
    );
}

/// Another component counts in steps of five, and is heard instead of `One` by `Echo` and a new component.
const MORE: &[(&str, &str)] = &[
    (
        "[components.Echo]",
        "[components.Fives]\n\
         implementation = { rust = \"test::Counter\" }\n\
         task = { period_ms = 10, delay_ms = 3 }\n\
         properties = { step = 5 }\n\
         lifecycle = { safe = { number = { n = -1 } } }\n\
         [components.Guest]\n\
         implementation = { rust = \"test::Echo\" }\n\
         [components.Echo]",
    ),
    (
        "from = \"One.number\"\nto = \"Echo.heard\"",
        "from = \"Fives.number\"\nto = [\"Echo.heard\", \"Guest.heard\"]",
    ),
];

fn members(run: &mut dyn Run, versions: [&Version; 2], log: &Log) {
    let [first, more] = versions;
    run.run_for(25.ms());
    let planned = changes(first, more, run).expect("changes");
    let listed: Vec<_> = planned.iter().map(ToString::to_string).collect();
    assert_eq!(
        listed,
        [
            "`One.number` is disconnected from `Echo.heard`",
            "`Fives` is added and runs `test::Counter`",
            "`Guest` is added and runs `test::Echo`",
            "`Fives.number` is connected to `Echo.heard`",
            "`Fives.number` is connected to `Guest.heard`",
        ]
    );
    run.check_change(&planned).expect("possible");
    assert_eq!(run.components(), ["One", "Other", "Echo", "Witness"]);
    run.change(&planned).expect("applied");
    run.run_for(60.ms());
    let back = changes(more, first, run).expect("changes");
    let listed: Vec<_> = back.iter().map(ToString::to_string).collect();
    assert_eq!(listed[2..4], ["`Fives` is removed", "`Guest` is removed"]);
    run.change(&back).expect("applied");
    assert_eq!(run.components(), ["One", "Other", "Echo", "Witness"]);
    assert!(changes(first, first, run).is_ok_and(|none| none.is_empty()));
    run.run_for(60.ms());
    run.change(&changes(first, more, run).expect("changes"))
        .expect("applied once more");
    run.run_for(60.ms());
    run.stop();
    let said = |port: &str| -> Vec<i64> {
        let samples = log.samples::<Number>(port).into_iter();
        samples.map(|(_, number)| number.n).collect()
    };
    let witness = said("Witness.said");
    assert!(witness.len() > 15, "{witness:?}");
    assert!(witness.iter().zip(1..).all(|(n, it)| *n == it));
    let guest = said("Guest.said");
    let begins = guest.iter().filter(|n| **n == 5).count();
    assert_eq!(
        begins, 2,
        "a component that is added again begins anew: {guest:?}"
    );
    assert!(guest.len() > 6, "{guest:?}");
    let echo = said("Echo.said");
    assert!(echo.contains(&-1), "the safe sample of `Fives`: {echo:?}");
}

#[test]
fn c18_components_of_a_new_version_are_added_and_removed() {
    let more = version(MORE);
    let (first, system, log) = running();
    members(&mut system.simulate(), [&first, &more], &log);
    let (first, system, log) = running();
    members(&mut system.live(), [&first, &more], &log);
}

#[test]
fn c18_a_bad_version_leaves_the_old_one_running() {
    let (plan, system, log) = running();
    let mut run = system.live();
    run.run_for(50.ms());
    let (_, opened) = open(&COMPOSITE.replace("to = \"Echo.heard\"", "to = \"Echo.herd\""));
    assert!(opened.plan(None).is_none(), "its findings say why");
    let wanted = version(NEXT);
    let mut planned = changes(&plan, &wanted, &run).expect("changes");
    planned.extend_from_within(..1);
    let refused = run.change(&planned).expect_err("it is parted already");
    assert_eq!(
        refused.to_string(),
        "`One.number` is not connected to `Echo.heard`"
    );
    run.run_for(50.ms());
    run.stop();
    let echo = log.samples::<Number>("Echo.said");
    assert!(echo.len() >= 6, "{echo:?}");
    assert!(echo.iter().zip(1..).all(|((_, it), step)| it.n == 2 * step));
}
