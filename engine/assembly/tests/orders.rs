//! Orders to a running system: ports are read and written, shapes described, the life cycle is driven.
#![allow(missing_docs, clippy::expect_used, clippy::panic, reason = "tests")]

use assembly::order::{Begun, Newest, Order, Wish};
use component::{
    Activity, Component, Cycle, Fault, In, Operation, Out, Property, Provided, Run, Simulation,
    Span, State, System,
};
use datum::Datum;

datum::message! {
    /// Where the joints are.
    pub struct Joints = "test/Joints" {
        /// radians
        pub position: [f64; 2],
    }
}

struct Mirror;

impl Operation for Mirror {
    type Request = Joints;
    type Response = Joints;
    const INTERFACE: &'static str = "test/Mirror";
    const NAME: &'static str = "mirror";
}

/// Says where it was told to go.
struct Driver {
    commands: In<Joints>,
    status: Out<Joints>,
    _scale: Property<f64>,
    _mirror: Provided<Mirror>,
}

impl Component for Driver {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        if let Some(joints) = cycle.read(self.commands).new().cloned() {
            cycle.write(self.status, joints);
        }
        Ok(())
    }
}

fn driver() -> (Simulation, Newest) {
    let mut system = System::new();
    let added = system.add("Driver", Activity::periodic(10.ms()), |interface| {
        Box::new(Driver {
            commands: interface.input("commands", "where to go"),
            status: interface.output("status", "where it is"),
            _scale: interface.property("scale", 1.0, "of all that is told"),
            _mirror: interface.serve("mirror", "turned about"),
        })
    });
    added.expect("a component");
    let newest = Newest::default();
    system.observe(newest.clone());
    (system.simulate(), newest)
}

/// What is answered, or the code and the words of a refusal.
fn order(
    (run, newest): &mut (Simulation, Newest),
    component: &str,
    wish: Wish,
) -> Result<Datum, String> {
    let component = component.to_owned();
    let begun = Order { component, wish }.begin(run, newest);
    let refused = |code: &str, reason: String| format!("{code}: {reason}");
    match begun.map_err(|error| refused(error.code(), error.to_string()))? {
        Begun::Done(answer) => Ok(answer),
        Begun::Asked(asked) => match asked.try_take() {
            Some(Ok(())) => Ok(Datum::Null),
            Some(Err(error)) => Err(refused("REFUSED", error.to_string())),
            None => panic!("in simulated time all is done at once"),
        },
    }
}

fn joints(position: [f64; 2]) -> Datum {
    Datum::of(&Joints { position }).expect("data")
}

#[test]
fn j13_a_port_is_written_and_read_from_outside() {
    let mut driver = driver();
    let there = joints([0.5, 1.0]);
    let write = Wish::Write("commands".to_owned(), there.clone());
    assert_eq!(order(&mut driver, "Driver", write), Ok(Datum::Null));
    driver.0.run_for(20.ms());
    let read = order(&mut driver, "Driver", Wish::Read("status".to_owned()));
    assert_eq!(read, Ok(there));
}

#[test]
fn j13_j18_every_way_to_be_wrong_has_its_code_and_harms_nobody() {
    let mut driver = driver();
    driver.0.run_for(20.ms());
    let write = |port: &str, value| Wish::Write(port.to_owned(), value);
    let read = |port: &str| Wish::Read(port.to_owned());
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
    assert_eq!(driver.0.state("Driver"), Some(State::Running));
}

#[test]
fn j15_what_a_component_declares_is_stable_json() {
    let described = order(&mut driver(), "Driver", Wish::Describe).expect("a declaration");
    let text = datum::json::encode_pretty(&described).expect("JSON");
    insta::assert_snapshot!(text);
}

#[test]
fn j8_the_life_cycle_is_driven_from_outside_with_its_guards() {
    let mut driver = driver();
    let mut go = |wish| order(&mut driver, "Driver", wish);
    let refused = go(Wish::Cleanup).expect_err("it runs");
    assert!(refused.contains("it is Running"), "{refused}");
    for wish in [Wish::Stop, Wish::Cleanup, Wish::Configure, Wish::Start] {
        assert_eq!(go(wish.clone()), Ok(Datum::Null), "{wish:?}");
    }
    for wish in [Wish::Reset, Wish::Recover] {
        let refused = go(wish).expect_err("it is well");
        assert!(refused.contains("it is Running"), "{refused}");
    }
    assert_eq!(driver.0.state("Driver"), Some(State::Running));
}
