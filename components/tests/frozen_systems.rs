//! A mission frozen at an intermediate step continues in another system with the trace of an uninterrupted run.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use asmotion_assembly::{CoordinatorOptions, Standard};
use asmotion_component::{Span, Time};
use asmotion_composite::model::BuiltinComponent;
use asmotion_composite::{AsmFiles, Context, EmptyEnvironment, Tables};
use asmotion_datum::{Datum, Sample, cbor};
use asmotion_lang::Loader;
use asmotion_lang::diagnostics::LoadError;
use asmotion_plan::Opened;
use asmotion_runtime::{Event, FrozenSystem, Run, Simulation, SystemThawError};

const BUILD: Tables = Tables {
    components: asmotion_components::COMPONENTS,
    messages: asmotion_components::MESSAGES,
    interfaces: asmotion_components::INTERFACES,
    builtins: &[BuiltinComponent::PortProxy],
    ros: None,
};

/// Loads the files of the folder `specs`.
struct Specs;

impl Loader for Specs {
    fn read(&self, path: &str) -> Result<Arc<str>, LoadError> {
        let text = std::fs::read_to_string(path);
        text.map(Arc::from).map_err(|error| LoadError {
            path: path.to_owned(),
            reason: error.to_string(),
        })
    }

    fn resolve(&self, from: &str, import: &str) -> Option<String> {
        let near = Path::new(from).parent()?.join(import);
        let candidates = [
            near.clone(),
            PathBuf::from(format!("{}.asm", near.display())),
        ];
        let found = candidates.iter().find(|path| path.is_file());
        found.map(|path| path.display().to_string())
    }
}

/// A mission in `specs`.
#[derive(Clone, Copy)]
struct SpecsMission {
    composite: &'static str,
    seed: u64,
    /// Duration in virtual seconds.
    seconds: u64,
}

const NAVIGATION: SpecsMission = SpecsMission {
    composite: "navigation/navigation",
    seed: 7,
    seconds: 60,
};

const YOUBOT: SpecsMission = SpecsMission {
    composite: "youbot/youbot",
    seed: 1,
    seconds: 20,
};

const BALL_TRACKER: SpecsMission = SpecsMission {
    composite: "ball_tracker/ball_tracker",
    seed: 1,
    seconds: 30,
};

const COURIER: SpecsMission = SpecsMission {
    composite: "courier/courier",
    seed: 1,
    seconds: 20,
};

/// Output of the observers, with the full content of every sample.
type Lines = Arc<Mutex<Vec<String>>>;

fn line(at: Time, event: &Event<'_>) -> String {
    let mut line = format!("{} {event}", at.nanos());
    let mut sample = |sample: &dyn Sample| {
        let bytes = cbor::encode(&sample.to_datum().unwrap()).unwrap();
        write!(line, " {} {bytes:?}", sample.type_name()).unwrap();
    };
    match event {
        Event::Published { sample: it, .. } | Event::Injected { sample: it, .. } => sample(*it),
        Event::Called { argument, .. } => sample(*argument),
        Event::Answered { result, .. } | Event::Replied { result, .. } => {
            if let Ok(it) = result {
                sample(*it);
            }
        }
        _ => {}
    }
    line
}

fn note(lines: &Lines) -> impl FnMut(Time, &Event<'_>) + Send + use<> {
    let lines = Arc::clone(lines);
    move |at: Time, event: &Event<'_>| lines.lock().unwrap().push(line(at, event))
}

impl SpecsMission {
    fn opened(self) -> Opened {
        let specs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../specs");
        let path = specs.join(format!("{}.composite.toml", self.composite));
        let seed = [("seed".to_owned(), self.seed.to_string())];
        let specifications = AsmFiles::new(&Specs);
        let context = |settings| Context {
            loader: &Specs,
            environment: &EmptyEnvironment,
            catalogue: &BUILD,
            specifications: &specifications,
            programs: &asmotion_composite::NoPrograms,
            settings,
        };
        let path = path.canonicalize().unwrap().display().to_string();
        let has_seed = self.composite.starts_with("navigation");
        let settings: &[_] = if has_seed { &seed } else { &[] };
        asmotion_plan::open(&path, &context(settings))
    }

