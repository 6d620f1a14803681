//! Components of the field on the bench: a driver, a planner, and components with defects.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

use std::path::Path;
use std::time::Duration;

use asmotion_bench::{Bench, BenchError};
use asmotion_component::{
    Component, Cycle, Fault, In, Interface, Operation, Out, Ports, Properties, PropertySet,
    Provided, Required, SendStatus, ServiceFault, Setup, State,
};
use asmotion_datum::Datum;

asmotion_datum::message! {
    /// A number.
    pub struct Number = "test/Number" {
        /// no unit
        pub value: f64,
    }
}

/// Doubles a number.
struct Double;

impl Operation for Double {
    type Request = Number;
    type Response = Number;
    const INTERFACE: &'static str = "test/Double";
    const NAME: &'static str = "double";
}

#[derive(Ports)]
struct MultiplierPorts {
    /// Numbers to multiply.
    number: In<Number>,
    /// Each number times `factor`, up to 100.
    product: Out<Number>,
    /// Doubles the last number.
    last: Provided<Double>,
    /// Doubles a number for this component.
    #[port(optional)]
    helper: Required<Double>,
}

#[derive(Properties)]
struct MultiplierProperties {
    /// Factor of the products.
    #[property(range = 0.0..=10.0, default = 3.0)]
    factor: f64,
}

/// Multiplies numbers, and has those above 100 doubled by another component.
struct Multiplier {
    ports: MultiplierPorts,
    properties: PropertySet<MultiplierProperties>,
    last: f64,
}

impl Multiplier {
    fn new(interface: &mut Interface) -> Self {
        Self {
            ports: interface.ports(),
            properties: interface.properties(),
            last: 0.0,
        }
    }
}

impl Component for Multiplier {
    fn configure(&mut self, setup: &mut Setup<'_>) -> Result<(), Fault> {
        self.properties.refresh(setup);
        match self.properties.factor {
            0.0 => Err(Fault::new("a factor of zero loses the number")),
            _ => Ok(()),
        }
    }

    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        self.properties.refresh(cycle);
        for number in cycle.all(self.ports.number).to_vec() {
            if number.value.is_nan() {
                return Err(Fault::new("not a number"));
            }
            self.last = number.value;
            let value = number.value * self.properties.factor;
            if value > 100.0 {
                cycle.call(self.ports.helper, Number { value });
            } else {
                cycle.write(self.ports.product, Number { value });
            }
        }
        for request in cycle.requests(self.ports.last) {
            let value = 2.0 * self.last + request.argument.value;
            cycle.reply(self.ports.last, request.id, Ok(Number { value }));
        }
        for reply in cycle.replies(self.ports.helper) {
            match reply.result {
                Ok(product) => cycle.write(self.ports.product, product),
                Err(error) => cycle.report("helper", Datum::text(error.to_string())),
            }
        }
        Ok(())
    }
}

fn values(numbers: Vec<Number>) -> Vec<f64> {
    numbers.into_iter().map(|number| number.value).collect()
}

#[test]
fn samples_properties_and_time() {
    let mut bench = Bench::new(Multiplier::new);
    bench.period(Duration::from_millis(20)).set("factor", 4.0);
    let cycle = bench
        .give("number", Number { value: 1.0 })
        .give_datum("number", Datum::record([("value", Datum::Float(2.0))]))
        .cycle()
        .unwrap();
    assert_eq!(values(cycle.outputs("product")), [4.0, 8.0]);
    assert_eq!(cycle.written()[0].0, "product");
    bench.set("factor", 5.0);
    let cycle = bench.give("number", Number { value: 1.0 }).cycle().unwrap();
    assert_eq!(cycle.output::<Number>("product").unwrap().value, 5.0);
    assert_eq!(cycle.at.nanos(), 20_000_000);
    assert_eq!(cycle.state, State::Running);
    assert!(bench.cycle().unwrap().written().is_empty());
    assert_eq!(bench.stop().unwrap().state, State::Stopped);
}

#[test]
fn recorded_inputs() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("numbers.csv");
    let table =
        "time_s,Source.number.value\n0.000000000,1\n0.020000000,2\n0.025000000,3\n0.030000000,4\n";
    std::fs::write(&file, table).unwrap();
    let mut bench = Bench::new(Multiplier::new);
    bench.give_recorded("number", &file, "Source.number");
    let cycles = bench.run_for(Duration::from_millis(35)).unwrap();
    let products = cycles.iter().map(|it| values(it.outputs("product")));
    let expected = [vec![3.0], vec![], vec![6.0], vec![9.0, 12.0]];
    assert!(products.eq(expected), "{cycles:?}");
    let error = |input: &str, file: &Path, port: &str| {
        let mut bench = Bench::new(Multiplier::new);
        let error = bench.give_recorded(input, file, port).cycle().unwrap_err();
        error.to_string()
    };
    assert!(error("nummer", &file, "Source.number").contains("did you mean `Tested.number`"));
    assert!(error("number", &file, "Source.nummer").contains("no port `Source.nummer`"));
    let missing = folder.path().join("missing.csv");
    let missing = error("number", &missing, "Source.number");
    assert!(
        missing.contains("missing.csv: cannot be read: No such file"),
        "{missing}"
    );
}

