//! Watched properties: violations, the safe rule, deadlines.

use std::sync::{Arc, Mutex};

use asmotion_component::{Activity, Policy, Span, State, Time};
use asmotion_coordinator::{
    BindError, Binding, Coordinator, CoordinatorStatus, GivenProperty, Interfaces, Monitored,
    RECORDED_CYCLE_REPORT, RecordedCycle, STEP_REPORT, Source, StepRecord, VIOLATION_REPORT,
    ViolationReaction, ViolationRecord, Watch,
};
use asmotion_datum::{Datum, Schema};
use asmotion_lang::MemoryFiles;
use asmotion_runtime::{Event, Run, Simulation, System};

/// Drives on every command, even while the e-stop is pressed.
const ROVER: &str = "
asm rover
import StandardLibrary
import CTLLibrary
signature:
	monitored estop: Boolean
	monitored drive: Boolean
	controlled moving: Boolean
	controlled asked: Boolean
	controlled steps: Integer
definitions:
	CTLSPEC ag(estop implies ax(not moving))
	CTLSPEC ag(ef(moving))
	//@Within 300 ms
	CTLSPEC ag(asked implies af(moving))
	invariant inv_few over steps: steps < 1000
	rule r_stop = par moving := false asked := false steps := steps + 1 endpar
	rule r_unsafe = moving := true
	main rule r_Main =
		par
			moving := drive and (not asked or estop)
			asked := drive and not estop
			steps := steps + 1
		endpar
default init s0:
	function moving = false
	function asked = false
	function steps = 0
";

type Told = Arc<Mutex<Vec<(Time, String, Datum)>>>;

struct Watched {
    run: Simulation,
    told: Told,
}

fn rover() -> String {
    ROVER.to_owned()
}

impl Watched {
    fn new(text: &str, watch: &Watch, activity: Activity) -> Self {
        let mut files = MemoryFiles::new();
        files.add("rover.asm", text);
        let specification = asmotion_lang::open("rover.asm", &files).unwrap();
        let port = |name: &str| Monitored {
            field: Some("data".to_owned()),
            none: Some(Datum::Bool(false).into()),
            ..Monitored::new(name, Source::Port(name.to_owned()))
        };
        let binding = Binding {
            monitored: vec![port("estop"), port("drive")],
            out: Vec::new(),
        };
        let inputs = ["estop", "drive"].map(|it| (it.to_owned(), Schema::opaque("test/Bool")));
        let interfaces = Interfaces {
            inputs: inputs.to_vec(),
            ..Interfaces::default()
        };
        let mut system = System::new();
        let made = system.add("Rover", activity, |interface| {
            let made =
                Coordinator::watching(specification, &binding, watch, &interfaces, 1, interface);
            let mut made = made.unwrap();
            made.record_cycles();
            Box::new(made)
        });
        made.unwrap();
        for name in ["estop", "drive"] {
            let port = format!("Rover.{name}");
            system.subscribe(name, &port, Policy::buffer(8)).unwrap();
        }
        let told = Told::default();
        let teller = Arc::clone(&told);
        system.observe(move |at: Time, event: &Event<'_>| {
            if let Event::Report { kind, data, .. } = event {
                let report = (at, (*kind).to_owned(), (*data).clone());
                teller.lock().unwrap().push(report);
            }
        });
        Self {
            run: system.simulate(),
            told,
        }
    }

    fn send(&mut self, topic: &str, value: bool) {
        let sample = Arc::new(Datum::record([("data", Datum::Bool(value))]));
        let now = self.run.now();
        self.run.publish_sample(now, topic, sample).unwrap();
    }

    fn violations(&self) -> Vec<(Time, ViolationRecord)> {
        let told = self.told.lock().unwrap();
        let found = told.iter().filter(|it| it.1 == VIOLATION_REPORT);
        found
            .map(|(at, _, data)| (*at, data.to().unwrap()))
            .collect()
    }

    fn records<T: serde::de::DeserializeOwned>(&self, kind: &str) -> Vec<T> {
        let told = self.told.lock().unwrap();
        let found = told.iter().filter(|it| it.1 == kind);
        found.map(|(_, _, data)| data.to().unwrap()).collect()
    }

    fn status(&mut self) -> CoordinatorStatus {
        CoordinatorStatus::of(&self.run.inspect("Rover").unwrap()).unwrap()
    }
}

fn safe(rule: &str) -> Watch {
    Watch {
        safe_rule: Some(rule.to_owned()),
        ..Watch::default()
    }
}

