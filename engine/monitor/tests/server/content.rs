//! What tabs receive, and how.

use std::time::{Duration, Instant};

use asmotion_component::Time;
use asmotion_datum::Datum;
use asmotion_monitor::SystemDescription;
use asmotion_runtime::Observer;
use serde_json::{Value, json};
use tungstenite::Message;

use crate::{Fixture, PATIENCE, published};

#[test]
fn every_sample_of_a_chart_arrives_once_and_in_order() {
    let mut fixture = Fixture::open(|_| {});
    let mut client = fixture.client();
    fixture.publish(1);
    client.subscribe_to_every(60.0);
    assert_eq!(client.samples_until(1).0, [1]);
    let (mut seen, mut batches, mut last) = (Vec::new(), 0, 1);
    for burst in [1, 7, 30, 200, 2, 500] {
        (last + 1..=last + burst).for_each(|value| fixture.publish(value));
        last += burst;
        let (samples, count) = client.samples_until(last);
        seen.extend(samples);
        batches += count;
    }
    assert_eq!(seen, (2..=last).collect::<Vec<_>>());
    assert!(batches < 100, "{batches}");
    // one that comes later begins with what is still there, and misses nothing from then on
    let mut late = fixture.client();
    late.subscribe_to_every(60.0);
    let (first, _) = late.samples_until(last);
    assert!(first.len() > 100, "{}", first.len());
    (last + 1..=last + 50).for_each(|value| fixture.publish(value));
    for client in [&mut client, &mut late] {
        let (samples, _) = client.samples_until(last + 50);
        assert_eq!(samples, (last + 1..=last + 50).collect::<Vec<_>>());
    }
}

#[test]
fn a_tab_in_the_background_gets_fewer_frames_and_the_same_samples() {
    let mut fixture = Fixture::open(|_| {});
    let (mut shown, mut hidden) = (fixture.client(), fixture.client());
    fixture.publish(1);
    for (client, max_hz) in [(&mut shown, 60.0), (&mut hidden, 1.0)] {
        client.subscribe_to_every(max_hz);
        client.samples_until(1);
    }
    let begun = Instant::now();
    let (mut frames, mut seen) = (0, Vec::new());
    for value in 2..=60 {
        fixture.publish(value);
        let (samples, batches) = shown.samples_until(value);
        seen.extend(samples);
        frames += batches;
    }
    let (samples, few) = hidden.samples_until(60);
    let seconds = begun.elapsed().as_secs_f64();
    let expected: Vec<i64> = (2..=60).collect();
    assert_eq!((&seen, &samples), (&expected, &expected));
    // 30 and 1 in a second, one more at each end; whatever was asked for, there are no more
    assert_eq!(frames, 59);
    let frames = u32::try_from(frames).unwrap();
    assert!(f64::from(frames) <= 30.0 * seconds + 2.0, "{seconds} s");
    let few = u32::try_from(few).unwrap();
    assert!(f64::from(few) <= seconds + 2.0, "{few} in {seconds} s");
}

#[test]
fn a_frozen_tab_learns_how_many_samples_of_a_chart_are_gone() {
    let mut fixture = Fixture::open(|_| {});
    let mut client = fixture.client();
    fixture.publish(1);
    client.subscribe_to_every(60.0);
    client.samples_until(1);
    (2..=1000).for_each(|value| fixture.publish(value));
    let frame = client.frame_with("batches");
    let first = &frame["batches"]["Driver.odom"];
    let mut known: Vec<Value> = first["samples"].as_array().unwrap().clone();
    let mut missed = first["missed"].as_u64().unwrap();
    while known.last().unwrap()[1] != 1000 {
        let frame = client.frame_with("batches");
        let batch = &frame["batches"]["Driver.odom"];
        known.extend(batch["samples"].as_array().unwrap().iter().cloned());
        missed += batch["missed"].as_u64().unwrap();
    }
    // each of the 999 has arrived, or is counted; a client that reads all the time may miss none
    assert_eq!(known.len() as u64 + missed, 999);
}

