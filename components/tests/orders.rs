//! Events of the navigation count only if they are about the last order: forged, replayed and late ones are refused.

use std::path::{Path as FilePath, PathBuf};
use std::sync::{Arc, Mutex};

use asmotion_assembly::{CoordinatorOptions, Standard};
use asmotion_component::{Span, Time, Transition};
use asmotion_composite::model::BuiltinComponent;
use asmotion_composite::{AsmFiles, Context, EmptyEnvironment, NoPrograms, Tables};
use asmotion_lang::Loader;
use asmotion_lang::diagnostics::LoadError;
use asmotion_messages::{Event, Path, Pose, PoseStamped, Time as Stamp};
use asmotion_runtime::{Event as RunEvent, Run, System};

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
        let near = FilePath::new(from).parent()?.join(import);
        let file = PathBuf::from(format!("{}.asm", near.display()));
        let found = [near, file].into_iter().find(|path| path.is_file());
        found.map(|path| path.display().to_string())
    }
}

/// The stamps of the orders of the coordinator.
type Orders = Arc<Mutex<Vec<Stamp>>>;

/// The navigation, and the orders that it will give.
fn navigation() -> (System, Orders) {
    let composite = "../specs/navigation/navigation.composite.toml";
    let path = FilePath::new(env!("CARGO_MANIFEST_DIR")).join(composite);
    let specifications = AsmFiles::new(&Specs);
    let context = Context {
        loader: &Specs,
        environment: &EmptyEnvironment,
        catalogue: &BUILD,
        specifications: &specifications,
        programs: &NoPrograms,
        settings: &[],
    };
    let path = path.canonicalize().unwrap().display().to_string();
    let opened = asmotion_plan::open(&path, &context);
    let mut workshop = Standard::new(&BUILD, &Specs, CoordinatorOptions::seeded(1));
    let plan = opened.plan(None).unwrap();
    let mut system = asmotion_assembly::start(plan, &mut workshop).unwrap();
    let orders = Orders::default();
    let heard = Arc::clone(&orders);
    system.observe(move |_: Time, event: &RunEvent<'_>| {
        if let RunEvent::Published {
            component: "TrajectoryAdapter",
            port: "adapted",
            sample,
            ..
        } = event
            && let Some(path) = sample.downcast_ref::<Path>()
        {
            let mut orders = heard.lock().unwrap();
            if orders.last() != Some(&path.header.stamp) {
                orders.push(path.header.stamp);
            }
        }
    });
    (system, orders)
}

fn mode(run: &mut dyn Run) -> String {
    let status = run.inspect("ASMCoordinator").unwrap_or_default();
    let state = status.iter().find(|(name, _)| name == "state");
    let mode = state.and_then(|(_, state)| state.get("mode"));
    let mode = mode.and_then(|mode| mode.as_text().map(str::to_owned));
    mode.unwrap_or_default()
}

/// Runs until the coordinator is in a mode.
fn run_until(run: &mut dyn Run, wanted: &str, seconds: u64) {
    let end = run.now() + seconds.s();
    while mode(run) != wanted {
        assert!(run.now() < end, "{} instead of {wanted}", mode(run));
        run.run_for(50.ms());
    }
}

fn send_event(run: &mut dyn Run, event: Event) {
    let now = run.now();
    run.publish_sample(now, "event", Arc::new(event)).unwrap();
    run.run_for(200.ms());
}

fn send_goal(run: &mut dyn Run, (x, y): (f64, f64)) {
    let now = run.now();
    let goal = PoseStamped {
        pose: Pose::planar(x, y, 0.0),
        ..PoseStamped::default()
    };
    run.publish_sample(now, "goal", Arc::new(goal)).unwrap();
}

fn reached() -> Event {
    Event::new(0, Event::REACHED, "forged")
}

fn refused(run: &dyn Run) -> u64 {
    run.losses("ASMCoordinator").misfits
}

/// Sends events that are not about the order under way, then a goal and an event about the first order.
fn deceive(run: &mut dyn Run, orders: &Orders) {
    run_until(run, "FOLLOWING", 10);
    run.run_for(200.ms());
    let first = *orders.lock().unwrap().last().unwrap();
    let other = Stamp {
        nanosec: first.nanosec + 1,
        ..first
    };
    let blocked = Event::new(0, Event::BLOCKED, "forged").about(other);
    for forged in [reached(), reached().about(other), blocked] {
        send_event(run, forged);
        assert_eq!(mode(run), "FOLLOWING");
    }
    assert_eq!(refused(run), 3);
    send_goal(run, (4.4, 4.7));
    run_until(run, "STOPPING", 2);
    // the rover still rolls, and the order to stop is another one
    send_event(run, Event::new(0, Event::HALTED, "forged").about(first));
    run_until(run, "FOLLOWING", 10);
    send_event(run, reached().about(first));
    assert!(orders.lock().unwrap().len() >= 3);
    assert_eq!(mode(run), "FOLLOWING");
    assert_eq!(refused(run), 5);
}

#[test]
fn forged_and_late_events_do_not_end_the_mission() {
    let (system, orders) = navigation();
    let mut run = system.simulate();
    deceive(&mut run, &orders);
    run_until(&mut run, "ARRIVED", 60);
    assert_eq!(refused(&run), 5);
}

#[test]
fn forged_and_late_events_do_not_end_the_mission_on_the_wall_clock() {
    let (system, orders) = navigation();
    let mut run = system.live();
    deceive(&mut run, &orders);
    run.stop();
}

#[test]
fn an_event_about_the_last_order_counts() {
    let (system, orders) = navigation();
    let mut run = system.simulate();
    run_until(&mut run, "FOLLOWING", 10);
    run.run_for(200.ms());
    let order = *orders.lock().unwrap().last().unwrap();
    send_event(&mut run, reached().about(order));
    assert_eq!((&*mode(&mut run), refused(&run)), ("ARRIVED", 0));
}

#[test]
fn a_follower_that_was_restarted_answers_the_next_orders() {
    let (system, _) = navigation();
    let mut run = system.simulate();
    run_until(&mut run, "FOLLOWING", 10);
    run.run_for(5.s());
    for transition in [Transition::Stop, Transition::Start] {
        run.transition("TrajectoryFollower", transition).unwrap();
        run.run_for(100.ms());
    }
    send_goal(&mut run, (9.2, 4.2));
    run_until(&mut run, "STOPPING", 2);
    run_until(&mut run, "ARRIVED", 90);
    assert_eq!(refused(&run), 0);
}