#[test]
fn calls_in_both_directions() {
    let mut bench = Bench::new(Multiplier::new);
    let mut asked = Vec::new();
    let (sender, receiver) = std::sync::mpsc::channel();
    bench.answer::<Double>("helper", move |number| {
        sender.send(number.value).unwrap();
        Ok(Number {
            value: 2.0 * number.value,
        })
    });
    let cycle = bench
        .give("number", Number { value: 50.0 })
        .cycle()
        .unwrap();
    assert_eq!(cycle.calls[0].operation, "double");
    assert_eq!(
        cycle.calls[0].argument,
        Datum::record([("value", Datum::Float(150.0))])
    );
    assert!(cycle.written().is_empty());
    assert_eq!(
        bench
            .cycle()
            .unwrap()
            .output::<Number>("product")
            .unwrap()
            .value,
        300.0
    );
    asked.extend(receiver.try_iter());
    assert_eq!(asked, [150.0]);
    let mut call = bench.call::<Double>("last", Number { value: 1.0 }).unwrap();
    assert_eq!(call.collect_if_done(), SendStatus::NotReady);
    bench.cycle().unwrap();
    assert_eq!(
        call.collect_if_done(),
        SendStatus::Success(Number { value: 101.0 })
    );
}

#[test]
fn a_refused_and_an_unanswered_call() {
    let mut bench = Bench::new(Multiplier::new);
    bench.answer::<Double>("helper", |_| {
        Err(ServiceFault::new("TOO_LARGE", "over 300"))
    });
    bench
        .give("number", Number { value: 90.0 })
        .cycle()
        .unwrap();
    let cycle = bench.cycle().unwrap();
    assert_eq!(cycle.reports[0].0, "helper");
    assert!(
        cycle.reports[0].1.as_text().unwrap().contains("TOO_LARGE"),
        "{cycle:?}"
    );
    let mut silent = Bench::new(Multiplier::new);
    silent.period(Duration::from_millis(600));
    silent
        .give("number", Number { value: 90.0 })
        .cycle()
        .unwrap();
    silent.cycle().unwrap();
    let cycle = silent.cycle().unwrap();
    assert!(
        cycle.reports[0].1.as_text().unwrap().contains("deadline"),
        "{cycle:?}"
    );
}

#[test]
fn a_fault_discards_the_cycle_and_ends_the_component() {
    let mut bench = Bench::new(Multiplier::new);
    let cycle = bench
        .give("number", Number { value: 1.0 })
        .give("number", Number { value: f64::NAN })
        .cycle()
        .unwrap();
    assert!(cycle.written().is_empty());
    assert_eq!(cycle.fault.unwrap().to_string(), "not a number");
    let error = bench.cycle().unwrap_err();
    assert_eq!(
        error.to_string(),
        "the component does not run, it is Exception: not a number"
    );
}

#[test]
fn mistakes_of_a_test_are_named() {
    let mut bench = Bench::new(Multiplier::new);
    let error = bench.give("nummer", Number::default()).cycle().unwrap_err();
    assert!(
        error.to_string().contains("did you mean `Tested.number`"),
        "{error}"
    );
    let error = Bench::new(Multiplier::new)
        .set("factor", 11.0)
        .cycle()
        .unwrap_err();
    assert!(error.to_string().contains("10"), "{error}");
    let error = Bench::new(Multiplier::new)
        .set("faktor", 1.0)
        .cycle()
        .unwrap_err();
    assert!(error.to_string().contains("factor"), "{error}");
    // as a test shows it that returns the error
    assert_eq!(format!("{error:?}"), error.to_string());
    assert!(bench.call::<Double>("lost", Number::default()).is_err());
    let zero = Bench::new(Multiplier::new).set("factor", 0.0).cycle();
    assert!(
        matches!(&zero, Err(BenchError::NotRunning { fault: Some(_), .. })),
        "{zero:?}"
    );
    let twice = Bench::new(|interface| {
        let first: In<Number> = interface.input("number", "");
        let _: In<Number> = interface.input("number", "");
        let ports = interface.ports::<MultiplierPorts>();
        let _ = (first, ports);
        Multiplier::new(interface)
    })
    .cycle();
    assert!(
        twice
            .unwrap_err()
            .to_string()
            .contains("duplicate input `number`")
    );
}
