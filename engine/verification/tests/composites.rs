//! The composites of the repository: their properties hold, and a mutant of each specification violates one.

use crate::support::{Files, modelled, verified};
use asmotion_verify::{Options, PropertyKind, Verdict, Verification};

const NAVIGATION: &str = "specs/navigation/navigation.composite.toml";

/// Texts of the stated properties with a verdict.
fn stated(verification: &Verification, is: fn(&Verdict) -> bool) -> Vec<&str> {
    let stated = verification.properties.iter().filter(|it| match it.kind {
        PropertyKind::Invariant
        | PropertyKind::Constraint
        | PropertyKind::Ctl
        | PropertyKind::Ltl => is(&it.verdict),
        PropertyKind::NoFault => is(&it.verdict),
        PropertyKind::Possible | PropertyKind::NotStuck | PropertyKind::RulesRun => false,
    });
    stated.map(|it| it.text.as_str()).collect()
}

fn violated(files: &Files, composite: &str, component: &str) -> Vec<String> {
    let found = verified(modelled(files, composite, component), &Options::default());
    assert_eq!(found.incomplete, None, "{composite}");
    assert_eq!(stated(&found, |it| matches!(it, Verdict::Unknown)), [""; 0]);
    let texts = stated(&found, Verdict::is_violated).into_iter();
    texts.map(str::to_owned).collect()
}

#[test]
fn the_properties_of_each_composite_hold() {
    for (composite, component) in [
        (NAVIGATION, "ASMCoordinator"),
        ("specs/navigation/web.composite.toml", "ASMCoordinator"),
        ("specs/youbot/youbot.composite.toml", "Locomotor"),
        ("specs/allocation/allocation.composite.toml", "Allocation"),
        (
            "specs/ball_tracker/ball_tracker.composite.toml",
            "Coordinator",
        ),
    ] {
        assert_eq!(
            violated(&Files::default(), composite, component),
            [""; 0],
            "{composite}"
        );
    }
}

#[test]
fn a_mutant_of_each_specification_is_found() {
    for (composite, component, file, from, to) in [
        (
            NAVIGATION,
            "ASMCoordinator",
            "specs/navigation/navigate.asm",
            "if mode != IDLE then r_halt[IDLE] endif",
            "if mode != IDLE then r_enter[IDLE, HALT] endif",
        ),
        (
            "specs/youbot/youbot.composite.toml",
            "Locomotor",
            "specs/youbot/youbot.asm",
            "(stale or unsent or (newStatus and errorFlags))",
            "(stale or unsent)",
        ),
        (
            "specs/allocation/allocation.composite.toml",
            "Allocation",
            "specs/allocation/allocation.asm",
            "and not robotDown($r) and tstate($t) = PENDING",
            "and not robotDown($r)",
        ),
        (
            "specs/ball_tracker/ball_tracker.composite.toml",
            "Coordinator",
            "specs/ball_tracker/ball_tracker.asm",
            "par mode := $to  power := false  command := REST endpar",
            "par mode := $to  power := false endpar",
        ),
    ] {
        let files = Files::default().change(file, from, to);
        assert_ne!(violated(&files, composite, component), [""; 0], "{file}");
    }
}

/// The protocol of a robot does not say whose status it sends, but the binding of its component does: its own.
#[test]
fn a_field_that_is_the_same_in_all_messages_of_a_component_selects_a_location() {
    const COMPOSITE: &str = "specs/allocation/allocation.composite.toml";
    let files = Files::default();
    let model = modelled(&files, COMPOSITE, "Allocation");
    assert!(!model.environment.text.contains("$fits"));
    let found = verified(model, &Options::default());
    let failed = found.properties.iter().filter(|it| !it.verdict.holds());
    let failed: Vec<&str> = failed.map(|it| it.text.as_str()).collect();
    assert_eq!(failed, [""; 0]);
    // the second robot says that the first one is repaired when it is itself
    let files = files.change(
        COMPOSITE,
        "value = { robot = \"ROB$n\", down = false }",
        "value = { robot = \"ROB1\", down = false }",
    );
    let text = modelled(&files, COMPOSITE, "Allocation").environment.text;
    let uncertain = text.matches("$fits in Boolean").count();
    assert_eq!(uncertain, 2, "{text}");
    assert!(text.contains("robotDown(ROB1) := robot1_down"), "{text}");
    assert!(!text.contains("robotDown(ROB2) := robot1_down"), "{text}");
}

/// The follower reports REACHED only while it follows a path, and the map server answers each request once.
#[test]
fn a_protocol_excludes_what_the_component_does_not_do() {
    let files = Files::default();
    let options = Options {
        properties: vec![
            "ag(mode = STOPPING implies event != REACHED)".to_owned(),
            "ag(event = MAP_OK implies command = GET_MAP)".to_owned(),
        ],
        ..Options::default()
    };
    let found = verified(modelled(&files, NAVIGATION, "ASMCoordinator"), &options);
    assert_eq!(stated(&found, Verdict::is_violated), [""; 0]);
    let silent = Files::default().change(
        "specs/youbot/driver_protocol.asm",
        "$event != IDLE or moves",
        "$event != IDLE",
    );
    // a driver that never says that it is idle
    let never = violated(&silent, "specs/youbot/youbot.composite.toml", "Locomotor");
    assert_eq!(never, ["ag(mode = BUSY implies ef(mode = IDLE))"]);
}

/// Events of one function arrive in order, messages and outcomes of calls alike. After a contact no other plan is published until
/// there is a path, so the follower can report the end of the old one; that has no effect.
#[test]
fn an_event_about_an_old_plan_has_no_effect() {
    let files = Files::default();
    let options = Options {
        properties: vec![
            "ag((event = REACHED and mode != FOLLOWING) implies ax(mode != ARRIVED))".to_owned(),
            "ag(mode = WAIT_MAP implies event != REACHED)".to_owned(),
        ],
        ..Options::default()
    };
    let found = verified(modelled(&files, NAVIGATION, "ASMCoordinator"), &options);
    println!(
        "{:?} violated, {} states",
        stated(&found, Verdict::is_violated),
        found.states
    );
    assert_eq!(stated(&found, Verdict::is_violated), [""; 0]);
}

/// Two coordinators that use one specification are verified each on its own.
#[test]
fn a_specification_is_verified_for_each_component_that_uses_it() {
    for component in ["Left/ASMCoordinator", "Right/ASMCoordinator"] {
        let composite = "specs/navigation/two_rovers.composite.toml";
        let model = modelled(&Files::default(), composite, component);
        let (side, _) = component.split_once('/').expect("a name");
        let others: Vec<&str> = model
            .environment
            .others
            .iter()
            .map(|(it, _)| it.as_str())
            .collect();
        assert_eq!(
            others,
            [
                format!("{side}/TrajectoryAdapter"),
                format!("{side}/TrajectoryFollower")
            ]
        );
    }
}

#[test]
fn the_environment_is_a_readable_specification() {
    let model = modelled(
        &Files::default(),
        "specs/youbot/youbot.composite.toml",
        "Locomotor",
    );
    insta::assert_snapshot!(model.environment.text);
}
