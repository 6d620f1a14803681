//! Numbers of states and transitions that independent checkers agree on: Spin, TLC, Rumur and Stateright count as many.

use crate::{verdicts, verified};
use asmotion_verify::Options;

fn shared(name: &str) -> Option<String> {
    let path = asmotion_skip::shared(&format!("verify/{name}"))?;
    Some(std::fs::read_to_string(path).unwrap())
}

#[test]
fn peterson_has_the_known_number_of_states() {
    let Some(five) = shared("pet.asm") else {
        return;
    };
    for (processes, states) in [(3, 705), (4, 14_844)] {
        let last = processes - 1;
        let text = five
            .replace("domain Pid = {0:4}", &format!("domain Pid = {{0:{last}}}"))
            .replace("j($i)<4", &format!("j($i)<{last}"));
        let verification = verified(&text, &Options::default());
        assert_eq!(verification.states, states, "{processes} processes");
    }
    let verification = verified(&five, &Options::default());
    assert_eq!(
        (verification.states, verification.transitions),
        (344_805, 1_205_326)
    );
}

#[test]
fn philosophers_have_the_known_number_of_states() {
    let Some(sixteen) = shared("phil.asm") else {
        return;
    };
    // the trace of the tenth power of the transfer matrix
    let ten = sixteen
        .replace("{0:15}", "{0:9}")
        .replace("mod 16", "mod 10");
    let verification = verified(&ten, &Options::default());
    assert_eq!(verification.states, 6726);
    assert!(verdicts(&verification).contains(&("no state is stuck".to_owned(), "violated")));
}
