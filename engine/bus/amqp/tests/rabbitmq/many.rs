//! Many components on one bus.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Duration;

use asmotion_component::{Activity, Component, Cycle, Fault, Flow, In, Out, Policy, Span, Time};
use asmotion_datum::Datum;
use asmotion_network::Network;
use asmotion_runtime::{Event, Run, System};

use crate::common::{LONG, connect, settings};
use crate::systems::Count;

/// Number of components on one connection.
const MANY: usize = 200;

/// Publishes its number to its neighbour, and reports the number it receives.
struct Neighbour {
    number: i64,
    from: In<Count>,
    to: Out<Count>,
}

impl Component for Neighbour {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        if let Flow::NewData(count) = cycle.read(self.from) {
            let heard = count.count;
            cycle.report("heard", Datum::Int(heard));
        }
        cycle.write(self.to, Count { count: self.number });
        Ok(())
    }
}

#[test]
fn two_hundred_components_talk_over_one_bus() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let mut system = System::new();
    system.leave_topics_to_adapters();
    for n in 0..MANY {
        let neighbour = |interface: &mut asmotion_component::Interface| {
            Box::new(Neighbour {
                number: n as i64,
                from: interface.input("from", "of the one before"),
                to: interface.output("to", "to the next"),
            }) as Box<dyn Component>
        };
        let (name, pace) = (format!("C{n}"), Activity::periodic(500.ms()));
        system.add(&name, pace, neighbour).unwrap();
        let before = format!("ring.{}", (n + MANY - 1) % MANY);
        system
            .publish(&format!("{name}.to"), &format!("ring.{n}"))
            .unwrap();
        system
            .subscribe(&before, &format!("{name}.from"), Policy::data())
            .unwrap();
    }
    let bus = Arc::new(connect(settings(&vhost.url())));
    Network::new().attach(&mut system, bus, 1).unwrap();
    assert_eq!(vhost.queues().unwrap().len(), MANY, "a queue for each");
    let mut run = system.live();
    let mut heard = BTreeSet::new();
    let mut all = |_: Time, event: &Event<'_>| {
        if let Event::Report { data: what, .. } = event {
            heard.extend(what.as_int());
        }
        heard.len() == MANY
    };
    let end = Time::ZERO + 2 * LONG;
    assert!(run.run_until_event(end, &mut all));
    assert_eq!(vhost.connections().unwrap(), 2, "publishers and consumers");
    let channels = vhost.channels().unwrap();
    assert!(
        (2 * MANY..=2 * MANY + 4).contains(&channels),
        "one for each writer and reader, few for the bus: {channels}"
    );
    drop(run);
    std::thread::sleep(Duration::from_millis(100));
    assert_eq!(vhost.connections().unwrap(), 0);
}
