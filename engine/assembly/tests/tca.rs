//! The ten properties of a component in the Task Component Architecture; tests are named after the rows of the paper's
//! table.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use crate::variables::Variables;
use asmotion_assembly::{CoordinatorOptions, Standard};
use asmotion_component::{Component, Cycle, Fault, Interface, State, Time, Transition};
use asmotion_composite::{AsmFiles, Constructor, Context, Tables};
use asmotion_coordinator::StepRecord;
use asmotion_lang::MemoryFiles;
use asmotion_plan::{Opened, Plan};
use asmotion_runtime::{Event, Run, Simulation};

asmotion_datum::message! {
    /// A test message with a number.
    #[derive(Copy)]
    pub struct Number = "test/Number" {
        /// Payload of the message.
        pub n: i64,
    }
}

/// A component without behaviour.
struct Task;

impl Component for Task {
    fn update(&mut self, _: &mut Cycle<'_>) -> Result<(), Fault> {
        Ok(())
    }
}

const COMPONENTS: &[(&str, Constructor)] = &[("test::Task", |interface: &mut Interface| {
    interface.output::<Number>("path", "where to");
    Box::new(Task)
})];

const BUILD: Tables = Tables {
    components: COMPONENTS,
    messages: &[("test/Number", <Number as asmotion_datum::Message>::schema)],
    interfaces: &[],
    builtins: &[],
    ros: None,
};

/// Returns a composite whose only component has these lines.
fn composite(lines: &str) -> String {
    format!(
        "schema = \"composite/1\"\n[composite]\nname = \"tca\"\n\n[components.Task]\n\
         implementation = {{ rust = \"test::Task\" }}\n{lines}\n"
    )
}

fn open(text: &str) -> Opened {
    let mut files = MemoryFiles::new();
    files.add("tca.toml", text);
    let context = Context {
        loader: &files,
        environment: &Variables,
        catalogue: &BUILD,
        specifications: &AsmFiles::new(&files),
        programs: &asmotion_composite::NoPrograms,
        settings: &[],
    };
    asmotion_plan::open("tca.toml", &context)
}

/// Returns the rendered diagnostics of a composite.
fn findings(text: &str) -> String {
    let opened = open(text);
    crate::render::report(&opened.sources, &opened.report)
}

fn plan(text: &str) -> Arc<Plan> {
    let opened = open(text);
    let said = crate::render::report(&opened.sources, &opened.report);
    opened
        .plan(None)
        .unwrap_or_else(|| panic!("{said}"))
        .clone()
}

/// Returns the planned component with this `task` table.
fn task(keys: &str) -> asmotion_plan::Component {
    let plan = plan(&composite(&format!("task = {{ {keys} }}")));
    plan.component("Task").expect("the task").clone()
}

/// Simulates the component with this `task` table.
fn simulated(keys: &str) -> Simulation {
    let plan = plan(&composite(&format!("task = {{ {keys} }}")));
    let files = MemoryFiles::new();
    let mut workshop = Standard::new(&BUILD, &files, CoordinatorOptions::seeded(1));
    let system = asmotion_assembly::start(&plan, &mut workshop).expect("a system");
    system.simulate()
}

#[test]
fn t15_an_id_is_unique_and_names_the_component_outside() {
    assert_eq!(task("id = \"planner\", period_ms = 10").id, "planner");
    assert_eq!(task("period_ms = 10").id, "Task");
    let twice = composite(
        "task = { id = \"one\" }\n[components.Other]\nimplementation = { rust = \"test::Task\" }\ntask = { id = \"one\" }",
    );
    let said = findings(&twice);
    assert!(said.contains("duplicate component id `one`"), "{said}");
    assert_eq!(
        said.matches(" | task = { id").count(),
        2,
        "both places: {said}"
    );
}

#[test]
fn t16_a_period_is_the_time_between_two_cycles_and_0_is_event_driven() {
    let mut run = simulated("period_ms = 50");
    run.run_for(Duration::from_secs(1));
    assert_eq!(run.cycles("Task"), 21);
    let changed = run.set_period("Task", Duration::from_millis(100));
    assert_eq!(changed, Ok(()));
    run.run_for(Duration::from_secs(1));
    assert!((10..=11).contains(&(run.cycles("Task") - 21)));
    let mut run = simulated("period_ms = 0");
    run.run_for(Duration::from_secs(1));
    assert!(run.cycles("Task") <= 1, "only its start");
}

#[test]
fn t17_a_delay_goes_before_the_first_cycle() {
    let mut run = simulated("period_ms = 50, delay_ms = 120");
    run.run_until(Time::ZERO + Duration::from_millis(119));
    assert_eq!(run.cycles("Task"), 0);
    run.run_until(Time::ZERO + Duration::from_millis(120));
    assert_eq!(run.cycles("Task"), 1);
}

#[test]
fn t18_one_that_does_not_run_on_startup_is_there_and_waits() {
    let mut run = simulated("period_ms = 50, run_on_startup = false");
    run.run_for(Duration::from_secs(1));
    assert_eq!(run.state("Task"), Some(State::Stopped));
    assert_eq!(run.cycles("Task"), 0);
    let started = run.transition("Task", Transition::Start);
    assert_eq!(started, Ok(()));
    run.run_for(Duration::from_secs(1));
    assert_eq!(run.cycles("Task"), 21);
}

#[test]
fn t19_only_who_says_so_may_be_interrupted() {
    assert!(!task("period_ms = 50").pace.may_interrupt_if_running);
    let may = task("period_ms = 50, may_interrupt_if_running = true");
    assert!(may.pace.may_interrupt_if_running);
}

