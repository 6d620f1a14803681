//! Properties about several machines, which an observer evaluates that makes no steps.

use crate::{machine, refused, verdict_of, verdicts, verified_system};
use asmotion_verify::{
    MachineSchedule, MessageModel, Options, SystemSpecification, VerifiedMachine, verify_system,
};

const DOOR: &str = "asm door
import StandardLibrary
signature:
  enum domain Wing = {LEFT | RIGHT}
  enum domain Phase = {OPEN | SHUT}
  domain Count subsetof Integer
  monitored request: Boolean
  monitored distance: Integer
  controlled count: Count
  controlled phase: Wing -> Phase
  derived isOpen: Boolean
definitions:
  domain Count = {0:3}
  function isOpen = (exist $w in Wing with phase($w) = OPEN)
  main rule r_Main =
    if request and distance > 4 then
      par
        choose $w in Wing with true do phase($w) := if phase($w) = OPEN then SHUT else OPEN endif
        if count < 3 then count := count + 1 endif
      endpar
    endif
default init s0:
  function count = 0
  function phase($w in Wing) = SHUT
";

const WATCH: &str = "asm watch
import StandardLibrary
signature:
  enum domain Wing = {LEFT | RIGHT}
  enum domain Phase = {OPEN | SHUT}
  domain Count subsetof Integer
  monitored count: Count
  controlled seen: Count
  controlled last: Phase
  monitored phase: Wing -> Phase
definitions:
  domain Count = {0:3}
  main rule r_Main = par seen := count last := phase(LEFT) endpar
default init s0:
  function seen = 0
  function last = SHUT
";

fn doors() -> SystemSpecification {
    SystemSpecification {
        machines: vec![machine("door", DOOR), machine("Watch", WATCH)],
        ..SystemSpecification::default()
    }
}

fn properties(texts: &[&str]) -> Options {
    Options {
        properties: texts.iter().map(ToString::to_string).collect(),
        ..Options::default()
    }
}

#[test]
fn terms_compare_machines() {
    let plain = verified_system(doors(), &Options::default());
    let verification = verified_system(
        doors(),
        &properties(&[
            "Watch.seen <= door.count",
            "door.count <= Watch.seen",
            "Watch.last = door.phase(LEFT)",
            "(forall $w in Wing with door.phase($w) = SHUT) or Watch.seen + door.count > 0",
            "ag(door.count = 3 implies af(Watch.seen = door.count))",
            "ag(ef(Watch.last != door.phase(LEFT)))",
            "g(door.count = 3 implies f(Watch.seen = 3))",
            "ag(not door.request implies ax(door.count = 0 or Watch.seen <= 3))",
            "ag(not door.request and Watch.seen = 0 implies ax(door.count = 0))",
            // the step reads the inputs of the property
            "ag(not door.request and door.count = 0 and Watch.seen = 0 implies ax(door.count = 0))",
        ]),
    );
    let verdicts = verdicts(&verification);
    let verdicts: Vec<(&str, &str)> = verdicts.iter().map(|(it, v)| (&**it, *v)).collect();
    assert_eq!(
        verdicts,
        [
            ("Watch.seen <= door.count", "holds"),
            ("door.count <= Watch.seen", "violated"),
            ("Watch.last = door.phase(LEFT)", "violated"),
            (
                "(forall $w in Wing with door.phase($w) = SHUT) or Watch.seen + door.count > 0",
                "holds"
            ),
            (
                "ag(door.count = 3 implies af(Watch.seen = door.count))",
                "holds"
            ),
            ("ag(ef(Watch.last != door.phase(LEFT)))", "holds"),
            ("g(door.count = 3 implies f(Watch.seen = 3))", "holds"),
            (
                "ag(not door.request implies ax(door.count = 0 or Watch.seen <= 3))",
                "holds"
            ),
            (
                "ag(not door.request and Watch.seen = 0 implies ax(door.count = 0))",
                "violated"
            ),
            (
                "ag(not door.request and door.count = 0 and Watch.seen = 0 implies ax(door.count = 0))",
                "holds"
            ),
            ("no step fails", "holds"),
            ("no state is stuck", "holds"),
            ("every rule runs", "holds"),
        ]
    );
    // the observer adds neither states nor steps
    let states = verified_system(doors(), &properties(&["Watch.seen <= door.count"]));
    assert_eq!(
        (states.states, states.transitions),
        (plain.states, plain.transitions)
    );
}

/// A counter that is updated while a condition on the other counter holds.
fn counter(own: &str, other: &str, condition: &str, step: &str) -> VerifiedMachine {
    let text = format!(
        "asm {own}
import StandardLibrary
signature:
  domain Small subsetof Integer
  monitored {other}: Small
  controlled {own}: Small
definitions:
  domain Small = {{0:4}}
  main rule r_Main = if {condition} then {own} := {step} endif
default init s0:
  function {own} = 0
"
    );
    machine(own, &text)
}

