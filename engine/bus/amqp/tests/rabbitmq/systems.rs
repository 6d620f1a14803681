//! Two systems, as two processes would be: their topics meet on a broker.

use std::sync::Arc;
use std::time::Duration;

use component::{
    Activity, Component, Cycle, Event, Fault, In, Out, Policy, Run, Span, System, Time,
};
use datum::Datum;

use crate::common::{connect, events, settings};

datum::message! {
    /// A count.
    pub struct Count = "test/Count" {
        /// so far
        pub count: i64,
    }
}

/// Counts, one a cycle.
struct Counter {
    count: i64,
    out: Out<Count>,
}

impl Component for Counter {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        self.count += 1;
        cycle.write(self.out, Count { count: self.count });
        Ok(())
    }
}

/// Reports what it reads.
struct Teller(In<Count>);

impl Component for Teller {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        let heard: Vec<_> = cycle.all(self.0).iter().map(|count| count.count).collect();
        for count in heard {
            cycle.report("heard", Datum::Int(count));
        }
        Ok(())
    }
}

#[test]
fn events_between_two_systems_outlive_the_broker() {
    let Some(broker) = broker::alone() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let (supervisor, robot) = (
        connect(settings(&vhost.url())),
        connect(settings(&vhost.url())),
    );

    let mut on_board = System::new();
    let counter = |interface: &mut component::Interface| {
        let out = interface.output("out", "the count");
        Box::new(Counter { count: 0, out }) as Box<dyn Component>
    };
    (on_board.add("Counter", Activity::periodic(20.ms()), counter)).unwrap();
    on_board.publish("Counter.out", "counts").unwrap();
    on_board.sending("counts", events());
    on_board.attach(Arc::new(robot), 1).unwrap();

    let mut above = System::new();
    let teller = |interface: &mut component::Interface| {
        Box::new(Teller(interface.input("in", "counts"))) as Box<dyn Component>
    };
    above.add("Teller", Activity::event(), teller).unwrap();
    (above.subscribe("counts", "Teller.in", Policy::buffer(1000))).unwrap();
    above.attach(Arc::new(supervisor), 2).unwrap();

    let (mut above, on_board) = (above.live(), on_board.live());
    let mut heard = Vec::new();
    let mut until = |count: usize, heard: &mut Vec<i64>| {
        let mut enough = |_: Time, event: &Event<'_>| {
            if let Event::Report {
                kind: "heard",
                what,
                ..
            } = event
            {
                heard.extend(what.as_int());
            }
            heard.len() >= count
        };
        above.run_until_event(Time::ZERO + Duration::from_secs(120), &mut enough)
    };
    assert!(until(20, &mut heard));
    broker.kill().unwrap();
    std::thread::sleep(Duration::from_millis(300));
    broker.revive().unwrap();
    assert!(until(300, &mut heard));
    drop(on_board);
    let counted: Vec<_> = (1..=i64::try_from(heard.len()).unwrap()).collect();
    assert_eq!(heard, counted, "none lost, none twice, in order");
}
