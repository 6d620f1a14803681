//! Execution of composites in simulated time.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::sync::Arc;

use crate::variables::Variables;
use asmotion_assembly::{CoordinatorOptions, Standard, StartError};
use asmotion_component::declaration::OperationDeclaration;
use asmotion_component::{
    Component, Cycle, Fault, In, Interface, Operation, Out, Property, Provided, Span,
};
use asmotion_composite::{AsmFiles, Constructor, Context, Tables};
use asmotion_coordinator::{Action, Argument, Effect};
use asmotion_datum::{Datum, Message, Schema};
use asmotion_diagnostics::{LoadError, Loader};
use asmotion_lang::MemoryFiles;
use asmotion_plan::Opened;
use asmotion_runtime::{Log, Run, System};

asmotion_datum::message! {
    /// A test event.
    pub struct Event = "test/Event" {
        /// Code of the event.
        pub code: String,
        /// Additional information.
        pub detail: String,
    }

    /// A test message with a number.
    #[derive(Copy)]
    pub struct Number = "test/Number" {
        /// Payload of the message.
        pub n: i64,
    }
}

struct Double;

impl Operation for Double {
    type Request = Number;
    type Response = Number;
    const INTERFACE: &'static str = "test/Arithmetic";
    const NAME: &'static str = "double";
}

/// Publishes GO in its third cycle.
struct Starter {
    event: Out<Event>,
    code: Property<String>,
    cycles: u32,
}

impl Component for Starter {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        self.cycles += 1;
        if self.cycles == 3 {
            let code = cycle.property(self.code).clone();
            cycle.write(
                self.event,
                Event {
                    code,
                    detail: String::new(),
                },
            );
        }
        Ok(())
    }
}

/// Provides a service that doubles numbers.
struct Doubler {
    double: Provided<Double>,
}

impl Component for Doubler {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        for request in cycle.requests(self.double) {
            let n = request.argument.n * 2;
            cycle.reply(self.double, request.id, Ok(Number { n }));
        }
        Ok(())
    }
}

/// Publishes the messages it receives.
struct Echo {
    input: In<Number>,
    output: Out<Number>,
}

impl Component for Echo {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        for number in cycle.all(self.input).to_vec() {
            cycle.write(self.output, number);
        }
        Ok(())
    }
}

const COMPONENTS: &[(&str, Constructor)] = &[
    ("test::Starter", |interface: &mut Interface| {
        Box::new(Starter {
            event: interface.output("event", "GO"),
            code: interface.property("code", "GO".to_owned(), "code sent"),
            cycles: 0,
        })
    }),
    ("test::Doubler", |interface: &mut Interface| {
        Box::new(Doubler {
            double: interface.serve("sums", "doubles"),
        })
    }),
    ("test::Echo", |interface: &mut Interface| {
        let input = interface.input("number", "in");
        Box::new(Echo {
            input,
            output: interface.output("number", "out"),
        })
    }),
];

fn double() -> Vec<OperationDeclaration> {
    vec![OperationDeclaration {
        while_stopped: false,
        name: Double::NAME.to_owned(),
        request: Number::schema().clone(),
        response: Number::schema().clone(),
    }]
}