#[test]
fn a_tab_is_sent_only_the_part_of_the_log_that_it_asks_for() {
    let mut fixture = Fixture::open(|_| {});
    for number in 1..=400 {
        let colour = ["Red", "blue"][number % 2];
        fixture.report(&format!("{colour} {number}"));
    }
    let mut client = fixture.client();
    // of all that is kept, not only of what a tab receives at first
    client.filter(1, &["RED", "!00"]);
    let found = client.entries("found");
    let is_red = |it: &String| it.starts_with("Red") && !it.contains("00");
    assert_eq!(found.len(), 196);
    assert!(found.iter().all(is_red), "{found:?}");
    fixture.report("blue 401");
    fixture.report("Red 402");
    assert_eq!(client.entries("found"), ["Red 402"]);
    // nothing is an answer as well, and names its question
    client.filter(2, &["green"]);
    let frame = client.frame_with("found");
    assert_eq!(frame["found"], json!({ "filter": 2, "entries": [] }));
    // all of the log continues where it begins for a new tab, and then has everything
    client.subscribe(&["log"]);
    let all = client.entries("log");
    assert_eq!(
        (all.len(), &*all[0], &**all.last().unwrap()),
        (302, "blue 101", "Red 402")
    );
    client.filter(3, &["blue"]);
    assert_eq!(client.entries("found").len(), 201);
    fixture.report("Red 403");
    client.subscribe(&["log"]);
    assert_eq!(client.entries("log"), ["Red 403"]);
}

#[test]
fn a_tab_that_is_frozen_does_not_see_the_past_as_the_present() {
    let mut fixture = Fixture::open(|_| {});
    let mut client = fixture.client();
    client.subscribe(&["Driver.odom", "log"]);
    fixture.publish(0);
    client.frame_with("samples");
    // it acknowledges nothing, while the system continues
    for value in 1..=10_000 {
        fixture.publish(value);
        fixture.report(&format!("entry {value}"));
        if value % 1000 == 0 {
            std::thread::sleep(Duration::from_millis(100));
        }
    }
    let mut frames = Vec::new();
    client
        .0
        .get_ref()
        .set_read_timeout(Some(Duration::from_millis(1500)))
        .unwrap();
    while let Ok(Message::Text(text)) = client.0.read() {
        frames.push(serde_json::from_str::<Value>(&text).unwrap());
    }
    // those of two intervals of 100 ms; the last one asks for an acknowledgement
    assert!(frames.len() <= 8, "{} frames were waiting", frames.len());
    assert_eq!(frames.last().unwrap()["ack"], true);
    client.0.get_ref().set_read_timeout(Some(PATIENCE)).unwrap();
    let last = frames.last().unwrap();
    client.send(&json!({ "type": "ack", "seq": last["seq"] }));
    let newest = client.frame_with("samples");
    assert_eq!(newest["samples"]["Driver.odom"]["data"], 10_000);
    let entries = newest["log"].as_array().unwrap();
    assert_eq!(entries.last().unwrap()["text"], "entry 10000");
    let seen: usize = frames
        .iter()
        .filter_map(|it| Some(it["log"].as_array()?.len()))
        .sum();
    let missed = newest["missed_log"].as_u64().unwrap();
    assert_eq!(seen as u64 + missed + entries.len() as u64, 10_000);
}