    /// The mission, started; with what observers see, from the beginning.
    fn started(self) -> (Simulation, Lines) {
        let opened = self.opened();
        let plan = opened.plan(None).unwrap_or_else(|| {
            let found = opened.report.diagnostics.iter().map(|it| &it.message);
            panic!("{}: {:?}", self.composite, found.collect::<Vec<_>>())
        });
        let mut workshop = Standard::new(&BUILD, &Specs, CoordinatorOptions::seeded(self.seed));
        let mut system = asmotion_assembly::start(plan, &mut workshop).unwrap();
        let lines = Lines::default();
        system.observe(note(&lines));
        (system.simulate(), lines)
    }

    fn end(self) -> Time {
        Time::ZERO + self.seconds.s()
    }

    /// Returns the observers' output for the whole mission and the number of steps after which each line appears.
    fn reference(self) -> (Vec<String>, Vec<usize>) {
        let (mut run, lines) = self.started();
        let mut after = vec![0; lines.lock().unwrap().len()];
        let mut steps = 0;
        while run.next_due().is_some_and(|due| due <= self.end()) {
            run.step();
            steps += 1;
            let count = lines.lock().unwrap().len();
            after.resize(count, steps);
        }
        let lines = lines.lock().unwrap().clone();
        (lines, after)
    }

    /// Runs the mission for a number of steps; returns it with the observers' output so far.
    fn advanced(self, steps: usize) -> (Simulation, Lines) {
        let (mut run, lines) = self.started();
        for _ in 0..steps {
            run.step();
        }
        (run, lines)
    }

    /// Runs the simulation to the end of the mission.
    fn finish(self, run: &mut Simulation) {
        while run.next_due().is_some_and(|due| due <= self.end()) {
            run.step();
        }
    }
}

/// Returns the step counts at which to freeze a mission: evenly distributed, and while calls are outstanding.
fn points(lines: &[String], after: &[usize]) -> Vec<usize> {
    let last = after.last().copied().unwrap_or(0);
    let mut points: Vec<usize> = (0..=4).map(|part| last * part / 5 + part).collect();
    let calls = lines
        .iter()
        .zip(after)
        .filter(|(line, _)| line.contains(" attempt "));
    // directly after a call, before its reply
    let calls: Vec<usize> = calls.map(|(_, step)| *step).collect();
    points.extend(calls.first());
    points.extend(calls.get(calls.len() / 2));
    points.sort_unstable();
    points.dedup();
    points
}

fn goes_on_elsewhere(mission: SpecsMission) {
    let (lines, after) = mission.reference();
    assert!(lines.len() > 100, "something happens");
    for steps in points(&lines, &after) {
        let (mut frozen_run, seen) = mission.advanced(steps);
        let frozen = frozen_run.freeze().unwrap();
        assert_eq!(
            frozen_run.freeze().unwrap(),
            frozen,
            "freezing changes nothing"
        );
        let (mut run, _) = mission.started();
        run.thaw(&frozen).unwrap();
        assert_eq!(run.freeze().unwrap(), frozen, "after {steps} steps");
        run.observe(note(&seen));
        mission.finish(&mut run);
        let seen = seen.lock().unwrap();
        let differs = lines
            .iter()
            .zip(&*seen)
            .position(|(whole, parts)| whole != parts);
        if let Some(at) = differs {
            panic!(
                "frozen after {steps} steps, line {at} differs:\n{:.400}\n{:.400}",
                lines[at], seen[at]
            );
        }
        assert_eq!(lines.len(), seen.len(), "frozen after {steps} steps");
    }
}

