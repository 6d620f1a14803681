//! Messages of every form reach the functions of a specification, and values of every form become messages.

use std::sync::{Arc, Mutex};

use asmotion_component::{Activity, NOTICE_REPORT, Policy, Span};
use asmotion_coordinator::{
    Binding, Coordinator, Effect, Interfaces, Monitored, Out, PublishWhen, Published, Receive,
    STEP_REPORT, Source, StepRecord, UNFIT_REPORT,
};
use asmotion_datum::{Datum, Numbers, OutlineKey, Schema, Shape};
use asmotion_lang::MemoryFiles;
use asmotion_runtime::{Event, Run, System};

/// The value of `seen` after a message to `input`, whose codomain is given; `None` if the message did not fit.
fn seen(codomain: &str, message: Datum) -> Option<String> {
    let text = format!(
        "
asm reader
import StandardLibrary
signature:
	enum domain Gear = {{LOW | MIDDLE | HIGH}}
	domain Fast subsetof Gear
	domain Speed subsetof Real
	monitored input: {codomain}
	controlled seen: {codomain}
definitions:
	domain Fast = {{MIDDLE, HIGH}}
	domain Speed = {{0.5, 1.5}}
	main rule r_Main = if isDef(input) then seen := input endif
"
    );
    let binding = Binding {
        monitored: vec![Monitored::new("input", Source::Port("input".to_owned()))],
        out: Vec::new(),
    };
    let interfaces = Interfaces {
        inputs: vec![("input".to_owned(), Schema::opaque("test/Any"))],
        ..Interfaces::default()
    };
    let mut system = system(&text, &binding, &interfaces);
    let found = Arc::new(Mutex::new(None));
    let note = found.clone();
    system.observe(move |_, event: &Event<'_>| {
        if let Event::Report { kind, data, .. } = event
            && *kind == STEP_REPORT
        {
            let step: StepRecord = data.to().unwrap();
            *note.lock().unwrap() = step.updates.first().map(|update| update.after.clone());
        }
    });
    let mut run = system.simulate();
    run.inject(run.now(), "Reader.input", message).unwrap();
    run.run_for(50.ms());
    let fits = run.losses("Reader").misfits == 0;
    let found = found.lock().unwrap().take();
    assert_eq!(
        fits,
        found.is_some(),
        "{codomain}: a message is read or counted"
    );
    found
}

fn system(text: &str, binding: &Binding, interfaces: &Interfaces) -> System {
    let mut files = MemoryFiles::new();
    files.add("reader.asm", text);
    let specification = asmotion_lang::open("reader.asm", &files).unwrap();
    let mut system = System::new();
    let made = system.add("Reader", Activity::periodic(10.ms()), |interface| {
        let made = Coordinator::new(specification, binding, interfaces, 1, interface);
        Box::new(made.unwrap())
    });
    made.unwrap();
    system
}

fn list(items: impl IntoIterator<Item = i64>) -> Datum {
    Datum::List(items.into_iter().map(Datum::Int).collect())
}

#[test]
fn a_list_reaches_a_specification_in_whatever_form_it_is_sent() {
    let forms = [
        list([3, 1, 3]),
        Datum::Bytes([3, 1, 3].into()),
        Datum::Numbers(Numbers::I32([3, 1, 3].into())),
        Datum::Numbers(Numbers::U16([3, 1, 3].into())),
        Datum::record([("data", Datum::Numbers(Numbers::I64([3, 1, 3].into())))]),
    ];
    for form in forms {
        let as_a = |codomain| seen(codomain, form.clone());
        assert_eq!(
            as_a("Seq(Integer)").as_deref(),
            Some("[3, 1, 3]"),
            "{form:?}"
        );
        assert_eq!(as_a("Seq(Natural)").as_deref(), Some("[3, 1, 3]"));
        assert_eq!(as_a("Seq(Real)").as_deref(), Some("[3.0, 1.0, 3.0]"));
        assert_eq!(as_a("Powerset(Integer)").as_deref(), Some("{1, 3}"));
        assert_eq!(as_a("Bag(Integer)").as_deref(), Some("<1, 3, 3>"));
        let tuple = as_a("Prod(Integer, Integer, Integer)");
        assert_eq!(tuple.as_deref(), Some("(3, 1, 3)"));
        assert_eq!(as_a("Prod(Integer, Integer)"), None);
        assert_eq!(as_a("Seq(String)"), None);
        assert_eq!(as_a("Integer"), None);
    }
    let floats = Datum::Numbers(Numbers::F32([0.5, 1.5].into()));
    assert_eq!(
        seen("Seq(Real)", floats.clone()).as_deref(),
        Some("[0.5, 1.5]")
    );
    assert_eq!(seen("Seq(Integer)", floats), None);
    let signed = Datum::Numbers(Numbers::I8([-1].into()));
    assert_eq!(
        seen("Seq(Integer)", signed.clone()).as_deref(),
        Some("[-1]")
    );
    assert_eq!(seen("Seq(Natural)", signed), None);
    assert_eq!(
        seen("Seq(Integer)", Datum::Bytes([].into())).as_deref(),
        Some("[]")
    );
}

