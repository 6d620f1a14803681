use std::time::Duration;

use asmotion_component::{CallError, CallId, Time};
use asmotion_messages::Bool;
use asmotion_runtime::Event;

use super::Story;

/// What the story says about a sequence of attempts, each a call and the number of its attempt, and of ends of calls.
fn told(events: &[(u64, Option<u32>)]) -> (Vec<bool>, u64) {
    let mut story = Story::default();
    let sample = Bool::default();
    let mut told = Vec::new();
    for (call, attempt) in events {
        let call = CallId(*call);
        let (component, reference, operation) = ("Courier", "dispatcher", "ask");
        let event = match attempt {
            Some(attempt) => Event::Called {
                component,
                reference,
                operation,
                call,
                attempt: *attempt,
                argument: &sample,
            },
            None => Event::Replied {
                component,
                reference,
                operation,
                call,
                result: Err(&CallError::Timeout),
            },
        };
        // far apart, so that no entry is a repetition
        let at = Time::from_nanos(i64::try_from(told.len()).unwrap() * 3_600_000_000_000);
        told.push(story.report(at, &event).is_some());
    }
    let counted = story
        .summary()
        .calls
        .0
        .iter()
        .map(|(_, count)| *count)
        .sum();
    (told, counted)
}

#[test]
fn a_call_is_told_once_whatever_number_of_bindings_it_takes() {
    let (told, counted) = told(&[
        (1, Some(1)),
        (1, Some(1)), // another binding
        (2, Some(1)),
        (1, Some(1)), // another binding, after a newer call
        (1, Some(2)), // again
        (1, Some(2)), // again, at another binding
        (1, Some(3)),
        (1, None),
        (2, Some(2)),
        (3, Some(1)),
    ]);
    let expected = [
        true, false, true, false, true, false, true, true, true, true,
    ];
    assert_eq!((told.as_slice(), counted), (expected.as_slice(), 3));
}

#[test]
fn losses_that_go_on_are_told_at_growing_intervals_and_at_the_end() {
    let mut story = Story::default();
    let mut told = Vec::new();
    // two listeners that are not there, ten times a second
    for tick in 1..=370_u64 {
        for to in ["Locomotor.notify", "Operator.notify"] {
            let dropped = Event::Dropped {
                component: "Driver",
                port: "",
                to,
                total: tick,
                reason: None,
            };
            let at = Time::ZERO + Duration::from_millis(100 * tick);
            told.extend(story.report(at, &dropped));
        }
    }
    let of = |to: &str, lines: &[String]| {
        let lines = lines.iter().filter(|line| line.contains(to));
        let totals = lines.filter_map(|line| line.split_once(": ")?.1.split(' ').next());
        totals.map(str::to_owned).collect::<Vec<_>>()
    };
    for to in ["Locomotor.notify", "Operator.notify"] {
        assert_eq!(of(to, &told), ["1", "21", "61", "141", "301"]);
    }
    let last = story.last_changes();
    assert_eq!(of("", &last), ["370", "370"], "{last:?}");
}
