//! What is known of commands: where they came from, and what became of them.

use asmotion_component::Time;
use asmotion_monitor::BearerToken;
use asmotion_remote::{CommandOutcome, CommandRecord};
use serde_json::{Value, json};

use crate::{Client, Fixture};

fn order(id: u64, component: &str, wish: &str) -> Value {
    json!({ "type": "order", "id": id, "component": component, "wish": wish })
}

fn arm(client: &mut Client, take: bool) -> Value {
    client.send(&json!({ "type": "arm", "token": "s3cret", "take": take }));
    client.reply()
}

/// Number, tab, login, words and outcome of commands.
fn told(commands: &[(Time, CommandRecord)]) -> Vec<String> {
    let told = commands.iter().map(|(_, it)| {
        let outcome = match it.outcome {
            CommandOutcome::Asked => "asked",
            CommandOutcome::Done => "done",
            CommandOutcome::Refused => "refused",
            CommandOutcome::Unknown => "unknown",
        };
        format!(
            "{} tab {} {} {outcome}: {}",
            it.number, it.tab, it.login, it.text
        )
    });
    told.collect()
}

#[test]
fn commands_of_two_tabs_are_told_apart_and_refusals_have_their_reasons() {
    let fixture = Fixture::open(|settings| settings.control = Some(BearerToken::new("s3cret")));
    let _orders = fixture.serve_orders();
    let (mut one, mut two) = (fixture.client(), fixture.client());
    // a tab that is not armed, and one that does not know the token
    two.send(&order(1, "Driver", "stop"));
    assert_eq!(two.reply()["type"], "problem");
    two.send(&json!({ "type": "arm", "token": "guess" }));
    assert_eq!(two.reply()["type"], "problem");
    assert_eq!(arm(&mut one, false)["type"], "armed");
    one.send(&order(2, "Driver", "stop"));
    assert_eq!(one.reply()["type"], "done");
    one.send(&order(3, "Refusing", "start"));
    assert_eq!(one.reply()["type"], "problem");
    assert_eq!(arm(&mut two, true)["type"], "armed");
    one.send(&order(4, "Driver", "start"));
    assert_eq!(one.reply()["type"], "problem");

    let commands = fixture.feed.take_commands();
    assert_eq!(
        told(&commands),
        [
            "1 tab 2 no login refused: stop Driver",
            "2 tab 2 no login refused: arm",
            "3 tab 1 token asked: arm",
            "3 tab 1 token done: arm",
            "4 tab 1 token asked: stop Driver",
            "4 tab 1 token done: stop Driver",
            "5 tab 1 token asked: start Refusing",
            "5 tab 1 token refused: start Refusing",
            "6 tab 2 token asked: arm, take over",
            "6 tab 2 token done: arm, take over",
            "7 tab 1 token refused: start Driver",
        ]
    );
    let reasons = commands.iter().map(|(_, it)| it.reason.as_str());
    let reasons: Vec<_> = reasons.filter(|it| !it.is_empty()).collect();
    assert!(reasons[0].contains("not armed"), "{reasons:?}");
    assert!(reasons[1].contains("wrong token"), "{reasons:?}");
    assert_eq!(reasons[2], "not now");
    assert!(reasons[3].contains("not armed"), "{reasons:?}");
    let clients: Vec<_> = commands.iter().map(|(_, it)| &it.client).collect();
    assert!(clients.iter().all(|it| it.starts_with("127.0.0.1:")));
    assert_ne!(clients[0], clients[2]);
    let all = format!("{commands:?}");
    assert!(!all.contains("s3cret") && !all.contains("guess"), "{all}");
    assert!(fixture.feed.take_commands().is_empty());
    // the log says the same, in the order of time
    let mut viewer = fixture.client();
    viewer.subscribe(&["log"]);
    let log = viewer.entries("log");
    assert!(log.contains(&"done: stop Driver".to_owned()), "{log:?}");
    let refused = "refused: start Refusing: not now".to_owned();
    assert!(log.contains(&refused), "{log:?}");
    // a tab that goes while it is armed leaves a word
    drop(two);
    let gone = std::iter::from_fn(|| {
        std::thread::yield_now();
        Some(fixture.feed.take_commands())
    });
    let gone = gone.flatten().next().unwrap();
    assert_eq!(gone.1.tab, 2);
    assert!(gone.1.text.contains("the tab has gone"), "{gone:?}");
}

#[test]
fn what_a_tab_gives_up_and_what_a_browser_with_a_cookie_does_is_told_too() {
    let fixture = Fixture::open(|settings| settings.control = Some(BearerToken::new("s3cret")));
    let own = format!("http://{}", fixture.address());
    let cookie = format!("asmotion-control-{}=s3cret", fixture.address().port());
    let mut client = fixture.connect_with(Some(&own), Some(&cookie)).unwrap();
    assert_eq!(client.next()["known"], true);
    client.send(&json!({ "type": "arm" }));
    assert_eq!(client.reply()["type"], "armed");
    client.send(&json!({ "type": "disarm" }));
    client.send(&json!({ "type": "disarm" }));
    client.send(&order(9, "Driver", "stop"));
    assert_eq!(client.reply()["type"], "problem");
    assert_eq!(
        told(&fixture.feed.take_commands()),
        [
            "1 tab 1 cookie asked: arm",
            "1 tab 1 cookie done: arm",
            "2 tab 1 cookie asked: disarm",
            "2 tab 1 cookie done: disarm",
            "3 tab 1 cookie refused: stop Driver",
        ]
    );
}