#[test]
fn elements_of_subsets_and_characters_reach_a_specification() {
    assert_eq!(seen("Speed", Datum::Float(0.5)).as_deref(), Some("0.5"));
    assert_eq!(seen("Fast", Datum::text("HIGH")).as_deref(), Some("HIGH"));
    assert_eq!(seen("Fast", Datum::text("REVERSE")), None);
    assert_eq!(seen("Gear", Datum::text("LOW")).as_deref(), Some("LOW"));
    assert_eq!(seen("Char", Datum::text("x")).as_deref(), Some("'x'"));
    assert_eq!(seen("Char", Datum::text("xy")), None);
    assert_eq!(seen("Char", Datum::text("")), None);
}

/// The message published for a value.
fn published(codomain: &str, value: &str) -> Datum {
    let (message, report) = published_as(codomain, value, Schema::opaque("test/Any"));
    assert_eq!(report, None);
    message
}

/// The message published for a value on a port of this type, or the report that there is none.
fn published_as(codomain: &str, value: &str, schema: Schema) -> (Datum, Option<String>) {
    let text = format!(
        "
asm writer
import StandardLibrary
signature:
	enum domain Gear = {{LOW | MIDDLE | HIGH}}
	out output: {codomain}
definitions:
	main rule r_Main = output := {value}
"
    );
    let out = Out {
        location: "output".into(),
        effect: Effect::Publish(Published {
            port: "output".to_owned(),
            field: None,
            key: Vec::new(),
            when: PublishWhen::OnUpdate,
        }),
    };
    let binding = Binding {
        monitored: Vec::new(),
        out: vec![out],
    };
    let interfaces = Interfaces {
        outputs: vec![("output".to_owned(), schema)],
        ..Interfaces::default()
    };
    let mut system = system(&text, &binding, &interfaces);
    let found = Arc::new(Mutex::new((Datum::Null, None)));
    let note = found.clone();
    system.observe(move |_, event: &Event<'_>| {
        let mut note = note.lock().unwrap();
        if let Event::Published { sample, .. } = event {
            note.0 = sample.to_datum().unwrap();
        }
        if let Event::Report { kind, data, .. } = event
            && *kind == UNFIT_REPORT
        {
            note.1 = data.as_text().map(str::to_owned);
        }
    });
    system.simulate().run_for(5.ms());
    let found = found.lock().unwrap();
    found.clone()
}

#[test]
fn a_value_that_does_not_fit_the_type_of_its_port_is_reported_and_not_published() {
    let byte = || Schema::plain(Shape::U8);
    assert_eq!(
        published_as("Integer", "255", byte()),
        (Datum::Int(255), None)
    );
    for value in ["256", "-1"] {
        let (message, report) = published_as("Integer", value, byte());
        assert_eq!(message, Datum::Null, "{value}");
        assert_eq!(
            report,
            Some(format!("`output`: {value} is not between 0 and 255")),
        );
    }
    let bytes = || Schema::many(byte(), Some(2));
    assert_eq!(
        published_as("Seq(Integer)", "[1, 2]", bytes()).0,
        list([1, 2])
    );
    for value in ["[1, 256]", "[1, 2, 3]"] {
        let (message, report) = published_as("Seq(Integer)", value, bytes());
        assert_eq!(message, Datum::Null, "{value}");
        assert!(report.is_some(), "{value}");
    }
}

#[test]
fn collections_are_published_as_lists_and_records() {
    assert_eq!(published("Bag(Integer)", "<2, 1, 2>"), list([1, 2, 2]));
    assert_eq!(published("Powerset(Integer)", "{2, 1}"), list([1, 2]));
    let record = Datum::record([("HIGH", Datum::Int(3))]);
    assert_eq!(published("Map(Gear, Integer)", "{HIGH -> 3}"), record);
}

