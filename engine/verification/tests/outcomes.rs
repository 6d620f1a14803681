//! Inputs that take the outcomes of calls, and what their bindings say between two outcomes.

use crate::support::{Files, model, modelled, open, plan, verified};
use asmotion_verification::ModelError;
use asmotion_verify::{Options, Verdict};

/// Asks for a map until there is one.
const COORDINATOR: &str = "asm coordinator
import CTLLibrary
import StandardLibrary
signature:
  enum domain Mode = {ASKING | READY}
  enum domain Answer = {NOTHING | FOUND | LOST}
  enum domain Order = {REST | ASK}
  monitored answer: Answer
  out order: Order
  controlled mode: Mode
definitions:
  main rule r_Main =
    switch mode
      case ASKING: if answer = FOUND then mode := READY else order := ASK endif
      case READY: order := REST
    endswitch
default init s0:
  function mode = ASKING
  function order = REST
";

/// The coordinator with this binding of its answer.
fn files(answer: &str) -> Files {
    let composite = format!(
        "schema = \"composite/1\"\n[composite]\nname = \"maps\"\n\
         [components.Coordinator]\nimplementation = {{ asm = \"coordinator.asm\" }}\nactivity = {{ period_ms = 100 }}\n\
         subscribe = {{ heard = \"std_msgs/String\" }}\nreferences = {{ maps = \"nav/MapService\" }}\n\
         [components.Coordinator.bind.monitored]\n{answer}\n\
         [components.Coordinator.bind.out.order]\n\
         ASK = {{ call = \"maps.getMap\", with = {{ name = \"office\" }}, ok = \"FOUND\", failed = \"LOST\", event = \"answer\" }}\n\
         [components.Server]\nimplementation = {{ rust = \"nav::MapServer\" }}\nactivity = {{ period_ms = 100 }}\n\
         services = {{ maps = \"nav/MapService\" }}\nproperties = {{ source = \"office=office.yaml\" }}\n\
         [[promote]]\ntopic = \"heard\"\nas = \"heard\"\n\
         [[wires]]\nreference = \"Coordinator.maps\"\nservice = \"Server.maps\"\ntimeout_ms = 500\n"
    );
    Files::default()
        .with("maps.composite.toml", composite)
        .with("coordinator.asm", COORDINATOR.to_owned())
}

/// A constant is the value between two outcomes; it hid them.
#[test]
fn a_constant_does_not_hide_the_outcomes_of_calls() {
    for answer in ["", "answer = { value = \"NOTHING\" }"] {
        let model = modelled(&files(answer), "maps.composite.toml", "Coordinator");
        let properties = [
            "ef(mode = READY)",
            "ag(answer != FOUND)",
            "ef(answer = LOST)",
        ];
        let options = Options {
            properties: properties.map(str::to_owned).to_vec(),
            ..Options::default()
        };
        let found = verified(model, &options);
        let verdict = |text: &str| {
            let mut properties = found.properties.iter();
            let property = properties.find(|it| it.text == text);
            property.map(|it| it.verdict.holds()).expect(text)
        };
        assert_eq!(properties.map(verdict), [true, false, true], "{answer}");
        assert!(
            found
                .properties
                .iter()
                .all(|it| !matches!(it.verdict, Verdict::Unknown))
        );
    }
}

#[test]
fn outcomes_beside_the_newest_message_are_refused() {
    let newest =
        "answer = { topic = \"heard\", receive = \"last\", map = \"data\", none = \"NOTHING\" }";
    let files = files(newest);
    let opened = open(&files, "maps.composite.toml");
    match model(&files, plan(&opened), "Coordinator") {
        Err(ModelError::OutcomesBesideValues { location, .. }) => assert_eq!(location, "answer"),
        other => panic!("{:?}", other.map(|it| it.environment.text)),
    }
}