#[test]
fn a_tab_whose_socket_is_full_delays_nobody_and_receives_whole_messages() {
    let mut fixture = Fixture::open(|_| {});
    let (mut full, mut other) = (fixture.client(), fixture.client());
    full.subscribe(&["Driver.odom"]);
    other.subscribe(&["Driver.odom", "log"]);
    fixture.publish(1);
    for client in [&mut full, &mut other] {
        client.frame_with("samples");
    }
    // more than the buffers of a connection take
    let large = Datum::text("x".repeat(12 << 20));
    fixture.feed.observe(Time::ZERO, &published(&large));
    other.frame_with("samples");
    for value in 2..=20 {
        fixture.publish(value);
        fixture.report(&format!("entry {value}"));
        let log = other.frame_with("log")["log"].clone();
        assert!(log.to_string().contains(&format!("entry {value}")));
    }
    let begun = Instant::now();
    let mut lengths = Vec::new();
    loop {
        let frame = full.frame_with("samples");
        let data = &frame["samples"]["Driver.odom"]["data"];
        lengths.push(data.as_str().map_or(0, str::len));
        if *data == 20 {
            break;
        }
        assert!(begun.elapsed() < PATIENCE);
    }
    // nothing of what was published meanwhile waited behind the large sample
    assert!(matches!(lengths[..], [0] | [12_582_912, 0]), "{lengths:?}");
}

#[test]
fn the_end_of_a_run_reaches_the_tab() {
    let fixture = Fixture::open(|_| {});
    let mut client = fixture.client();
    client.subscribe(&["log"]);
    fixture.feed.end("reached");
    assert_eq!(client.frame_with("end")["end"], "reached");
    let begun = Instant::now();
    drop(fixture);
    assert!(
        begun.elapsed() < Duration::from_secs(2),
        "a tab delays the end of the run"
    );
}

#[test]
fn a_new_version_of_the_system_reaches_open_tabs() {
    let mut fixture = Fixture::open(|_| {});
    let mut client = fixture.client();
    client.subscribe(&["Driver.odom"]);
    fixture.publish(1);
    client.frame_with("samples");
    let mut version = SystemDescription::default();
    version.name = "second".to_owned();
    fixture.feed.follow(version);
    let greeting = client.reply();
    assert_eq!(
        (&greeting["type"], &greeting["system"]["name"]),
        (&json!("hello"), &json!("second"))
    );
    // the tab subscribes again, and receives what it knew
    client.subscribe(&["Driver.odom"]);
    let samples = client.frame_with("samples");
    assert_eq!(samples["samples"]["Driver.odom"]["data"], 1);
    let (_, system) = fixture.request("/api/system", &fixture.host());
    assert!(system.contains("\"second\""), "{system}");
}

#[test]
fn figures_are_exported_for_prometheus() {
    let mut fixture = Fixture::open(|_| {});
    fixture.feed.describe(presence());
    fixture.publish(1);
    let _tabs = [fixture.client(), fixture.client()];
    let (head, body) = fixture.request("/metrics", &fixture.host());
    assert!(head.contains("text/plain; version=0.0.4"), "{head}");
    for line in [
        "asmotion_component_cycles_total{component=\"A\\\"\\\\\\n\"} 7",
        "asmotion_component_running{component=\"A\\\"\\\\\\n\"} 1",
        "asmotion_component_overruns_total{component=\"A\\\"\\\\\\n\"} 2",
        "asmotion_component_cycle_mean_seconds{component=\"A\\\"\\\\\\n\"} 0.0005",
        "asmotion_output_samples_total{component=\"Driver\",port=\"odom\"} 1",
        "asmotion_link_up{link=\"broker \\\"1\\\"\"} 1",
        "asmotion_dashboard_tabs 2",
        "asmotion_dashboard_viewers 0",
        "asmotion_output_stale{component=\"Driver\",port=\"odom\"} 0",
    ] {
        assert!(body.lines().any(|it| it == line), "{line}\n{body}");
    }
    // each metric has its type once, before its values
    let types: Vec<&str> = body.lines().filter(|it| it.starts_with("# TYPE")).collect();
    let mut unique = types.clone();
    unique.sort_unstable();
    unique.dedup();
    assert_eq!(unique.len(), types.len());
}

fn presence() -> asmotion_remote::Presence {
    asmotion_remote::Presence {
        components: vec![asmotion_remote::PresentComponent {
            name: "A\"\\\n".to_owned(),
            state: "Running".to_owned(),
            cycles: 7,
            overruns: 2,
            cycle_mean_ms: 0.5,
            ..Default::default()
        }],
        ..Default::default()
    }
}
