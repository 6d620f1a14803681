//! A connection to the broker that goes silent without being closed: half-open TCP.

use std::thread;
use std::time::{Duration, Instant};

use asmotion_broker::Line;
use asmotion_bus::{Bus, PublishOptions, QueuePolicy};

use crate::common::{
    LONG, all, connect, events, eventually, is_down, number, numbers, publisher, quick, subscribe,
};

#[test]
fn a_line_that_goes_silent_is_given_up_and_taken_up_again_without_a_loss() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let line = Line::to(broker.address()).unwrap();
    let mut behind = quick(&vhost.url());
    behind.port = line.port();
    behind.timing.connect = Duration::from_secs(2);
    let (writer, reader) = (connect(behind), connect(quick(&vhost.url())));
    let subscription = subscribe(&reader, "events", all(1000));
    let state = subscribe(&reader, "state", QueuePolicy::Latest);
    let mut events = publisher(&writer, "events", events());
    let mut states = publisher(&writer, "state", PublishOptions::state());
    let mut dropped = publisher(&writer, "dropped", PublishOptions::default());
    for n in 0..100 {
        events.publish(0, number(n)).unwrap();
    }
    assert!(writer.drain(LONG));

    line.cut(true);
    let begun = Instant::now();
    eventually("it is noticed", || is_down(&writer));
    assert!(begun.elapsed() < Duration::from_secs(5), "{begun:?}");
    for n in 100..200 {
        events.publish(0, number(n)).unwrap();
        // the newest message is kept, and replacing another one is no error
        states.publish(0, number(n)).unwrap();
        assert!(dropped.publish(0, number(n)).is_err());
    }
    assert_eq!(
        (events.counts().pending(), dropped.counts().dropped),
        (100, 100)
    );
    // long enough to give up the connection, and to fail to open others
    thread::sleep(Duration::from_secs(6));
    assert!(is_down(&writer));

    line.cut(false);
    eventually("it is back", || writer.health().is_up());
    assert!(writer.drain(LONG));
    let silence = Duration::from_secs(1);
    assert_eq!(
        numbers(&subscription, silence),
        (0..200).collect::<Vec<_>>()
    );
    assert_eq!(numbers(&state, silence), [199]);
}
