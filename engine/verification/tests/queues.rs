//! Messages between specifications wait in queues of the size and kind that the composite writes.

use crate::support::{Files, modelled, verified};
use asmotion_verify::{Options, PropertyKind};

/// Says three words, one in each step.
const SENDER: &str = "asm sender
import StandardLibrary
signature:
  enum domain Word = {FIRST | SECOND | THIRD}
  domain Count subsetof Integer
  out said: Word
  controlled next: Count
definitions:
  domain Count = {0 : 3}
  main rule r_Main =
    switch next
      case 0: par said := FIRST next := 1 endpar
      case 1: par said := SECOND next := 2 endpar
      case 2: par said := THIRD next := 3 endpar
      otherwise skip
    endswitch
default init s0:
  function next = 0
";

/// Remembers the words that it hears.
const RECEIVER: &str = "asm receiver
import CTLLibrary
import StandardLibrary
signature:
  enum domain Word = {NOTHING | FIRST | SECOND | THIRD}
  monitored heard: Word
  controlled knows: Word -> Boolean
definitions:
  main rule r_Main = if heard != NOTHING then knows(heard) := true endif
default init s0:
  function knows($w in Word) = false
";

/// A sender that makes four steps between two of the receiver, with these tables of connections.
fn files(connections: &str) -> Files {
    let composite = format!(
        "schema = \"composite/1\"\n[composite]\nname = \"burst\"\n\
         [components.Sender]\nimplementation = {{ asm = \"sender.asm\", main = \"r_Main\" }}\nactivity = {{ period_ms = 25 }}\n\
         ports.out = {{ said = \"std_msgs/String\" }}\n\
         [components.Sender.bind.out]\nsaid = {{ topic = \"said\" }}\n\
         [components.Receiver]\nimplementation = {{ asm = \"receiver.asm\", main = \"r_Main\" }}\nactivity = {{ period_ms = 100 }}\n\
         ports.in = {{ heard = \"std_msgs/String\" }}\n\
         [components.Receiver.bind.monitored]\n\
         heard = {{ topic = \"heard\", receive = \"all\", map = \"data\", none = \"NOTHING\" }}\n{connections}"
    );
    Files::default()
        .with("burst.composite.toml", composite)
        .with("sender.asm", SENDER.to_owned())
        .with("receiver.asm", RECEIVER.to_owned())
}

fn connected(policy: &str) -> Files {
    files(&format!(
        "[[connections]]\nfrom = \"Sender.said\"\nto = \"Receiver.heard\"\npolicy = {policy}\n"
    ))
}

/// Returns the words that the receiver always hears, whoever steps first, and the assumptions of the model.
fn heard(files: &Files) -> (Vec<&'static str>, Vec<String>) {
    let words = ["FIRST", "SECOND", "THIRD"];
    let model = modelled(files, "burst.composite.toml", "Receiver");
    let assumptions = model.environment.assumptions.clone();
    let options = Options {
        properties: words.map(|word| format!("af(knows({word}))")).to_vec(),
        ..Options::default()
    };
    let found = verified(model, &options);
    assert_eq!(found.incomplete, None);
    let stated = found
        .properties
        .iter()
        .filter(|it| it.kind == PropertyKind::Ctl);
    let heard = words.into_iter().zip(stated);
    let heard = heard.filter(|(_, property)| property.verdict.holds());
    (heard.map(|(word, _)| word).collect(), assumptions)
}

#[test]
fn a_full_buffer_drops_the_newest_message() {
    for (size, words) in [
        (1, ["FIRST"].as_slice()),
        (2, &["FIRST", "SECOND"]),
        (3, &["FIRST", "SECOND", "THIRD"]),
    ] {
        let (heard, assumptions) = heard(&connected(&format!(
            "{{ type = \"buffer\", size = {size} }}"
        )));
        assert_eq!(heard, words, "size {size}");
        assert!(
            !assumptions.iter().any(|it| it.contains("wait")),
            "{assumptions:?}"
        );
    }
}

