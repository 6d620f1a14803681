//! Numbers of states and transitions that independent checkers agree on: Spin, TLC, Rumur and Stateright count as many.
//!
//! The models with their full sizes are counted by `cargo bench -p asmotion-verify --bench spin`, also in every storage and with several
//! threads.

use crate::storage::{ENOUGH, Limited};
use crate::{verdicts, verified};
use asmotion_verify::{Options, Storage};

/// A model of `../shared/verify`, with texts replaced: smaller domains.
fn model(name: &str, replaced: &[(&str, &str)]) -> Option<String> {
    let path = asmotion_skip::shared(&format!("verify/{name}.asm"))?;
    let mut text = std::fs::read_to_string(path).unwrap();
    for (from, to) in replaced {
        assert!(text.contains(from), "{name} has no {from}");
        text = text.replace(from, to);
    }
    Some(text)
}

/// Verifies a model in every storage, with one to three threads, in grounded form and by a machine.
fn is_counted(text: &str, states: u64, transitions: u64, is_smaller_than_its_fingerprint: bool) {
    for without_grounding in [false, true] {
        for threads in [1, 2, 3] {
            for storage in [Storage::Exact, Storage::Compact, Limited::of(ENOUGH)] {
                let options = Options {
                    threads,
                    storage,
                    without_grounding,
                    ..Options::default()
                };
                let found = verified(text, &options);
                let shown = format!(
                    "{threads} threads, {:?}, grounded: {}",
                    options.storage, found.is_grounded
                );
                assert_eq!(found.is_grounded, !without_grounding, "{shown}");
                assert_eq!(
                    (found.states, found.transitions),
                    (states, transitions),
                    "{shown}"
                );
                let is_compact = matches!(options.storage, Storage::Compact)
                    && (without_grounding || !is_smaller_than_its_fingerprint);
                assert_eq!(found.expected_missed.is_some(), is_compact, "{shown}");
            }
        }
    }
}

#[test]
fn peterson_has_the_known_number_of_states() {
    let Some(five) = model("pet", &[]) else {
        return;
    };
    // the transitions were counted by Spin
    for (processes, states, transitions) in [(3, 705, None), (4, 14_844, Some(44_121))] {
        let last = processes - 1;
        let text = five
            .replace("domain Pid = {0:4}", &format!("domain Pid = {{0:{last}}}"))
            .replace("j($i)<4", &format!("j($i)<{last}"));
        let found = verified(&text, &Options::default());
        assert_eq!(found.states, states, "{processes} processes");
        let transitions = transitions.unwrap_or(found.transitions);
        is_counted(&text, states, transitions, true);
    }
    let found = verified(&five, &Options::default());
    assert_eq!((found.states, found.transitions), (344_805, 1_205_326));
}

#[test]
fn philosophers_have_the_known_number_of_states() {
    let ten = [("{0:15}", "{0:9}"), ("mod 16", "mod 10")];
    let Some(text) = model("phil", &ten) else {
        return;
    };
    // the trace of the tenth power of the transfer matrix; transitions as counted by Spin
    is_counted(&text, 6726, 43_481, true);
    let found = verified(&text, &Options::default());
    assert!(verdicts(&found).contains(&("no state is stuck".to_owned(), "violated")));
}

#[test]
fn philosophers_in_states_of_several_words_are_as_many() {
    // 20 bits for what 2 bits are enough for
    let wide = [
        ("{0:15}", "{0:7}"),
        ("mod 16", "mod 8"),
        ("Pc = {0:2}", "Pc = {0:1000000}"),
        ("pc($i):=2", "pc($i):=1000000"),
    ];
    let Some(text) = model("phil", &wide) else {
        return;
    };
    is_counted(&text, 1154, 5969, false);
}

#[test]
fn commits_have_the_known_number_of_states() {
    for (managers, states, transitions) in [(3, 288, None), (5, 8832, Some(58_146))] {
        let domain = format!("Pid = {{0:{}}}", managers - 1);
        let Some(text) = model("tpc", &[("Pid = {0:7}", &domain)]) else {
            return;
        };
        let counted = verified(&text, &Options::default()).transitions;
        is_counted(&text, states, transitions.unwrap_or(counted), true);
    }
}

#[test]
fn a_queue_has_the_known_number_of_states() {
    // a queue for 3 elements of 3 values, 2 producers and a consumer
    let small = [
        ("Sel = {0:4}", "Sel = {0:2}"),
        ("Idx = {0:5}", "Idx = {0:2}"),
        ("Len = {0:6}", "Len = {0:3}"),
        ("len<6", "len<3"),
        ("$p<3", "$p<2"),
        ("q(5):=3", "q(2):=3"),
        ("      q(2):=q(3)\n      q(3):=q(4)\n      q(4):=q(5)\n", ""),
    ];
    let Some(text) = model("queue", &small) else {
        return;
    };
    let contents: u64 = (0..=3).map(|length| 3u64.pow(length)).sum();
    let states = contents * 4u64.pow(3);
    assert_eq!(states, 2560);
    is_counted(&text, states, 7633, true);
}
