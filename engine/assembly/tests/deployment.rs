//! Deployment (O3, O12, O13): scheduling, site-specific overlays and stop order.

use asmotion_assembly::{CoordinatorOptions, Standard};
use asmotion_component::{Component, Cycle, Fault, Interface, Property, Span};
use asmotion_composite::{Context, Tables};
use asmotion_datum::Datum;
use asmotion_lang::MemoryFiles;
use asmotion_plan::Opened;
use asmotion_runtime::{Log, Run, System};

const BUILD: Tables = Tables {
    components: &[
        ("test::Teller", |_: &mut Interface| Box::new(Teller)),
        ("test::Pid", |interface: &mut Interface| {
            Box::new(Pid::new(interface))
        }),
    ],
    ..Tables::EMPTY
};

fn open(files: &MemoryFiles, path: &str) -> Opened {
    let context = Context {
        catalogue: &BUILD,
        ..Context::files(files)
    };
    asmotion_plan::open(path, &context)
}

fn start(files: &MemoryFiles, opened: &Opened) -> System {
    let plan = opened.plan(None).expect("a plan");
    let mut workshop = Standard::new(&BUILD, files, CoordinatorOptions::seeded(0));
    asmotion_assembly::start(plan, &mut workshop).expect("a system")
}

fn said(opened: &Opened) -> String {
    crate::render::report(&opened.sources, &opened.report)
}

/// Reports the scheduling of its thread.
struct Teller;

impl Component for Teller {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        let stat = std::fs::read_to_string("/proc/thread-self/stat")?;
        // the fields after the process name, which is in parentheses and may contain blanks
        let fields = stat.rsplit(')').next().unwrap_or_default();
        let fields: Vec<_> = fields.split_whitespace().collect();
        let status = std::fs::read_to_string("/proc/thread-self/status")?;
        let mut status = status.lines();
        let cpus = status.find_map(|line| line.strip_prefix("Cpus_allowed_list:\t"));
        let (priority, policy) = (fields[37], fields[38]);
        let told = format!("policy {policy}, {priority}, on {}", cpus.unwrap_or("?"));
        cycle.report("schedule", Datum::text(told));
        Ok(())
    }
}

const COMPOSITE: &str = r#"
schema = "composite/1"
[composite]
name = "scheduled"

[components.Silent]
implementation = { rust = "test::Teller" }
activity = { period_ms = 10 }
[components.Own]
implementation = { rust = "test::Teller" }
activity = { period_ms = 10, scheduler = "other", cpu = [1] }
[components.Higher]
implementation = { rust = "test::Teller" }
activity = { period_ms = 10, priority = 50 }

[deploy]
processes = [
  { name = "all", components = ["Silent", "Own", "Higher"], scheduler = "fifo", priority = 30, cpu = [0] },
]
"#;

const THREADS: &str = r#"
schema = "composite/1"
[composite]
name = "threads"

[components.Plain]
implementation = { rust = "test::Teller" }
activity = { period_ms = 10 }
[components.Chosen]
implementation = { rust = "test::Teller" }
task = { period_ms = 10, thread = "own" }
[components.Limited]
implementation = { rust = "test::Teller" }
activity = { period_ms = 10, deadline_ms = 500 }
[components.Relaxed]
implementation = { rust = "test::Teller" }
activity = { period_ms = 10, deadline_ms = 500, thread = "shared" }
[components.Pinned]
implementation = { rust = "test::Teller" }
activity = { period_ms = 10 }
[components.Master]
implementation = { rust = "test::Teller" }
activity = { period_ms = 10 }
[components.Slave]
implementation = { rust = "test::Teller" }
activity = { master = "Master", deadline_ms = 400 }

[deploy]
processes = [
  { name = "any", components = ["Plain", "Chosen", "Limited", "Relaxed", "Master", "Slave"] },
  { name = "first", components = ["Pinned"], cpu = [0] },
]
"#;