fn periodic() -> Activity {
    Activity::periodic(100.ms())
}

#[test]
fn a_violation_is_reported_in_its_step_and_the_run_goes_on() {
    let mut rover = Watched::new(&rover(), &Watch::default(), periodic());
    rover.run.run_for(150.ms());
    rover.send("estop", true);
    rover.send("drive", true);
    rover.run.run_for(500.ms());
    let violations = rover.violations();
    let [(at, violation)] = violations.as_slice() else {
        panic!("{violations:?}");
    };
    assert_eq!((*at, violation.step), (Time::ZERO + 200.ms(), 3));
    assert_eq!(violation.reaction, ViolationReaction::Reported);
    assert_eq!(
        violation.to_string(),
        "step 3 violates CTLSPEC `ag(estop implies ax(not moving))` (rover.asm:12): `estop`; `not moving`, then not `not moving`"
    );
    assert_eq!(rover.run.state("Rover").unwrap(), State::Running);
}

#[test]
fn the_safe_rule_makes_the_violating_step() {
    let mut rover = Watched::new(&rover(), &safe("r_stop[]"), periodic());
    rover.run.run_for(150.ms());
    rover.send("estop", true);
    rover.send("drive", true);
    rover.run.run_for(500.ms());
    let violations = rover.violations();
    assert_eq!(violations.len(), 1, "{violations:?}");
    assert_eq!(violations[0].1.reaction, ViolationReaction::SafeRule);
    let steps: Vec<StepRecord> = rover.records(STEP_REPORT);
    let moved = steps.iter().flat_map(|step| &step.updates);
    let mut moved = moved.filter(|it| it.location == "moving");
    assert!(moved.all(|it| it.after == "false"));
    // the step has one number, whichever rule made it, and every one is a step of the safe rule from then on
    let numbers: Vec<(u64, bool)> = steps
        .iter()
        .map(|step| (step.number, step.safe_rule.is_some()))
        .collect();
    let expected: Vec<(u64, bool)> = (1..=steps.len() as u64).map(|it| (it, it >= 3)).collect();
    assert_eq!(numbers, expected);
    let recorded: Vec<RecordedCycle> = rover.records(RECORDED_CYCLE_REPORT);
    let replaced = recorded[2].replaced.as_ref().unwrap();
    assert_eq!(replaced.rule, "r_stop[]");
    let discarded = replaced.updates.iter();
    let mut discarded = discarded.filter(|it| it.location == "moving");
    assert!(discarded.any(|it| it.after == "true"));
    assert!(recorded[2].updates.iter().all(|it| it.after != "true"));
    assert!(recorded[3].violations[0].is_repeated);
    let status = rover.status();
    let violated = status.violated.get("ag(estop implies ax(not moving))");
    assert_eq!(violated, Some(&(steps.len() as u64 - 2)));
    assert!(status.unwatched.contains_key("ag(ef(moving))"));
}

#[test]
fn a_safe_rule_that_violates_the_property_makes_the_component_fail() {
    let mut rover = Watched::new(&rover(), &safe("r_unsafe[]"), periodic());
    rover.run.run_for(150.ms());
    rover.send("estop", true);
    rover.send("drive", true);
    rover.run.run_for(500.ms());
    let violations = rover.violations();
    assert_eq!(violations.len(), 1, "{violations:?}");
    assert_eq!(violations[0].1.reaction, ViolationReaction::Failed);
    assert_eq!(rover.run.state("Rover").unwrap(), State::Exception);
    let steps: Vec<StepRecord> = rover.records(STEP_REPORT);
    assert_eq!(steps.len(), 2, "nothing of the failed step leaves");
}

#[test]
fn a_violated_invariant_is_a_violation_and_the_safe_rule_prevents_the_failure() {
    let text = rover().replace("steps < 1000", "steps < 3 or not moving and steps < 5");
    let drive = |watch: &Watch| {
        let mut rover = Watched::new(&text, watch, periodic());
        rover.send("drive", true);
        rover.send("estop", false);
        rover.run.run_for(1.s());
        rover
    };
    let rover = drive(&Watch::default());
    let violations = rover.violations();
    let last = &violations.last().unwrap().1;
    assert_eq!(
        (last.kind.as_str(), last.reaction),
        ("invariant", ViolationReaction::Failed)
    );
    assert_eq!(last.name.as_deref(), Some("inv_few"));
    assert_eq!(rover.run.state("Rover").unwrap(), State::Exception);
    // the machine goes back from the state in which the invariant does not hold
    let rover = drive(&safe("par moving := false asked := false endpar"));
    let violations = rover.violations();
    assert_eq!(
        violations[0].1.reaction,
        ViolationReaction::SafeRule,
        "{violations:?}"
    );
    assert_eq!(rover.run.state("Rover").unwrap(), State::Running);
    // a safe rule that leaves it violated fails as the main rule does
    let rover = drive(&safe("par moving := true steps := 10 endpar"));
    assert_eq!(rover.violations()[0].1.reaction, ViolationReaction::Failed);
}