/// The values of `seen`, the notices and the number of misfits after messages, all in one cycle, to the function `input` that is
/// bound to a field of a port of this type.
fn taken(
    (codomain, field, receive): (&str, Option<&str>, Receive),
    schema: &Schema,
    messages: &[Datum],
) -> (Vec<String>, Vec<String>, u64) {
    let text = format!(
        "
asm reader
import StandardLibrary
signature:
	monitored input: {codomain}
	controlled seen: {codomain}
definitions:
	main rule r_Main = if isDef(input) then seen := input endif
"
    );
    let mut monitored = Monitored::new("input", Source::Port("stop".to_owned()));
    monitored.field = field.map(str::to_owned);
    monitored.receive = receive;
    let binding = Binding {
        monitored: vec![monitored],
        out: Vec::new(),
    };
    let interfaces = Interfaces {
        inputs: vec![("stop".to_owned(), schema.clone())],
        ..Interfaces::default()
    };
    let mut system = system(&text, &binding, &interfaces);
    system
        .subscribe("stops", "Reader.stop", Policy::buffer(64))
        .unwrap();
    let found = Arc::new(Mutex::new((Vec::new(), Vec::new())));
    let note = found.clone();
    system.observe(move |_, event: &Event<'_>| {
        let Event::Report { kind, data, .. } = event else {
            return;
        };
        let (values, notices) = &mut *note.lock().unwrap();
        if *kind == STEP_REPORT {
            let step: StepRecord = data.to().unwrap();
            values.extend(step.updates.into_iter().map(|update| update.after));
        } else if *kind == NOTICE_REPORT {
            notices.push(data.as_text().unwrap().to_owned());
        }
    });
    let mut run = system.simulate();
    run.run_for(5.ms());
    for message in messages {
        run.inject(run.now(), "Reader.stop", message.clone())
            .unwrap();
    }
    run.run_for(10.ms());
    let misfits = run.losses("Reader").misfits;
    let (values, notices) = std::mem::take(&mut *found.lock().unwrap());
    (values, notices, misfits)
}

fn boolean() -> Schema {
    let data = OutlineKey::new("data", "", Schema::plain(Shape::Bool));
    Schema::record("std_msgs/Bool", vec![data])
}

fn data(value: Datum) -> Datum {
    Datum::record([("data", value)])
}

const LAST: (&str, Option<&str>, Receive) = ("Boolean", Some("data"), Receive::Last);
const ALL: (&str, Option<&str>, Receive) = ("Boolean", Some("data"), Receive::All);

#[test]
fn a_message_of_another_type_is_refused_with_port_place_and_value() {
    let bad = [
        (Datum::record([("dat", Datum::Bool(true))]), "`dat`"),
        (
            Datum::record([("data", Datum::Bool(true)), ("bogus", Datum::Int(1))]),
            "`bogus`",
        ),
        (data(Datum::Int(5)), "`data`"),
        (Datum::Bool(true), "found a Boolean"),
    ];
    for binding in [LAST, ALL] {
        for (message, place) in &bad {
            let (seen, notices, misfits) =
                taken(binding, &boolean(), std::slice::from_ref(message));
            assert_eq!((seen.len(), misfits), (0, 1), "{message}");
            let [notice] = &*notices else {
                panic!("{notices:?}")
            };
            for part in ["`stop`", "std_msgs/Bool", place, &message.to_string()] {
                assert!(notice.contains(part), "{part}: {notice}");
            }
        }
    }
}

#[test]
fn a_value_outside_of_the_domain_is_refused_with_function_domain_and_value() {
    let number = Schema::record(
        "test/Number",
        vec![OutlineKey::new("data", "", Schema::plain(Shape::I64))],
    );
    let natural = ("Natural", Some("data"), Receive::All);
    let messages = [-1, -1, 7, -2].map(|it| data(Datum::Int(it)));
    let (seen, notices, misfits) = taken(natural, &number, &messages);
    assert_eq!((seen, misfits), (vec!["7".to_owned()], 3));
    let expected = [-1, -2].map(|value| {
        format!(
            "`stop` refuses a message: `input` is of the domain Natural, found {value} in `data`"
        )
    });
    assert_eq!(notices, expected, "each cause once");
}

#[test]
fn causes_are_limited() {
    let messages: Vec<Datum> = (0..40).map(|it| data(Datum::Int(it))).collect();
    let (_, notices, misfits) = taken(ALL, &boolean(), &messages);
    assert!(
        notices.len() == 8 && misfits > 8,
        "{} {misfits}",
        notices.len()
    );
}

#[test]
fn a_message_that_does_not_fit_hides_no_other_one() {
    let last = ("Boolean", Some("data"), Receive::Last);
    let edge = ("Boolean", None, Receive::Edge);
    for binding in [last, edge] {
        let messages = [data(Datum::Bool(true)), data(Datum::Int(5))];
        let (seen, _, misfits) = taken(binding, &boolean(), &messages);
        assert_eq!(
            (seen.last().map(String::as_str), misfits),
            (Some("true"), 1)
        );
    }
}