#[test]
fn a_component_has_the_thread_that_its_composite_asks_for() {
    let mut files = MemoryFiles::new();
    files.add("main.toml", THREADS);
    let opened = open(&files, "main.toml");
    assert_eq!(said(&opened), "", "nothing is without effect");
    let plan = opened.plan(None).expect("a plan");
    let run = start(&files, &opened).live();
    let found = plan.threads().map(|(component, thread)| {
        let running = run.thread_use(&component.name).map(|it| it.to_string());
        let running = running.unwrap_or_default();
        format!("{}: {}, {running}", component.name, thread)
    });
    // the plan and the running system agree
    assert_eq!(
        found.collect::<Vec<_>>(),
        [
            "Plain: executor, shared",
            "Chosen: own (as `thread` says), own",
            "Limited: own (deadline 500 ms), own",
            "Relaxed: executor, shared",
            "Pinned: own (processors [0]), own",
            "Master: own (deadline 400 ms), own",
            "Slave: that of `Master`, own",
        ]
    );
}

#[cfg(target_os = "linux")]
#[test]
fn o3_a_process_says_how_its_components_are_scheduled_that_do_not_say_it_themselves() {
    let mut files = MemoryFiles::new();
    files.add("main.toml", COMPOSITE);
    let opened = open(&files, "main.toml");
    assert_eq!(said(&opened), "", "nothing is without effect");
    let mut system = start(&files, &opened);
    let log = Log::new();
    system.observe(log.clone());
    let mut run = system.live();
    run.run_for(200.ms());
    let tells = |component: &str| {
        let lines = log.lines_with(&format!("{component}: schedule: "));
        let line = lines.first().expect("it runs");
        line.rsplit("schedule: ")
            .next()
            .unwrap_or_default()
            .to_owned()
    };
    let denied = log.lines_with("is not permitted");
    let (fifo_30, fifo_50) = if denied.is_empty() {
        ("policy 1, 30", "policy 1, 50")
    } else {
        eprintln!("not tried: this program may not run at FIFO");
        assert!(denied.iter().any(|line| line.contains("Silent: FIFO 30 ")));
        assert!(denied.iter().any(|line| line.contains("Higher: FIFO 50 ")));
        assert!(
            !denied.iter().any(|line| line.contains("Own")),
            "{denied:?}"
        );
        ("policy 0, 0", "policy 0, 0")
    };
    assert_eq!(tells("Silent"), format!("\"{fifo_30}, on 0\""));
    assert_eq!(tells("Higher"), format!("\"{fifo_50}, on 0\""));
    assert_eq!(tells("Own"), "\"policy 0, 0, on 1\"");
}

/// A component with array and list properties.
struct Pid {
    gains: [Property<f64>; 2],
    limits: Property<Vec<f64>>,
}

impl Pid {
    fn new(interface: &mut Interface) -> Self {
        let mut gain = |name: &str, doc: &str| {
            let setting = interface.setting(name, 1.0, doc);
            setting.range(0.0..=10.0).unit("1/s").declare()
        };
        Self {
            gains: [gain("kp", "for the error"), gain("ki", "for its sum")],
            limits: interface.property("limits", vec![-1.0, 1.0], "of what is put out"),
        }
    }
}

impl Component for Pid {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        let [kp, ki] = self.gains.map(|gain| cycle.property(gain));
        let limits = cycle.property(self.limits);
        cycle.report("gains", Datum::text(format!("{kp} {ki} {limits:?}")));
        Ok(())
    }
}

const PID: &str = r#"
schema = "composite/1"
[composite]
name = "controlled"

[components.Pid]
implementation = { rust = "test::Pid" }
task = { period_ms = 10 }
properties = { kp = 2.0 }
load = "pid.toml"

[components.Other]
implementation = { rust = "test::Pid" }
task = { period_ms = 10 }
"#;

fn controlled(pid: &str, site: &str) -> MemoryFiles {
    let mut files = MemoryFiles::new();
    files.add("all/main.toml", PID);
    files.add("all/pid.toml", pid);
    files.add(
        "lab/site.toml",
        format!("schema = \"composite/1\"\nbase = \"../all/main.toml\"\n{site}"),
    );
    files.add("lab/pid.toml", "kp = 5\nki = 6.0\n");
    files
}

/// Returns the log of a composite's first 25 ms.
fn first_lines(files: &MemoryFiles, path: &str) -> Vec<String> {
    let opened = open(files, path);
    assert_eq!(said(&opened), "");
    let mut system = start(files, &opened);
    let log = Log::new();
    system.observe(log.clone());
    system.simulate().run_for(25.ms());
    log.lines_with("gains")
}