#[test]
fn a_full_circular_buffer_drops_the_oldest_message() {
    for (size, words) in [(1, ["THIRD"].as_slice()), (2, &["SECOND", "THIRD"])] {
        let policy = format!("{{ type = \"circular_buffer\", size = {size} }}");
        assert_eq!(heard(&connected(&policy)).0, words, "size {size}");
    }
}

/// The specification of a receiver that a queue of size 2 violates, and one of size 1 does not.
#[test]
fn a_topic_is_a_queue_as_large_as_those_of_the_connections_into_it() {
    let topic = |size: u32| {
        files(&format!(
            "[[connections]]\nfrom = \"Sender.said\"\nto = \"topic:words\"\npolicy = {{ type = \"buffer\", size = {size} }}\n"
        ))
        .change(
            "burst.composite.toml",
            "ports.in = { heard = \"std_msgs/String\" }",
            "subscribe = { heard = \"std_msgs/String\" }\nrename = { heard = \"words\" }",
        )
    };
    assert_eq!(heard(&topic(1)).0, ["FIRST"]);
    assert_eq!(heard(&topic(2)).0, ["FIRST", "SECOND"]);
}

/// Between specifications, also large queues are those of the composite, and those that it does not write.
#[test]
fn queues_between_specifications_are_exact() {
    let all = ["FIRST", "SECOND", "THIRD"];
    let newest = "[[connections]]\nfrom = \"Sender.said\"\nto = \"Receiver.heard\"\n";
    let subscribed = files("")
        .change(
            "burst.composite.toml",
            "ports.in = { heard = \"std_msgs/String\" }",
            "subscribe = { heard = \"std_msgs/String\" }\nrename = { heard = \"words\" }",
        )
        .change(
            "burst.composite.toml",
            "ports.out = { said = \"std_msgs/String\" }",
            "publish = { said = \"std_msgs/String\" }\nrename = { said = \"words\" }",
        );
    for (composite, words) in [
        (
            connected("{ type = \"buffer\", size = 100 }"),
            all.as_slice(),
        ),
        (files(newest), &["THIRD"]),
        (subscribed, &all),
    ] {
        let (found, assumptions) = heard(&composite);
        assert_eq!(found, words);
        assert!(
            !assumptions.iter().any(|it| it.contains("wait")),
            "{assumptions:?}"
        );
    }
}

/// The first word is heard if the sender steps first, as in a simulation of this composite, and the second one if it begins a
/// period of its own earlier.
#[test]
fn any_component_can_step_first() {
    let composite = connected("{ type = \"data\" }");
    let model = modelled(&composite, "burst.composite.toml", "Receiver");
    let words = ["FIRST", "SECOND", "THIRD"];
    let both = "knows(FIRST) and knows(SECOND)".to_owned();
    let options = Options {
        possible: words
            .map(|word| format!("knows({word})"))
            .into_iter()
            .chain([both])
            .collect(),
        ..Options::default()
    };
    let found = verified(model, &options);
    let possible = found
        .properties
        .iter()
        .filter(|it| it.kind == PropertyKind::Possible);
    let possible: Vec<bool> = possible.map(|it| it.verdict.holds()).collect();
    assert_eq!(possible, [true, true, true, false]);
}

/// A protocol may send without end.
#[test]
fn a_queue_for_messages_of_a_protocol_that_is_too_large_for_the_model_is_an_assumption() {
    let composite = connected("{ type = \"buffer\", size = 100 }").change(
        "burst.composite.toml",
        "activity = { period_ms = 25 }",
        "activity = { period_ms = 25 }\nprotocol = \"sender.asm\"",
    );
    let (_, assumptions) = heard(&composite);
    assert!(
        assumptions
            .iter()
            .any(|it| it == "at most 2 messages wait for an input"),
        "{assumptions:?}"
    );
}
