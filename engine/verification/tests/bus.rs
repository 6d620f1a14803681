//! Runs whose topics go by a bus: a message that comes back is the one that was sent.

use crate::support::{CATALOGUE, Files, NoVariables};
use asmotion_component::Time;
use asmotion_composite::{AsmFiles, Context, NoPrograms};
use asmotion_datum::Sample;
use asmotion_messages::{Bool, Event as NavigationEvent};
use asmotion_plan::Part;
use asmotion_runtime::{Event, Observer as _};
use asmotion_verification::conformance::{ComponentConformance, ProtocolObserver};

const COMPOSITE: &str = r#"schema = "composite/1"
[composite]
name = "echo"
[components.Caller]
implementation = { process = "caller" }
publish = { ping = "std_msgs/Bool" }
[components.Echo]
implementation = { process = "echo" }
protocol = "echo.asm"
subscribe = { ping = "std_msgs/Bool" }
publish = { event = "nav/Event" }
"#;

/// Each ping is answered in the cycle that receives it.
const PROTOCOL: &str = "asm protocol
import StandardLibrary
signature:
	enum domain Code = {PONG}
	monitored ping: Boolean
	//@Port event.code
	out event: Code
definitions:
	main rule r_Main = if ping then event := PONG endif
default init s0:
";

/// What is observed of the component `Echo` in one part of the composite when a sequence of events occurs.
fn observed(part: &Part, events: &[Event<'_>]) -> ComponentConformance {
    let files = Files::default()
        .with("echo.composite.toml", COMPOSITE.to_owned())
        .with("echo.asm", PROTOCOL.to_owned());
    let specifications = AsmFiles::new(&files);
    let context = Context {
        loader: &files,
        environment: &NoVariables,
        catalogue: &*CATALOGUE,
        specifications: &specifications,
        programs: &NoPrograms,
        settings: &[],
    };
    let opened = asmotion_plan::open("echo.composite.toml", &context);
    let plan = opened.plan(None).expect("a plan");
    let mut observer = ProtocolObserver::new(plan, part, &files, &|_| None).expect("a protocol");
    for (at, event) in (0..).zip(events) {
        observer.observe(Time::from_nanos(at), event);
    }
    observer.found()["Echo"].clone()
}

fn cycle(number: u64) -> Event<'static> {
    Event::Cycle {
        component: "Echo",
        number,
    }
}

fn published<'a>(
    component: &'a str,
    port: &'a str,
    sample: &'a dyn Sample,
    sequence: u64,
) -> Event<'a> {
    Event::Published {
        component,
        port,
        topic: Some(port),
        sequence,
        sample,
    }
}

#[test]
fn a_message_that_returns_by_the_bus_arrives_once() {
    let (ping, mut pong) = (Bool::default(), NavigationEvent::default());
    pong.code = "PONG".into();
    let sent = |number| published("Caller", "ping", &ping, number);
    let answered = |number| published("Echo", "event", &pong, number);
    // the cycle after the message was sent does not have it yet
    let by_bus = [
        sent(1),
        cycle(1),
        returned(&ping),
        cycle(2),
        answered(1),
        cycle(3),
    ];
    let found = observed(&Part::WholeOverBus, &by_bus);
    assert_eq!((found.deviation, found.cycles), (None, 3));
    // counted when it is sent as well, it would have no answer
    assert!(observed(&Part::Whole, &by_bus).deviation.is_some());
    let direct = [sent(1), cycle(1), answered(1), cycle(2)];
    let found = observed(&Part::Whole, &direct);
    assert_eq!((found.deviation, found.cycles), (None, 2));
    // and what no one answers is a deviation in both
    let unanswered = [sent(1), cycle(1), cycle(2)];
    assert!(observed(&Part::Whole, &unanswered).deviation.is_some());
    let unanswered = [returned(&ping), cycle(1), cycle(2)];
    let found = observed(&Part::WholeOverBus, &unanswered);
    assert!(found.deviation.is_some());
}

fn returned(ping: &Bool) -> Event<'_> {
    Event::Injected {
        target: "Echo.ping",
        source: Some("Caller"),
        sample: ping,
    }
}
