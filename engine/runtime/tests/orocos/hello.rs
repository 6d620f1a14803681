//! O1: a component with everything that a TaskContext has.

use asmotion_component::{Span, State};
use asmotion_runtime::Run;

#[path = "../../examples/hello.rs"]
#[allow(dead_code, reason = "the example's main, which is for people")]
mod example;

use example::{Greet, Words};

fn words(words: &str) -> Words {
    let words = words.to_owned();
    Words { words }
}

#[test]
fn o1_hello_world_has_ports_properties_operations_services_and_peers() {
    let mut system = example::system().unwrap();
    let log = asmotion_runtime::Log::new();
    system.observe(log.clone());
    let mut run = system.simulate();
    run.run_for(1.ms());
    let said = |port: &str| -> Vec<String> {
        let samples = log.samples::<Words>(port).into_iter();
        samples.map(|(_, greeting)| greeting.words).collect()
    };
    // peers: each has been greeted by the other, with the other's property
    assert_eq!(said("Ann.greeting"), ["Hello, world!"]);
    assert_eq!(said("Ben.greeting"), ["Good morning, world!"]);

    // ports, and a property that changes
    let salutation = ("salutation".to_owned(), asmotion_datum::Datum::text("Hi"));
    run.set_properties("Ann", &[salutation]).unwrap();
    run.inject(run.now(), "Ann.name", words("Cyd")).unwrap();
    run.run_for(1.ms());
    assert_eq!(said("Ann.greeting"), ["Hello, world!", "Hi, Cyd!"]);

    // an operation of a service, from outside
    let sent = run
        .send::<Greet>("Ben.greeting", words("Dan"), 1.s())
        .unwrap();
    assert_eq!(run.collect(sent).unwrap().words, "Hello, Dan!");

    // everything is visible from outside, including the peers
    assert_eq!(run.components(), ["Ann", "Ben"]);
    assert_eq!(run.state("Ann"), Some(State::Running));
    let declared = run.declaration("Ann").unwrap();
    assert!(declared.input("name").is_some() && declared.output("greeting").is_some());
    assert_eq!(
        declared.property("salutation").unwrap().doc,
        "first word of the greeting"
    );
    let service = declared.service("greeting").unwrap();
    let peer = declared.reference("peer").unwrap();
    assert_eq!(service.operations[0].name, "greet");
    assert_eq!(peer.interface, service.interface);
}
