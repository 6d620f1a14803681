//! Orders to a running system: reading and writing ports, describing components, driving the life cycle.

use asmotion_assembly::{CoordinatorOptions, Standard};
use asmotion_component::{Span, State};
use asmotion_datum::Datum;
use asmotion_remote::{LastSamples, Order, OrderKind, OrderOutcome};
use asmotion_runtime::{Run, Simulation};

use crate::driver::{self, BUILD, files, open};

/// A system in simulated time, with the newest samples of its outputs.
struct Driven {
    run: Simulation,
    newest: LastSamples,
}

fn driver() -> Driven {
    let (opened, files) = (open(&[]), files());
    let mut workshop = Standard::new(&BUILD, &files, CoordinatorOptions::seeded(1));
    let plan = opened.plan(None).expect("a plan");
    let mut system = asmotion_assembly::start(plan, &mut workshop).expect("a system");
    let newest = LastSamples::default();
    system.observe(newest.clone());
    let run = system.simulate();
    Driven { run, newest }
}

/// The reply, or the code and explanation of a refusal.
fn order(driven: &mut Driven, component: &str, wish: OrderKind) -> Result<Datum, String> {
    let component = component.to_owned();
    let begun = Order { component, wish }.begin(&mut driven.run, &driven.newest);
    let refused = |code: &str, reason: String| format!("{code}: {reason}");
    match begun.map_err(|error| refused(error.reason().code(), error.to_string()))? {
        OrderOutcome::Done(answer) => Ok(answer),
        OrderOutcome::Watched(port, _) => Ok(Datum::text(port)),
        OrderOutcome::Pending(asked) => match asked.try_take() {
            Some(Ok(())) => Ok(Datum::Null),
            Some(Err(error)) => Err(refused("REFUSED", error.to_string())),
            None => panic!("in simulated time all is done at once"),
        },
    }
}

fn joints(position: [f64; 2]) -> Datum {
    Datum::of(&driver::joints(position)).expect("data")
}

#[test]
fn j13_a_port_is_written_and_read_from_outside() {
    let mut driver = driver();
    let there = joints([0.5, 1.0]);
    let write = OrderKind::Write("commands".to_owned(), there.clone());
    assert_eq!(order(&mut driver, "Driver", write), Ok(Datum::Null));
    driver.run.run_for(20.ms());
    let read = order(&mut driver, "Driver", OrderKind::Read("status".to_owned()));
    assert_eq!(read, Ok(there));
}

#[test]
fn j13_j18_every_way_to_be_wrong_has_its_code_and_harms_nobody() {
    let mut driver = driver();
    driver.run.run_for(20.ms());
    let write = |port: &str, value| OrderKind::Write(port.to_owned(), value);
    let read = |port: &str| OrderKind::Read(port.to_owned());
    let fields = |name: &'static str, value| Datum::record([(name, value)]);
    let nothing = || Datum::Record(Vec::new());
    let refused = [
        order(&mut driver, "Diver", read("status")),
        order(&mut driver, "Driver", read("state")),
        order(&mut driver, "Driver", read("commands")),
        order(&mut driver, "Driver", read("status")),
        order(&mut driver, "Driver", write("command", nothing())),
        order(&mut driver, "Driver", write("status", nothing())),
        order(&mut driver, "Driver", write("commands", Datum::Int(1))),
        order(
            &mut driver,
            "Driver",
            write("commands", fields("positio", Datum::Null)),
        ),
        order(
            &mut driver,
            "Driver",
            write("commands", fields("position", Datum::text("up"))),
        ),
    ];
    let refused: Vec<_> = refused.map(|it| it.expect_err("a refusal")).into();
    insta::assert_snapshot!(refused.join("\n"));
    assert_eq!(driver.run.state("Driver"), Some(State::Running));
}

#[test]
fn j15_what_a_component_declares_is_stable_json() {
    let described = order(&mut driver(), "Driver", OrderKind::Describe).expect("a declaration");
    let text = asmotion_datum::json::encode_pretty(&described).expect("JSON");
    insta::assert_snapshot!(text);
}

#[test]
fn j8_the_life_cycle_is_driven_from_outside_with_its_guards() {
    let mut driver = driver();
    let mut go = |wish| order(&mut driver, "Driver", wish);
    let refused = go(OrderKind::Cleanup).expect_err("it runs");
    assert!(refused.contains("it is Running"), "{refused}");
    for wish in [
        OrderKind::Stop,
        OrderKind::Cleanup,
        OrderKind::Configure,
        OrderKind::Start,
    ] {
        assert_eq!(go(wish.clone()), Ok(Datum::Null), "{wish:?}");
    }
    for wish in [OrderKind::Reset, OrderKind::Recover] {
        let refused = go(wish).expect_err("it is well");
        assert!(refused.contains("it is Running"), "{refused}");
    }
    assert_eq!(driver.run.state("Driver"), Some(State::Running));
}