/// A property over several machines has the verdict that it has in a specification that reads their functions.
#[test]
fn an_observer_says_what_a_watching_specification_says() {
    let conditions = ["one < two", "one <= two", "one != two + 1", "true"];
    let steps = [
        "(one + 1) mod 5",
        "(one + 2) mod 5",
        "two",
        "(two + 1) mod 5",
    ];
    let terms = [
        "one = two",
        "one <= two",
        "abs(one - two) <= 1",
        "one + two < 7",
    ];
    let swapped = |text: &str| {
        let first = text.replace("one", "#").replace("two", "one");
        first.replace('#', "two")
    };
    let qualified = |text: &str| text.replace("one", "one.one").replace("two", "two.two");
    let mut held = 0;
    for condition in conditions {
        for step in steps {
            for schedule in [MachineSchedule::Interleaved, MachineSchedule::Synchronous] {
                let machines = || {
                    vec![
                        counter("one", "two", condition, step),
                        counter(
                            "two",
                            "one",
                            &swapped(condition),
                            &swapped("(one + 1) mod 5"),
                        ),
                    ]
                };
                let system = SystemSpecification {
                    machines: machines(),
                    schedule,
                    ..SystemSpecification::default()
                };
                let texts: Vec<String> = terms.iter().map(|it| qualified(it)).collect();
                let texts: Vec<&str> = texts.iter().map(String::as_str).collect();
                let observed = verified_system(system, &properties(&texts));
                let watch = "asm watch
import StandardLibrary
signature:
  domain Small subsetof Integer
  monitored one: Small
  monitored two: Small
definitions:
  domain Small = {0:4}
  main rule r_Main = skip
";
                let mut watched = machines();
                watched.push(machine("watch", watch));
                let system = SystemSpecification {
                    machines: watched,
                    schedule,
                    ..SystemSpecification::default()
                };
                let terms_of_watch: Vec<String> = terms
                    .iter()
                    .map(|it| it.replace("one", "watch.one").replace("two", "watch.two"))
                    .collect();
                let of_watch: Vec<&str> = terms_of_watch.iter().map(String::as_str).collect();
                let watched = verified_system(system, &properties(&of_watch));
                for (own, other) in texts.iter().zip(of_watch) {
                    let verdict = verdict_of(&observed, own);
                    assert_eq!(
                        verdict,
                        verdict_of(&watched, other),
                        "{condition} {step} {own}"
                    );
                    held += usize::from(verdict == "holds");
                }
            }
        }
    }
    // both verdicts occur
    assert!((10..118).contains(&held), "{held}");
}

#[test]
fn messages_are_counted_on_both_sides() {
    let sensor = "asm sensor
import StandardLibrary
import CommonBehavior
signature:
  domain Logger subsetof Agent
  domain Count subsetof Integer
  static logger: Logger
  out entry: Prod(Logger, Boolean) -> Rule
  controlled sent: Count
definitions:
  domain Count = {0:2}
  main rule r_Main = if sent < 2 then par r_wsend[logger, \"entry\", true] sent := sent + 1 endpar endif
default init s0:
  function sent = 0
";
    let logger = "asm logger
import StandardLibrary
import CommonBehavior
signature:
  domain Logger subsetof Agent
  domain Count subsetof Integer
  out entry: Prod(Logger, Boolean) -> Rule
  //@Backref
  shared client: Agent -> Agent
  controlled got: Count
  controlled content: Boolean
definitions:
  domain Count = {0:2}
  main rule r_Main =
    switch nextRequest(self)
      case \"entry\": par r_wreceive[client(self), \"entry\", content] got := got + 1 endpar
    endswitch
default init s0:
  function got = 0
";
    for (is_lossy, is_delayed) in [(false, false), (true, false), (false, true), (true, true)] {
        let system = SystemSpecification {
            machines: vec![machine("sensor", sensor), machine("logger", logger)],
            ..SystemSpecification::default()
        };
        let mut options = properties(&[
            "logger.got <= sensor.sent",
            "af(logger.got = 2 and sensor.sent = 2)",
        ]);
        options.ends = Some("logger.got <= sensor.sent".to_owned());
        options.messages = MessageModel {
            is_lossy,
            is_delayed,
            ..MessageModel::default()
        };
        let verification = verified_system(system, &options);
        assert_eq!(
            verdict_of(&verification, "logger.got <= sensor.sent"),
            "holds"
        );
        let expected = if is_lossy { "violated" } else { "holds" };
        let arrives = "af(logger.got = 2 and sensor.sent = 2)";
        assert_eq!(
            verdict_of(&verification, arrives),
            expected,
            "{is_lossy} {is_delayed}"
        );
        // the condition of the ends is about both machines, too
        assert_eq!(verdict_of(&verification, "no state is stuck"), "holds");
    }
}

/// Renders the refusal of a property of two machines.
fn refusal(machines: Vec<VerifiedMachine>, text: &str) -> String {
    let system = SystemSpecification {
        machines,
        ..SystemSpecification::default()
    };
    let refusal = verify_system(system, &properties(&[text]), &mut |_| true).unwrap_err();
    refused(&refusal)
}

#[test]
fn what_cannot_be_observed_is_refused_with_its_place() {
    let both = || vec![machine("door", DOOR), machine("Watch", WATCH)];
    let mut all = Vec::new();
    for text in [
        "Watch.seen > 0 implies door.isOpen",
        "Watch.seen > 0 implies door.closed",
        "Watch.seen > 0 implies door.distance > 7",
        "Watch.seen > door.count and OPENED = door.phase(LEFT)",
    ] {
        all.push(refusal(both(), text));
    }
    let other = WATCH
        .replace("{OPEN | SHUT}", "{SHUT | AJAR}")
        .replace("  monitored phase: Wing -> Phase\n", "")
        .replace("last := phase(LEFT)", "last := AJAR");
    let machines = vec![machine("door", DOOR), machine("Watch", &other)];
    all.push(refusal(machines, "Watch.last = door.phase(LEFT)"));
    insta::assert_snapshot!(all.join("\n"));
}
