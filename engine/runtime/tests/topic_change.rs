//! C18: components of a running system begin and end to publish on topics and to subscribe to them.

use std::sync::{Arc, Mutex};

use crate::common::{Number, behaviour, counter, in_real_time, number};
use asmotion_component::{Activity, Component, Interface, Policy, Span};
use asmotion_runtime::{Change, Run, System};

/// The numbers that a reader has seen.
type Seen = Arc<Mutex<Vec<i64>>>;

fn reader(seen: &Seen) -> impl FnOnce(&mut Interface) -> Box<dyn Component> {
    let seen = Arc::clone(seen);
    behaviour(move |interface| {
        let input = interface.input::<Number>("n", "numbers");
        move |cycle| {
            let all = cycle.all(input).iter().map(|sample| sample.n);
            seen.lock().unwrap().extend(all);
            Ok(())
        }
    })
}

fn publish(output: &str, topic: &str) -> Change {
    Change::Publish {
        output: output.to_owned(),
        topic: topic.to_owned(),
    }
}

fn unpublish(output: &str, topic: &str) -> Change {
    Change::Unpublish {
        output: output.to_owned(),
        topic: topic.to_owned(),
    }
}

fn subscribe(topic: &str, input: &str) -> Change {
    Change::Subscribe {
        input: input.to_owned(),
        topic: topic.to_owned(),
        policy: Policy::buffer(1000),
    }
}

fn unsubscribe(topic: &str, input: &str) -> Change {
    Change::Unsubscribe {
        input: input.to_owned(),
        topic: topic.to_owned(),
    }
}

/// `Counter` publishes on `kept`, which `Witness` reads; `Other` and `Guest` have no topic.
fn system(witness: &Seen, guest: &Seen) -> System {
    let mut system = System::new();
    for name in ["Counter", "Other"] {
        let activity = Activity::periodic(1.ms());
        system.add(name, activity, counter()).unwrap();
    }
    let activity = Activity::periodic(5.ms());
    system
        .add("Witness", activity.clone(), reader(witness))
        .unwrap();
    system.add("Guest", activity, reader(guest)).unwrap();
    system.publish("Counter.n", "kept").unwrap();
    let policy = Policy::buffer(1000);
    system.subscribe("kept", "Witness.n", policy).unwrap();
    system
}

fn topics(run: &mut impl Run, [witness, guest]: [&Seen; 2]) {
    let heard = |seen: &Seen| seen.lock().unwrap().len();
    run.run_for(50.ms());
    let impossible = [
        (
            publish("Counter.n", "new"),
            "`Counter.n` is already connected to topic `kept`",
        ),
        (
            unpublish("Other.n", "kept"),
            "`Other.n` is not connected to `topic kept`",
        ),
        (
            subscribe("kept", "Witness.n"),
            "`Witness.n` is already connected to topic `kept`",
        ),
        (
            unsubscribe("new", "Guest.n"),
            "`Guest.n` is not connected to `topic new`",
        ),
        (
            publish("Other.n", "bus"),
            "`Other.n` cannot publish `bus`: it is reserved for the state of the bus",
        ),
        (
            subscribe("bus", "Guest.n"),
            "`Guest.n` cannot be joined to topic bus: that needs a new start",
        ),
    ];
    for (last, reason) in impossible {
        // what comes before it is taken back
        let changes = [
            publish("Other.n", "more"),
            subscribe("more", "Guest.n"),
            last,
        ];
        assert_eq!(run.change(&changes).unwrap_err().to_string(), reason);
    }
    run.run_for(50.ms());
    assert_eq!(heard(guest), 0);
    for round in 0..2 {
        run.change(&[publish("Other.n", "more"), subscribe("more", "Guest.n")])
            .unwrap();
        run.change(&[subscribe("kept", "Guest.n")]).unwrap();
        let before = heard(guest);
        run.run_for(100.ms());
        assert!(heard(guest) > before + 100, "of both: {round}");
        run.change(&[unsubscribe("kept", "Guest.n"), unpublish("Other.n", "more")])
            .unwrap();
        run.run_for(20.ms());
        let before = heard(guest);
        run.run_for(50.ms());
        assert_eq!(heard(guest), before);
        // what a tool sends to the topic still arrives, until the subscription ends
        let sample = Arc::new(number(-7));
        let now = run.now();
        run.publish_sample(now, "more", sample.clone()).unwrap();
        run.run_for(20.ms());
        assert_eq!(guest.lock().unwrap().last(), Some(&-7));
        run.change(&[unsubscribe("more", "Guest.n")]).unwrap();
        let before = heard(guest);
        let now = run.now();
        run.publish_sample(now, "more", sample).unwrap();
        run.run_for(20.ms());
        assert_eq!(heard(guest), before);
    }
    let numbers = witness.lock().unwrap();
    let expected: Vec<i64> = (numbers[0]..).take(numbers.len()).collect();
    assert_eq!(*numbers, expected, "the other topic loses nothing");
}

#[test]
fn c18_topics_of_components_that_stay_change_while_they_run() {
    let (witness, guest) = (Seen::default(), Seen::default());
    let mut run = system(&witness, &guest).simulate();
    topics(&mut run, [&witness, &guest]);
}

#[test]
fn c18_topics_of_components_that_stay_change_in_real_time() {
    in_real_time(|| {
        let (witness, guest) = (Seen::default(), Seen::default());
        let mut run = system(&witness, &guest).live();
        topics(&mut run, [&witness, &guest]);
    });
}