#[test]
fn o12_a_component_loads_properties_and_its_own_hold() {
    let files = controlled("kp = 3.0\nki = 0.5\nlimits = [0, 2]\n", "");
    let lines = first_lines(&files, "all/main.toml");
    assert_eq!(lines[0], "0 s Pid: gains: \"2 0.5 [0.0, 2.0]\"");
    assert_eq!(lines[1], "0 s Other: gains: \"1 1 [-1.0, 1.0]\"");
}

#[test]
fn o12_what_is_wrong_in_a_loaded_file_is_shown_there() {
    let files = controlled("kq = 1.0\nki = 11.0\nlimits = \"wide\"\n", "");
    insta::assert_snapshot!(said(&open(&files, "all/main.toml")));
}

#[test]
fn o13_a_site_changes_a_period_and_properties_and_nothing_else() {
    let site = "[components.Pid.task]\nperiod_ms = 20\n[components.Other]\nload = \"pid.toml\"\n";
    let files = controlled("ki = 0.5\n", site);
    assert_eq!(
        first_lines(&files, "lab/site.toml"),
        [
            "0 s Pid: gains: \"2 0.5 [-1.0, 1.0]\"",
            "0 s Other: gains: \"5 6 [-1.0, 1.0]\"",
            "0.01 s Other: gains: \"5 6 [-1.0, 1.0]\"",
            "0.02 s Pid: gains: \"2 0.5 [-1.0, 1.0]\"",
            "0.02 s Other: gains: \"5 6 [-1.0, 1.0]\"",
        ]
    );
}

#[test]
fn o13_a_site_leaves_elements_of_its_base_out() {
    let without = [
        "components.Other",
        "components.Pid.load",
        "components.Pid.properties.kp",
    ];
    let site = format!("without = {without:?}\n");
    let files = controlled("ki = 0.5\n", &site);
    assert_eq!(
        first_lines(&files, "lab/site.toml"),
        [
            "0 s Pid: gains: \"1 1 [-1.0, 1.0]\"",
            "0.01 s Pid: gains: \"1 1 [-1.0, 1.0]\"",
            "0.02 s Pid: gains: \"1 1 [-1.0, 1.0]\"",
        ]
    );
}

/// A site removes a component and declares another one of the same name, which is not merged with it.
#[test]
fn o13_a_site_replaces_a_component_of_its_base() {
    let site = "without = [\"components.Pid\"]\n[components.Pid]\n\
                implementation = { rust = \"test::Pid\" }\ntask = { period_ms = 20 }\n";
    let files = controlled("ki = 0.5\n", site);
    let lines = first_lines(&files, "lab/site.toml");
    assert_eq!(lines[0], "0 s Other: gains: \"1 1 [-1.0, 1.0]\"");
    assert_eq!(lines[1], "0 s Pid: gains: \"1 1 [-1.0, 1.0]\"", "{lines:?}");
}

#[test]
fn o13_what_is_wrong_with_a_site_is_shown_there() {
    let site =
        "[components.Pit]\ntask = { period_ms = 20 }\n[components.Pid.properties]\nkp = 12\n";
    let files = controlled("", site);
    insta::assert_snapshot!(said(&open(&files, "lab/site.toml")));
}

#[test]
fn o13_a_site_of_itself_is_refused() {
    let mut files = MemoryFiles::new();
    files.add("a.toml", "base = \"b.toml\"\n");
    files.add("b.toml", "base = \"a.toml\"\n");
    insta::assert_snapshot!(said(&open(&files, "a.toml")));
}

#[test]
fn o13_components_stop_in_reverse_order_of_their_start() {
    let files = controlled("", "");
    let mut system = start(&files, &open(&files, "all/main.toml"));
    let log = Log::new();
    system.observe(log.clone());
    let mut run = system.simulate();
    run.run_for(25.ms());
    assert!(run.stop().is_empty());
    assert_eq!(
        log.lines_with("Stopped -> Running"),
        [
            "0 s Pid: Stopped -> Running",
            "0 s Other: Stopped -> Running"
        ]
    );
    assert_eq!(
        log.lines_with("Running -> Stopped"),
        [
            "0.025 s Other: Running -> Stopped",
            "0.025 s Pid: Running -> Stopped"
        ]
    );
}