const BUILD: Tables = Tables {
    components: COMPONENTS,
    messages: &[
        (Event::NAME, Event::schema as fn() -> &'static Schema),
        (Number::NAME, Number::schema as fn() -> &'static Schema),
    ],
    interfaces: &[(Double::INTERFACE, double)],
    builtins: &[],
    ros: None,
};

const SPECIFICATION: &str = "asm brain
import StandardLibrary
signature:
	enum domain Action = {NOACT | ASK | TELL}
	enum domain Ev = {NOEV | GO | ANSWER | FAILED}
	monitored ev: Ev
	out command: Action
definitions:
	main rule r_Main =
		par
			if ev = GO then command := ASK endif
			if ev = ANSWER then command := TELL endif
		endpar
default init s0:
	function command = NOACT
";

const COMPOSITE: &str = r#"
schema = "composite/1"
[composite]
name = "test"

[properties]
n = { type = "i64", default = 21, min = 0, max = 100 }

[components.Starter]
implementation = { rust = "test::Starter" }
task = { period_ms = 10 }
publish = { event = "test/Event" }
properties = { code = "GO" }

[components.Brain]
implementation = { asm = "brain.asm", main = "r_Main" }
task = { period_ms = 10 }
subscribe = { event = "test/Event" }
publish = { answer = "test/Number" }
references = { sums = "test/Arithmetic" }
bind.monitored = { ev = { topic = "event", receive = "all", map = "code", none = "NOEV" } }

[components.Brain.bind.out.command]
ASK = { call = "sums.double", with = { n = "${properties.n}" }, keep = "twice", ok = "ANSWER", failed = "FAILED", event = "ev" }
TELL = { publish = "answer", value = "@twice" }

[components.Nested]
implementation = { composite = "nested.toml" }

[[wires]]
reference = "Brain.sums"
service = "Nested.sums"
timeout_ms = 100

[[connections]]
from = "topic:answer"
to = "Nested.number"
policy = { type = "buffer", size = 4 }
"#;

const NESTED: &str = r#"
schema = "composite/1"
[composite]
name = "nested"

[components.Doubler]
implementation = { rust = "test::Doubler" }

[components.Echo]
implementation = { rust = "test::Echo" }
ports.in = { number = "test/Number" }
publish = { number = "test/Number" }
rename = { number = "echo" }

[[promote]]
service = "Doubler.sums"
as = "sums"

[[promote]]
port = "Echo.number"
as = "number"
"#;

fn files(composite: &str) -> MemoryFiles {
    let mut files = MemoryFiles::new();
    files.add("main.toml", composite);
    files.add("nested.toml", NESTED);
    files.add("brain.asm", SPECIFICATION);
    files
}

fn open(files: &MemoryFiles, settings: &[(String, String)]) -> Opened {
    let specifications = AsmFiles::new(files);
    let context = Context {
        loader: files,
        environment: &Variables,
        catalogue: &BUILD,
        specifications: &specifications,
        programs: &asmotion_composite::NoPrograms,
        settings,
    };
    let opened = asmotion_plan::open("main.toml", &context);
    assert!(
        !opened.report.has_errors(),
        "{}",
        crate::render::report(&opened.sources, &opened.report)
    );
    opened
}

fn start(files: &MemoryFiles, plan: &asmotion_plan::Plan) -> Result<System, StartError> {
    let mut workshop = Standard::new(&BUILD, files, CoordinatorOptions::seeded(1));
    asmotion_assembly::start(plan, &mut workshop)
}

/// Returns the final output of the innermost component.
fn echoes(composite: &str, settings: &[(String, String)]) -> Vec<i64> {
    let files = files(composite);
    let opened = open(&files, settings);
    assert_eq!(opened.report.diagnostics, [], "no warnings either");
    let mut system = start(&files, opened.plan(None).expect("a plan")).expect("a system");
    let log = Log::new();
    system.observe(log.clone());
    system.simulate().run_for(1.s());
    log.samples::<Number>("Nested/Echo.number")
        .into_iter()
        .map(|(_, number)| number.n)
        .collect()
}

#[test]
fn it_runs_from_an_event_over_a_call_to_a_message_in_a_nested_composite() {
    assert_eq!(echoes(COMPOSITE, &[]), [42]);
}

#[test]
fn it_takes_properties_from_outside() {
    assert_eq!(
        echoes(COMPOSITE, &[("n".to_owned(), "50".to_owned())]),
        [100]
    );
}

#[test]
fn it_puts_properties_into_components() {
    let composite = COMPOSITE.replace("code = \"GO\"", "code = \"NOEV\"");
    assert_eq!(echoes(&composite, &[]), [0; 0]);
}

#[test]
fn it_runs_the_same_way_each_time() {
    let run = || {
        let files = files(COMPOSITE);
        let opened = open(&files, &[]);
        let mut system = start(&files, opened.plan(None).expect("a plan")).expect("a system");
        let log = Log::new();
        system.observe(log.clone());
        system.simulate().run_for(200.ms());
        log.lines()
    };
    assert_eq!(run(), run());
}

#[test]
fn it_refuses_to_start_without_its_variables() {
    let composite = COMPOSITE.replace("code = \"GO\"", "code = \"${ROBOT_CODE}\"");
    let files = files(&composite);
    let opened = open(&files, &[]);
    let error = start(&files, opened.plan(None).expect("a plan"))
        .map(|_| ())
        .unwrap_err();
    assert_eq!(
        error.to_string(),
        "environment variables not set: ROBOT_CODE"
    );
}

#[test]
fn it_refuses_to_start_what_is_not_in_the_build() {
    let composite = COMPOSITE.replace("rust = \"test::Starter\"", "process = \"starter\"");
    let files = files(&composite);
    let opened = open(&files, &[]);
    let error = start(&files, opened.plan(None).expect("a plan"))
        .map(|_| ())
        .unwrap_err();
    assert_eq!(
        error.to_string(),
        "`Starter` cannot be created: its program was not asked for its declaration"
    );
}

#[test]
fn it_puts_the_binding_into_the_plan_without_places_and_substitutions() {
    let files = files(COMPOSITE);
    let opened = open(&files, &[]);
    let plan = opened.plan(None).expect("a plan");
    let brain = plan.component("Brain").expect("the brain");
    let bound = brain.binding.as_ref().expect("a binding");
    let Effect::Literals(cases) = &bound.out[0].effect else {
        panic!("literals");
    };
    let Action::Call(call) = &cases[0].actions[0] else {
        panic!("a call");
    };
    let n = Argument::Value(Datum::Int(21).into());
    assert_eq!(call.with, Argument::Record(vec![("n".to_owned(), n)]));
    assert_eq!(
        plan.start_order,
        ["Starter", "Nested/Doubler", "Brain", "Nested/Echo"]
    );
}

#[test]
fn it_keeps_secrets_out_of_everything_that_is_shown() {
    let broker = "[brokers.main]\nurl = \"amqp://${ROBOT_USER}:${ROBOT_PASSWORD_FILE}@h:5672\"\n";
    let secret = "s = { type = \"secret\", default = \"geheim\" }\n";
    let composite = format!("{broker}{COMPOSITE}").replace("[brokers", "\n[brokers");
    let composite = composite.replacen("schema = \"composite/1\"\n", "", 1);
    let composite = format!("schema = \"composite/1\"\n{composite}")
        .replace("[properties]\n", &format!("[properties]\n{secret}"))
        .replace("code = \"GO\"", "code = \"${properties.s}\"");
    let files = files(&composite);
    let opened = open(&files, &[]);
    let plan = opened.plan(None).expect("a plan");
    let shown = format!("{plan:?}{}", asmotion_plan::expand(&opened, plan));
    assert!(!shown.contains("geheim"), "{shown}");
    let url = plan.brokers[0].url.as_ref().expect("an address");
    assert_eq!(url.reveal(), "amqp://robot:geheim@h:5672");
    assert_eq!(url.shown(), "amqp://robot:***@h:5672");
    assert!(start(&files, plan).is_ok());
}

#[test]
fn it_takes_paths_from_the_folder_of_the_file_they_are_written_in() {
    let inner = "schema = \"composite/1\"\n[composite]\nname = \"inner\"\n\
        [properties]\nmap = { type = \"path\", default = \"own.png\" }\n\
        [components.X]\nimplementation = { process = \"x\" }\nproperties = { map = \"${properties.map}\" }\n";
    let outer = |set: &str| {
        format!(
            "schema = \"composite/1\"\n[composite]\nname = \"outer\"\n\
             [properties]\nmaps = {{ type = \"path\", default = \"maps\" }}\n\
             [components.In]\nimplementation = {{ composite = \"deep/inner.toml\" }}\n{set}"
        )
    };
    let map = |set: &str| {
        let mut files = MemoryFiles::new();
        files.add("here/main.toml", outer(set));
        files.add("here/deep/inner.toml", inner);
        let opened = asmotion_plan::open("here/main.toml", &Context::files(&files));
        let plan = opened.plan(None).expect("a plan");
        let map = plan.components[0].properties.get("map").expect("a map");
        map.to_string()
    };
    assert_eq!(map(""), "\"here/deep/own.png\"");
    assert_eq!(map("properties = { map = \"a.png\" }\n"), "\"here/a.png\"");
    assert_eq!(map("properties = { map = \"/a.png\" }\n"), "\"/a.png\"");
    assert_eq!(
        map("properties = { map = \"${properties.maps}\" }\n"),
        "\"here/maps\""
    );
}

const TELLER: &str = "asm teller
import StandardLibrary
import CommonBehavior
signature:
	domain Listeners subsetof Agent
	static listeners: Listeners
	static asked: Listeners
	out hear: Prod(Listeners, Integer) -> Rule
	controlled told: Boolean
	controlled answer: Integer
definitions:
	main rule r_Main =
		if not told then par
			r_wsend[listeners, \"hear\", 7]
			told := true
		endpar endif
default init s0:
	function told = false
";

const LISTENER: &str = "asm listener
import StandardLibrary
import CommonBehavior
signature:
	controlled heard: Integer
	out hear: Prod(Agent, Integer) -> Rule
definitions:
	main rule r_Main =
		if nextRequest(self) = \"hear\" then r_wreceive[undef, \"hear\", heard] endif
default init s0:
	function heard = 0
";

/// A specification that notifies two components.
const TOLD: &str = r#"
schema = "composite/1"
[composite]
name = "told"
[components.Teller]
implementation = { asm = "teller.asm" }
task = { period_ms = 10, delay_ms = 10 }
references = { listeners = "test/Listener" }
[components.One]
implementation = { asm = "listener.asm" }
task = { period_ms = 10 }
services = { notifying = "test/Listener" }
[components.Two]
implementation = { asm = "listener.asm" }
task = { period_ms = 10 }
services = { notifying = "test/Listener" }
[[wires]]
reference = "Teller.listeners"
service = ["One.notifying", "Two.notifying"]
"#;

fn told(specification: &str) -> MemoryFiles {
    let mut files = MemoryFiles::new();
    files.add("main.toml", TOLD);
    files.add("teller.asm", specification);
    files.add("listener.asm", LISTENER);
    files
}

#[test]
fn y10_what_is_sent_to_a_reference_reaches_all_of_its_services() {
    let files = told(TELLER);
    let opened = open(&files, &[]);
    let mut system = start(&files, opened.plan(None).expect("a plan")).expect("a system");
    let log = Log::new();
    system.observe(log.clone());
    system.simulate().run_for(1.s());
    let heard = log.lines_with("heard");
    assert_eq!(heard.len(), 2, "{:#?}", log.lines());
    assert!(
        heard[0].contains("One") && heard[1].contains("Two"),
        "{heard:?}"
    );
}

#[test]
fn y10_a_specification_that_waits_for_an_answer_has_one_service() {
    let asks = TELLER.replace(
        "r_wsend[listeners, \"hear\", 7]",
        "r_wsendreceive[listeners, \"hear\", 7, answer]",
    );
    let files = told(&asks);
    let context = Context {
        loader: &files,
        environment: &Variables,
        catalogue: &BUILD,
        specifications: &AsmFiles::new(&files),
        programs: &asmotion_composite::NoPrograms,
        settings: &[],
    };
    let opened = asmotion_plan::open("main.toml", &context);
    let said = crate::render::report(&opened.sources, &opened.report);
    assert!(
        said.contains("C034") && said.contains("waits for the reply to `hear`"),
        "{said}"
    );
}

/// Two components connected by a message queue, as if in separate processes.
const QUEUED: &str = r#"
schema = "composite/1"
[composite]
name = "queued"

[components.Writer]
implementation = { rust = "test::Echo" }

[components.Reader]
implementation = { rust = "test::Echo" }

[[promote]]
port = "Writer.number"
as = "numbers"

[[connections]]
from = "Writer.number"
to = "mqueue:/asmotion-NAME"
policy = { type = "buffer", size = 4 }

[[connections]]
from = "mqueue:/asmotion-NAME"
to = "Reader.number"
policy = { type = "buffer", size = 4 }
"#;

#[cfg(target_os = "linux")]
#[test]
fn o17_ports_join_over_a_message_queue() {
    let composite = QUEUED.replace("NAME", &format!("start-{}", std::process::id()));
    let files = files(&composite);
    let opened = open(&files, &[]);
    let mut system = start(&files, opened.plan(None).expect("a plan")).expect("a system");
    let log = Log::new();
    system.observe(log.clone());
    let mut run = system.live();
    for n in 1..=3 {
        let now = run.now();
        run.inject(now, "Writer.number", Number { n })
            .expect("a port");
    }
    let until = run.now() + 5.s();
    run.run_until_event(until, &mut |_, event| {
        matches!(
            event,
            asmotion_runtime::Event::Published {
                component: "Reader",
                sequence: 3,
                ..
            }
        )
    });
    let read = log.samples::<Number>("Reader.number").into_iter();
    // the first message of a queue consists of zeros and is discarded
    assert_eq!(
        read.map(|(_, number)| number.n).collect::<Vec<_>>(),
        [1, 2, 3]
    );
}

/// A writer of the newest value, which is of no use after 300 ms.
const AGEING: &str = r#"
schema = "composite/1"
[composite]
name = "ageing"

[components.Writer]
implementation = { rust = "test::Echo" }

[[promote]]
port = "Writer.number"
as = "numbers"

[[connections]]
from = "Writer.number"
to = "mqueue:/asmotion-NAME"
policy = { type = "data", max_age_ms = 300 }
"#;

#[cfg(target_os = "linux")]
#[test]
fn a_data_connection_to_a_queue_keeps_one_message_which_ages_while_the_writer_is_quiet() {
    let name = format!("ageing-{}", std::process::id());
    let files = files(&AGEING.replace("NAME", &name));
    let opened = open(&files, &[]);
    let mut system = start(&files, opened.plan(None).expect("a plan")).expect("a system");
    system.observe(Log::new());
    let mut run = system.live();
    let layout = asmotion_mqueue::QueueLayout::of(Number::schema()).expect("a layout");
    let reader = || {
        let name = asmotion_mqueue::QueueName::new(&format!("/asmotion-{name}")).expect("a name");
        asmotion_mqueue::QueueReader::new(name, layout.clone())
    };
    let mut published = 0;
    for n in 1..=5 {
        let now = run.now();
        run.inject(now, "Writer.number", Number { n })
            .expect("a port");
        let until = run.now() + 5.s();
        run.run_until_event(until, &mut |_, event| {
            let is_published = matches!(event, asmotion_runtime::Event::Published { .. });
            published += u32::from(is_published);
            is_published
        });
    }
    assert_eq!(published, 5);
    let mut first = reader();
    let mut read = Vec::new();
    for _ in 0..3 {
        if let Some(asmotion_mqueue::QueueEvent::Message(datum)) =
            first.next(std::time::Duration::from_millis(20))
        {
            read.push(datum.to::<Number>().expect("a number").n);
        }
    }
    // on a busy machine the reader can take the one before in the moment in which the newest replaces it
    assert!(
        matches!(read[..], [5] | [4, 5]),
        "the newest alone: {read:?}"
    );
    let now = run.now();
    run.inject(now, "Writer.number", Number { n: 6 })
        .expect("a port");
    let until = run.now() + 5.s();
    let mut reason = String::new();
    run.run_until_event(until, &mut |_, event| {
        if let asmotion_runtime::Event::Dropped {
            total: 1,
            reason: Some(why),
            ..
        } = event
        {
            reason = why.to_string();
        }
        !reason.is_empty()
    });
    assert!(reason.contains("not read within 300ms"), "{reason}");
    assert_eq!(first.next(std::time::Duration::from_millis(50)), None);
}

#[cfg(target_os = "linux")]
#[test]
fn it_says_why_a_message_queue_cannot_be_made() {
    let composite = QUEUED.replace("NAME", &format!("large-{}", std::process::id()));
    let composite = composite.replace("size = 4 ", "size = 1000000 ");
    let files = files(&composite);
    let opened = open(&files, &[]);
    let refused = start(&files, opened.plan(None).expect("a plan")).map(|_| ());
    let refused = refused.unwrap_err().to_string();
    assert!(
        refused.starts_with("`Writer.number`: mqueue:/asmotion-large"),
        "{refused}"
    );
    assert!(
        refused.contains("`sysctl fs.mqueue.msg_max=1000000`"),
        "{refused}"
    );
}

/// A master and its slave in one thread.
const CHAIN: &str = r#"
schema = "composite/1"
[composite]
name = "chain"

[components.First]
implementation = { rust = "test::Echo" }
activity = { period_ms = 10, scheduler = "fifo", priority = 80, cpu = [0] }
lifecycle = { on_exception = "reset", max_resets = 2 }
subscribe = { number = "test/Number" }
ports.out = { number = "test/Number" }

[components.Second]
implementation = { rust = "test::Echo" }
activity = { master = "First" }
ports.in = { number = "test/Number" }
publish = { number = "test/Number" }
rename = { number = "echo" }

[[connections]]
from = "First.number"
to = "Second.number"
policy = { type = "buffer", size = 2, lock = "unsync", buffer = "per_input_port", max_threads = 1 }

[[promote]]
topic = "number"
as = "number"

[[promote]]
topic = "echo"
as = "echo"
"#;

#[test]
fn o3_o7_a_slave_cycles_after_its_master_over_a_connection_without_a_lock() {
    let files = files(CHAIN);
    let opened = open(&files, &[]);
    let mut system = start(&files, opened.plan(None).expect("a plan")).expect("a system");
    let log = Log::new();
    system.observe(log.clone());
    let mut run = system.simulate();
    run.run_for(5.ms());
    for n in 1..=3 {
        let now = run.now();
        run.publish(now, "number", Number { n }).expect("a topic");
    }
    run.run_for(20.ms());
    assert_eq!(
        log.lines_with("Second.number #"),
        [
            "0.01 s Second.number #1 on echo = {n: 1}",
            "0.01 s Second.number #2 on echo = {n: 2}"
        ],
        "at the same instant; the third has no room"
    );
    assert_eq!(
        log.lines_with("First.number -> Second.number: 1 dropped")
            .len(),
        1
    );
}

/// A loader that counts how often each file is read.
struct Counting<'f> {
    files: &'f MemoryFiles,
    reads: RefCell<BTreeMap<String, usize>>,
}

impl Loader for Counting<'_> {
    fn read(&self, path: &str) -> Result<Arc<str>, LoadError> {
        *self.reads.borrow_mut().entry(path.to_owned()).or_default() += 1;
        self.files.read(path)
    }

    fn resolve(&self, from: &str, import: &str) -> Option<String> {
        self.files.resolve(from, import)
    }
}

#[test]
fn components_with_the_same_bindings_share_their_specification() {
    let brain = COMPOSITE.split("[components.Brain]").nth(1).unwrap();
    let brain = brain.split("[components.Nested]").next().unwrap();
    let others = (2..=20).map(|number| {
        let brain = brain.replace("[components.Brain.", &format!("[components.Brain{number}."));
        // the last one has bindings of its own
        let brain = if number == 20 {
            brain.replace("@twice", "@other").replace("twice", "other")
        } else {
            brain
        };
        let wire =
            format!("[[wires]]\nreference = \"Brain{number}.sums\"\nservice = \"Nested.sums\"\n");
        format!("[components.Brain{number}]{brain}{wire}")
    });
    let composite = COMPOSITE.to_owned() + &others.collect::<String>();
    let files = files(&composite);
    let opened = open(&files, &[]);
    let counting = Counting {
        files: &files,
        reads: RefCell::default(),
    };
    let mut workshop = Standard::new(&BUILD, &counting, CoordinatorOptions::seeded(1));
    let plan = opened.plan(None).expect("a plan");
    let mut system = asmotion_assembly::start(plan, &mut workshop).expect("a system");
    assert_eq!(counting.reads.borrow()["brain.asm"], 2);
    let log = Log::new();
    system.observe(log.clone());
    let mut run = system.simulate();
    run.run_for(1.s());
    let sent = |brain: &str| log.samples::<Number>(&format!("{brain}.answer")).len();
    let brains = (2..=20).map(|number| format!("Brain{number}"));
    // the state of each is its own
    for brain in brains.chain(["Brain".to_owned()]) {
        assert_eq!(sent(&brain), 1, "{brain}");
    }
}