#[test]
fn navigation_goes_on_elsewhere() {
    goes_on_elsewhere(NAVIGATION);
}

#[test]
fn the_youbot_goes_on_elsewhere() {
    goes_on_elsewhere(YOUBOT);
}

#[test]
fn the_ball_tracker_goes_on_elsewhere() {
    goes_on_elsewhere(BALL_TRACKER);
}

#[test]
fn the_courier_goes_on_elsewhere() {
    goes_on_elsewhere(COURIER);
}

#[test]
fn a_frozen_run_itself_goes_on_unchanged() {
    let (lines, after) = COURIER.reference();
    let (mut run, seen) = COURIER.advanced(after.len() / 2);
    run.freeze().unwrap();
    COURIER.finish(&mut run);
    assert_eq!(*seen.lock().unwrap(), lines);
}

#[test]
fn a_state_thaws_twice_and_back_in_time() {
    let (mut run, _) = COURIER.advanced(50);
    let early = run.freeze().unwrap();
    let mut ends = Vec::new();
    for _ in 0..2 {
        run.run_for(5.s());
        ends.push(run.freeze().unwrap());
        run.thaw(&early).unwrap();
        assert_eq!(run.freeze().unwrap(), early);
    }
    assert_eq!(ends[0], ends[1]);
    assert_ne!(ends[0], early);
}

#[test]
fn a_state_of_another_composite_is_refused_and_nothing_changes() {
    let (mut tracker, _) = BALL_TRACKER.advanced(10);
    let (mut courier, _) = COURIER.advanced(10);
    let (theirs, own) = (tracker.freeze().unwrap(), courier.freeze().unwrap());
    let refused = courier.thaw(&theirs).unwrap_err();
    assert!(
        matches!(refused, SystemThawError::SystemMismatch(_)),
        "{refused}"
    );
    assert_eq!(courier.freeze().unwrap(), own);
}

/// Returns a frozen courier mission with modified entries.
fn changed(frozen: &FrozenSystem, change: impl Fn(&mut Vec<(String, Datum)>)) -> FrozenSystem {
    let Datum::Record(entries) = frozen.to_datum().unwrap() else {
        panic!("a frozen system is a record");
    };
    let entries = entries.into_iter();
    let mut entries = entries
        .map(|(name, value)| (name.into_owned(), value))
        .collect();
    change(&mut entries);
    FrozenSystem::from_bytes(cbor::encode(&Datum::record(entries)).unwrap())
}

#[test]
fn a_state_of_another_version_is_refused() {
    let (mut run, _) = COURIER.advanced(10);
    let own = run.freeze().unwrap();
    let newer = changed(&own, |entries| entries[0].1 = Datum::Int(4));
    assert_eq!(
        run.thaw(&newer).unwrap_err().to_string(),
        "the frozen system has layout 4, and this build has layout 3"
    );
    assert_eq!(run.freeze().unwrap(), own);
}

#[test]
fn truncated_and_changed_bytes_are_refused_or_thaw_and_never_panic() {
    let (mut run, _) = COURIER.advanced(40);
    let own = run.freeze().unwrap();
    let bytes = own.as_bytes();
    for end in (0..bytes.len()).step_by(bytes.len() / 150 + 1) {
        assert!(run.thaw(&FrozenSystem::from_bytes(&bytes[..end])).is_err());
    }
    assert_eq!(run.freeze().unwrap(), own);
    for at in (0..bytes.len()).step_by(bytes.len() / 300 + 1) {
        let mut strange = bytes.to_vec();
        strange[at] ^= 0x11;
        if run.thaw(&FrozenSystem::from_bytes(strange)).is_err() {
            assert_eq!(run.freeze().unwrap(), own, "byte {at}");
        } else {
            run.thaw(&own).unwrap();
        }
    }
    assert_eq!(run.freeze().unwrap(), own);
}
