//! Two components that greet: each with ports, a property, an operation of a service, and the other as its peer.
//!
//! `cargo run -p asmotion-runtime --example hello`

#![allow(clippy::print_stdout, reason = "an example prints its result")]

use asmotion_component::{
    Activity, Component, Cycle, Fault, In, Interface, Operation, Out, Property, Provided, Required,
    Span, Wire,
};
use asmotion_runtime::{BuildError, Log, Run, System};

asmotion_datum::message! {
    /// A greeting, or the name of the one to greet.
    pub struct Words = "hello/Words" {
        /// Free text.
        pub words: String,
    }
}

/// Returns the greeting for a name.
pub struct Greet;

impl Operation for Greet {
    type Request = Words;
    type Response = Words;
    const INTERFACE: &'static str = "hello/Greeting";
    const NAME: &'static str = "greet";
}

/// Greets the names that arrive on its port or through its service, and asks its peer once to greet the world.
pub struct Hello {
    name: In<Words>,
    greeting: Out<Words>,
    salutation: Property<String>,
    greet: Provided<Greet>,
    peer: Required<Greet>,
}

impl Hello {
    /// Declares the ports, the service, the reference and the property; a constructor for [`System::add`].
    pub fn declare(interface: &mut Interface) -> Box<dyn Component> {
        Box::new(Self {
            name: interface.input("name", "name to greet"),
            greeting: interface.output("greeting", "the greeting"),
            salutation: interface.property(
                "salutation",
                "Hello".to_owned(),
                "first word of the greeting",
            ),
            greet: interface.serve("greeting", "greets by name"),
            peer: interface.require("peer", "peer that greets, too"),
        })
    }
}

impl Component for Hello {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        let salutation = cycle.property(self.salutation);
        let greeting = |name: &Words| Words {
            words: format!("{salutation}, {}!", name.words),
        };
        for name in cycle.all(self.name).to_vec() {
            cycle.write(self.greeting, greeting(&name));
        }
        for request in cycle.requests(self.greet) {
            cycle.reply(self.greet, request.id, Ok(greeting(&request.argument)));
        }
        if cycle.number() == 1 {
            let words = "world".to_owned();
            cycle.call(self.peer, Words { words });
        }
        for reply in cycle.replies(self.peer) {
            cycle.write(self.greeting, reply.result?);
        }
        Ok(())
    }
}

/// Creates two peers, Ann and Ben. Ben greets every name that Ann's greeting port writes.
///
/// # Errors
/// An error if two components have the same name or connected ends do not match, which does not occur here.
pub fn system() -> Result<System, BuildError> {
    let mut system = System::new();
    let ann = system.add("Ann", Activity::event(), Hello::declare)?;
    system.add("Ben", Activity::event(), Hello::declare)?;
    system.set_property(
        ann,
        "salutation",
        &asmotion_datum::Datum::text("Good morning"),
    )?;
    system.wire("Ann.peer", "Ben.greeting", Wire::default())?;
    system.wire("Ben.peer", "Ann.greeting", Wire::default())?;
    system.publish("Ann.greeting", "greetings")?;
    Ok(system)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let log = Log::new();
    let mut system = system()?;
    system.observe(log.clone());
    let mut run = system.simulate();
    run.inject(
        run.now(),
        "Ann.name",
        Words {
            words: "Cyd".into(),
        },
    )?;
    run.run_for(1.ms());
    for line in log.lines_with("greeting #") {
        println!("{line}");
    }
    Ok(())
}