#[test]
fn a_response_is_late_although_nothing_happens() {
    let text = rover().replace(
        "moving := drive and (not asked or estop)",
        "moving := false",
    );
    let mut rover = Watched::new(&text, &safe("r_stop[]"), Activity::event());
    rover.run.run_for(10.ms());
    rover.send("drive", true);
    rover.run.run_for(100.ms());
    assert!(rover.violations().is_empty());
    rover.run.run_for(190.ms());
    assert!(rover.violations().is_empty());
    rover.run.run_for(1.s());
    let violations = rover.violations();
    let (at, violation) = &violations[0];
    assert_eq!(*at, Time::ZERO + 310.ms());
    assert_eq!(violation.late_after_s, Some(0.3));
    assert_eq!(violation.reaction, ViolationReaction::SafeRule);
    assert!(
        violation
            .to_string()
            .contains("has not happened within 0.3 s")
    );
}

#[test]
fn a_property_of_the_composite_is_watched_and_one_that_cannot_be_is_refused() {
    let watch = |text: &str| Watch {
        properties: vec![GivenProperty {
            text: text.to_owned(),
            within_ns: None,
        }],
        ..Watch::default()
    };
    let mut rover = Watched::new(&rover(), &watch("not moving"), periodic());
    rover.send("drive", true);
    rover.run.run_for(1.s());
    assert_eq!(rover.violations()[0].1.property, "not moving");
    let refused = |watch: &Watch| {
        let mut files = MemoryFiles::new();
        files.add("rover.asm", self::rover());
        let specification = asmotion_lang::open("rover.asm", &files).unwrap();
        let mut error = None;
        let made = System::new().add("Rover", periodic(), |interface| {
            let (binding, interfaces) = (Binding::default(), Interfaces::default());
            let made =
                Coordinator::watching(specification, &binding, watch, &interfaces, 1, interface);
            error = made.err();
            Box::new(Nothing)
        });
        made.unwrap();
        error.unwrap()
    };
    let liveness = refused(&watch("ag(ef(moving))"));
    assert!(
        matches!(liveness, BindError::InvalidProperty { .. }),
        "{liveness}"
    );
    let unknown = refused(&watch("nowhere"));
    assert!(
        matches!(unknown, BindError::InvalidProperty { .. }),
        "{unknown}"
    );
    let rule = refused(&safe("r_nowhere[]"));
    assert!(matches!(rule, BindError::InvalidRule { .. }), "{rule}");
}

struct Nothing;

impl asmotion_component::Component for Nothing {
    fn update(
        &mut self,
        _: &mut asmotion_component::Cycle<'_>,
    ) -> Result<(), asmotion_component::Fault> {
        Ok(())
    }
}

#[test]
fn switched_off_nothing_temporal_is_watched() {
    let watch = Watch {
        is_off: true,
        ..Watch::default()
    };
    let mut rover = Watched::new(&rover(), &watch, periodic());
    rover.send("estop", true);
    rover.send("drive", true);
    rover.run.run_for(1.s());
    assert!(rover.violations().is_empty());
    assert!(rover.status().unwatched.is_empty());
}

#[test]
fn a_frozen_run_goes_on_with_the_same_violations() {
    let drive = |rover: &mut Watched| {
        rover.run.run_for(300.ms());
        rover.send("estop", true);
        rover.run.run_for(1.s());
        rover.violations()
    };
    let mut rover = Watched::new(&rover(), &Watch::default(), periodic());
    rover.send("drive", true);
    rover.run.run_for(150.ms());
    let frozen = rover.run.freeze().unwrap();
    let mut other = Watched::new(&self::rover(), &Watch::default(), periodic());
    other.run.thaw(&frozen).unwrap();
    let (one, two) = (drive(&mut rover), drive(&mut other));
    assert!(one.len() > 1, "{one:?}");
    assert_eq!(one, two);
    // another watch is another coordinator
    let mut safe = Watched::new(&self::rover(), &safe("r_stop[]"), periodic());
    assert!(safe.run.thaw(&frozen).is_err());
}
