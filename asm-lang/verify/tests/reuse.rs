//! Verification of one version after another: states are explored again only if more than properties has changed.

use crate::naive::Random;
use crate::storage::{ENOUGH, Limited};
use crate::symbolic::formula;
use crate::{open, verdicts, verified};
use asmotion_verify::{
    KeptExploration, Limits, Options, Storage, SystemSpecification, Verification, verify,
    verify_again,
};

const CRANE: &str = "asm crane
import StandardLibrary
import CTLLibrary
import LTLLibrary
signature:
  enum domain Phase = {REST | LIFT | MOVE}
  domain Height subsetof Integer
  monitored go: Boolean
  monitored load: Integer
  controlled phase: Phase
  controlled height: Height
definitions:
  domain Height = {0:3}
  invariant safe over phase, height: phase = MOVE implies height = 3
  CTLSPEC can_rest: ag(ef(phase = REST))
  main rule r_Main =
    switch phase
      case REST: if go and load < 50 then phase := LIFT endif
      case LIFT: if height < 3 then height := height + 1 else phase := MOVE endif
      case MOVE: par phase := REST height := 0 endpar
    endswitch
default init s0:
  function phase = REST
  function height = 0
";

fn again(text: &str, options: &Options, kept: &mut KeptExploration) -> Verification {
    let system = SystemSpecification::of(open(text));
    let verification = verify_again(system, options, kept, &mut |_| true).unwrap();
    // as if it had been explored
    let fresh = verified(text, options);
    assert_eq!(verdicts(&verification), verdicts(&fresh), "{text}");
    assert_eq!(verification.states, fresh.states);
    assert_eq!(verification.transitions, fresh.transitions);
    assert_eq!(verification.excluded, fresh.excluded);
    assert_eq!(
        format!("{:?}", verification.properties),
        format!("{:?}", fresh.properties)
    );
    verification
}

#[test]
fn states_are_explored_once_while_only_properties_change() {
    let mut kept = KeptExploration::default();
    let options = Options::default();
    assert!(!again(CRANE, &options, &mut kept).is_reused);
    assert_eq!(kept.explorations(), 1);
    // nothing has changed
    assert!(again(CRANE, &options, &mut kept).is_reused);
    // other properties, some of them violated, and of another logic
    let other = CRANE.replace("implies height = 3", "implies height = 2").replace(
        "  CTLSPEC can_rest: ag(ef(phase = REST))",
        "  CTLSPEC lifts: ag(phase = LIFT implies af(phase = MOVE))\n  LTLSPEC g(f(phase = REST))\n  CTLSPEC ef(height = 2)",
    );
    let verification = again(&other, &options, &mut kept);
    assert!(verification.is_reused);
    assert_eq!(crate::verdict_of(&verification, "safe"), "violated");
    // none, after which there are some again
    let without = CRANE.replace("  CTLSPEC can_rest: ag(ef(phase = REST))\n", "");
    assert!(again(&without, &options, &mut kept).is_reused);
    assert!(again(CRANE, &options, &mut kept).is_reused);
    assert_eq!(kept.explorations(), 1);
}

#[test]
fn states_are_explored_again_if_more_has_changed() {
    let mut kept = KeptExploration::default();
    let options = Options::default();
    again(CRANE, &options, &mut kept);
    let changes = [
        // a rule, an initial value, a domain, and the way back
        ("height := height + 1", "height := 3"),
        ("function height = 0", "function height = 1"),
        ("{0:3}", "{0:4}"),
        ("REST | LIFT | MOVE", "REST | LIFT | MOVE | LOST"),
        ("load < 50", "load < 60"),
        ("", ""),
    ];
    let mut count = 1;
    for (from, to) in changes {
        let changed = if from.is_empty() {
            CRANE.to_owned()
        } else {
            CRANE.replace(from, to)
        };
        assert!(
            !again(&changed, &options, &mut kept).is_reused,
            "{from} to {to}"
        );
        count += 1;
        assert_eq!(kept.explorations(), count);
    }
    // conditions that distinguish inputs, or more values of one
    for property in [
        "ag(go implies true)",
        "ag(load < 20 implies ef(phase = LIFT))",
    ] {
        let changed = CRANE.replace("ag(ef(phase = REST))", property);
        assert!(
            !again(&changed, &options, &mut kept).is_reused,
            "{property}"
        );
        assert!(again(&changed, &options, &mut kept).is_reused, "{property}");
    }
    // an assumption excludes states
    let assumed = CRANE.replace(
        "  CTLSPEC can_rest:",
        "  INVAR height < 2\n  CTLSPEC can_rest:",
    );
    assert!(!again(&assumed, &options, &mut kept).is_reused);
    let fair = CRANE.replace("  CTLSPEC can_rest:", "  JUSTICE go\n  CTLSPEC can_rest:");
    assert!(!again(&fair, &options, &mut kept).is_reused);
    assert!(again(&fair, &options, &mut kept).is_reused);
}

#[test]
fn an_exploration_that_ended_early_is_not_reused() {
    let mut kept = KeptExploration::default();
    let options = Options {
        limits: Limits {
            states: Some(2),
            ..Limits::default()
        },
        ..Options::default()
    };
    for _ in 0..2 {
        assert!(!again(CRANE, &options, &mut kept).is_reused);
    }
    assert_eq!(kept.explorations(), 2);
}

/// Random properties of all classes, some of which mention inputs.
fn properties(random: &mut Random) -> String {
    let mut lines = String::new();
    for at in 0..1 + random.below(3) {
        lines += &match (at + random.below(4)) % 4 {
            0 => format!("  CTLSPEC {}\n", formula(random, 3, false)),
            1 => format!("  LTLSPEC {}\n", formula(random, 3, true)),
            2 => format!("  CTLSPEC ag({})\n", random.condition(2)),
            _ => format!("  invariant over p: {}\n", random.condition(1)),
        };
    }
    if random.below(4) == 0 {
        lines += &format!("  JUSTICE {}\n", random.condition(1));
    }
    if random.below(6) == 0 {
        lines += "  INVAR not (left and right)\n";
    }
    lines
}

#[test]
fn random_versions_have_the_verdicts_and_runs_of_a_new_exploration() {
    let seed = std::env::var("ASMOTION_NAIVE_SEED").ok();
    let seed = seed.and_then(|it| it.parse().ok());
    let mut random = Random(seed.unwrap_or(0x4e05_ed00_0000_0b01));
    let (mut reused, mut explored) = (0, 0);
    for round in 0..60 {
        let mut kept = KeptExploration::default();
        let mut text = random.specification();
        let options = Options {
            without_grounding: random.below(2) == 0,
            storage: match round % 3 {
                0 => Storage::Exact,
                1 => Storage::Compact,
                _ => Limited::of(ENOUGH),
            },
            threads: 1 + random.below(2) as usize,
            ..Options::default()
        };
        for _ in 0..5 {
            if random.below(5) == 0 {
                text = random.specification();
            }
            let version = text
                .replace(
                    "import StandardLibrary\n",
                    "import StandardLibrary\nimport CTLLibrary\nimport LTLLibrary\n",
                )
                .replace(
                    "  main rule",
                    &format!("{}  main rule", properties(&mut random)),
                );
            if verify(open(&version), &options, &mut |_| true).is_err() {
                // the assumption excludes the initial state, or a formula is too large
                continue;
            }
            let found = again(&version, &options, &mut kept);
            reused += u32::from(found.is_reused);
            explored += u32::from(!found.is_reused);
        }
    }
    assert!(reused > 30 && explored > 60, "{reused} {explored}");
}