/// A specification whose steps write their number to many locations.
const LONG: &str = "asm long
import StandardLibrary
signature:
	controlled step: Integer
	controlled cell: Integer -> Integer
definitions:
	main rule r_Main =
		par
			step := step + 1
			forall $i in {1 : 2000} do cell($i) := step + 1
		endpar
default init s0:
	function step = 0
";

#[test]
fn t19_a_step_that_is_cancelled_has_happened_or_has_not() {
    let mut files = MemoryFiles::new();
    files.add("long.asm", LONG);
    let text = composite("task = { period_ms = 1, may_interrupt_if_running = true }")
        .replace("rust = \"test::Task\"", "asm = \"long.asm\"");
    files.add("tca.toml", text);
    let context = Context {
        loader: &files,
        environment: &Variables,
        catalogue: &BUILD,
        specifications: &AsmFiles::new(&files),
        programs: &asmotion_composite::NoPrograms,
        settings: &[],
    };
    let opened = asmotion_plan::open("tca.toml", &context);
    let mut workshop = Standard::new(&BUILD, &files, CoordinatorOptions::seeded(1));
    let plan = opened.plan(None).expect("a plan");
    let mut system = asmotion_assembly::start(plan, &mut workshop).expect("a system");
    let steps: Arc<Mutex<Vec<StepRecord>>> = Arc::default();
    let seen = Arc::clone(&steps);
    system.observe(move |_: Time, event: &Event<'_>| {
        if let Event::Report { data: what, .. } = event {
            let record = what.to().expect("a record");
            seen.lock().expect("no poison").push(record);
        }
    });
    let mut run = system.live();
    for round in 0..20 {
        run.run_for(Duration::from_micros(3000 + 700 * round));
        let stopped = run.transition("Task", Transition::Stop);
        assert_eq!(stopped, Ok(()));
        assert_eq!(run.transition("Task", Transition::Start), Ok(()));
    }
    run.stop();
    let steps = steps.lock().expect("no poison");
    assert!(steps.len() > 20, "{}", steps.len());
    for (before, step) in steps.iter().enumerate() {
        let number = (before + 1).to_string();
        // after a cancellation the next step continues from a complete state
        assert_eq!(step.updates.len(), 2001);
        assert!(step.updates.iter().all(|update| update.after == number));
    }
}

const BROKER: &str =
    "\n[brokers.main]\nurl = \"amqp://${ROBOT_USER}:${ROBOT_PASSWORD_FILE}@desk:5672/cell\"";

#[test]
fn t20_a_component_goes_over_the_broker_it_names_and_else_stays_inside() {
    let broker = |text: &str| plan(text).broker_of("Task").map(str::to_owned);
    assert_eq!(broker(&composite("")), None);
    assert_eq!(broker(&composite(BROKER)).as_deref(), Some("main"));
    let second = BROKER.replace("main", "spare");
    let named = composite(&format!("task = {{ broker = \"spare\" }}{BROKER}{second}"));
    assert_eq!(broker(&named).as_deref(), Some("spare"));
    // if another component names a broker, this one remains local
    let other = "\n[components.Other]\nimplementation = { rust = \"test::Task\" }\ntask = { broker = \"main\" }";
    assert_eq!(broker(&composite(&format!("{other}{BROKER}"))), None);
    assert_eq!(broker(&composite(&format!("{BROKER}{second}"))), None);
    let said = findings(&composite(&format!(
        "task = {{ broker = \"mian\" }}{BROKER}"
    )));
    assert!(said.contains("did you mean `main`"), "{said}");
}

#[test]
fn t21_url_user_and_password_come_from_outside_and_are_never_shown() {
    let plan = plan(&composite(BROKER));
    let url = plan.brokers[0].url.as_ref().expect("an address");
    assert_eq!(url.reveal(), "amqp://robot:geheim@desk:5672/cell");
    let shown = format!("{plan:?}");
    assert!(!shown.contains("geheim"), "{shown}");
    let written = BROKER.replace("${ROBOT_PASSWORD_FILE}", "geheim");
    let said = findings(&composite(&written));
    assert!(said.contains("warning[C019]"), "{said}");
}

#[test]
fn t22_a_topic_is_renamed_and_a_misspelt_name_is_found() {
    let publish = "publish = { path = \"test/Number\" }\n";
    let plan = plan(&composite(&format!(
        "{publish}rename = {{ path = \"plan\" }}"
    )));
    let topics: Vec<_> = plan.topics.iter().map(|topic| &*topic.name).collect();
    assert_eq!(topics, ["plan"]);
    let said = findings(&composite(&format!(
        "{publish}rename = {{ paht = \"plan\" }}"
    )));
    assert!(
        said.contains("C052") && said.contains("did you mean `path`"),
        "{said}"
    );
}

#[test]
fn t23_all_ten_stand_in_the_plan() {
    let keys = "id = \"planner\", period_ms = 10, delay_ms = 5, run_on_startup = false, may_interrupt_if_running = true, broker = \"main\"";
    let lines = format!(
        "task = {{ {keys} }}\npublish = {{ path = \"test/Number\" }}\nrename = {{ path = \"plan\" }}{BROKER}"
    );
    let opened = open(&composite(&lines));
    let shown = asmotion_plan::expand(&opened, opened.plan(None).expect("a plan"));
    for property in [
        "id = \"planner\"",
        "period_ms = 10",
        "delay_ms = 5",
        "run_on_startup = false",
        "may_interrupt_if_running = true",
        "broker = \"main\"",
        "url = \"amqp://robot:***@desk:5672/cell\"",
        "rename = { path = \"plan\" }",
    ] {
        assert!(shown.contains(property), "{property}: {shown}");
    }
}
