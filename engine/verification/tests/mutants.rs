//! Components in Rust that do what the protocols of the follower and the planner do not allow.

use crate::scenarios::{Conformance, Dice, Scenario, observed};
use crate::support::Files;
use asmotion_component::{
    Component, Cycle, Fault, Flow, In, Interface, Out, Ports, Provided, RequestId, ServiceFault,
};
use asmotion_components::MakeComponent;
use asmotion_messages::{Bool, Event, Obstacles, Path, Plan, Time};
use asmotion_verification::conformance::{EventSuccession, PrecedingEvent, SentEvent};

/// The components of these tests, by their names in composites.
pub const COMPONENTS: &[(&str, MakeComponent)] = &[
    ("test::Follower", |it| follower(it, Flaw::None)),
    ("test::RepeatingFollower", |it| {
        follower(it, Flaw::ReportsTwice)
    }),
    ("test::UnaskedFollower", |it| {
        follower(it, Flaw::ReportsUnasked)
    }),
    ("test::RashFollower", |it| follower(it, Flaw::IgnoresPermit)),
    ("test::ForgetfulFollower", |it| {
        follower(it, Flaw::WrongStamp)
    }),
    ("test::SilentFollower", |it| {
        follower(it, Flaw::NeverArrives)
    }),
    ("test::OrderlyFollower", |it| follower(it, Flaw::NeverStops)),
    ("test::Planner", |it| planner(it, 1, false, "NO_PATH")),
    ("test::RepeatingPlanner", |it| {
        planner(it, 2, false, "NO_PATH")
    }),
    ("test::LatePlanner", |it| planner(it, 2, true, "NO_PATH")),
    ("test::StrangePlanner", |it| planner(it, 1, false, "BUSY")),
];

/// The way in which a follower deviates.
#[derive(Clone, Copy, PartialEq)]
enum Flaw {
    None,
    ReportsTwice,
    ReportsUnasked,
    IgnoresPermit,
    WrongStamp,
    NeverArrives,
    /// Allowed: it does not obey orders to stop after an arrival.
    NeverStops,
}

#[derive(Clone, Copy, PartialEq)]
enum Order {
    None,
    Stop,
    Follow,
    Done,
}

#[derive(Ports)]
struct FollowerPorts {
    /// Orders.
    path: In<Path>,
    /// Permission to drive.
    permit: In<Bool>,
    /// What became of the order.
    event: Out<Event>,
}

/// A follower that arrives at once.
struct TestFollower {
    ports: FollowerPorts,
    flaw: Flaw,
    order: Order,
    stamp: Time,
    repeats: bool,
    cycles: u64,
}

fn follower(interface: &mut Interface, flaw: Flaw) -> Box<dyn Component> {
    Box::new(TestFollower {
        ports: interface.ports(),
        flaw,
        order: Order::None,
        stamp: Time::default(),
        repeats: false,
        cycles: 0,
    })
}

impl Component for TestFollower {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        self.cycles += 1;
        if let Flow::NewData(path) = cycle.read(self.ports.path) {
            self.stamp = path.header.stamp;
            self.order = if path.poses.is_empty() {
                Order::Stop
            } else {
                Order::Follow
            };
        }
        let permit = cycle.read(self.ports.permit).any();
        let is_permitted = permit.is_none_or(|it| it.data) || self.flaw == Flaw::IgnoresPermit;
        let mut code = match self.order {
            Order::Stop if self.flaw == Flaw::NeverStops => None,
            Order::Stop => Some("HALTED"),
            Order::Follow if is_permitted && self.flaw != Flaw::NeverArrives => Some("REACHED"),
            Order::Follow | Order::None | Order::Done => None,
        };
        if code.is_some() {
            self.repeats = self.flaw == Flaw::ReportsTwice && code == Some("REACHED");
            self.order = if code == Some("HALTED") {
                Order::None
            } else {
                Order::Done
            };
        } else if std::mem::take(&mut self.repeats) {
            code = Some("REACHED");
        } else if self.flaw == Flaw::ReportsUnasked && self.cycles == 500 {
            code = Some("HALTED");
        }
        if let Some(code) = code {
            let mut plan = self.stamp;
            if self.flaw == Flaw::WrongStamp {
                plan.sec += 1;
            }
            let event = Event {
                plan,
                code: code.to_owned(),
                ..Event::default()
            };
            cycle.write(self.ports.event, event);
        }
        Ok(())
    }
}

#[derive(Ports)]
struct PlannerPorts {
    /// Requests.
    planning: Provided<Plan>,
    /// Ignored.
    obstacles: In<Obstacles>,
}

/// A planner that finds no path.
struct TestPlanner {
    ports: PlannerPorts,
    /// Number of answers to each request.
    answers: usize,
    /// `true` if all but the first come in the next cycle.
    is_late: bool,
    code: &'static str,
    late: Vec<RequestId>,
}

fn planner(
    interface: &mut Interface,
    answers: usize,
    is_late: bool,
    code: &'static str,
) -> Box<dyn Component> {
    Box::new(TestPlanner {
        ports: interface.ports(),
        answers,
        is_late,
        code,
        late: Vec::new(),
    })
}

impl Component for TestPlanner {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        let _ = cycle.read(self.ports.obstacles);
        let code = self.code;
        let refusal = || ServiceFault::new(code, "there is none");
        for id in std::mem::take(&mut self.late) {
            cycle.reply(self.ports.planning, id, Err(refusal()));
        }
        for request in cycle.requests(self.ports.planning) {
            let now = if self.is_late { 1 } else { self.answers };
            for _ in 0..now {
                cycle.reply(self.ports.planning, request.id, Err(refusal()));
            }
            self.late.extend((now..self.answers).map(|_| request.id));
        }
        Ok(())
    }
}

fn followed(implementation: &str) -> Conformance {
    followed_with(implementation, &Files::default())
}

/// Runs a follower alone, with random orders and permissions.
fn followed_with(implementation: &str, files: &Files) -> Conformance {
    let composite = format!(
        "schema = \"composite/1\"\n[composite]\nname = \"alone\"\n[components.Tested]\nimplementation = {{ rust = {implementation:?} }}\n\
         protocol = \"components/follower/protocol.asm\"\nactivity = {{ period_ms = 50 }}\n\
         subscribe = {{ path = \"nav_msgs/Path\", permit = \"std_msgs/Bool\" }}\npublish = {{ event = \"nav/Event\" }}\n\
         [[promote]]\ntopic = \"path\"\nas = \"path\"\n[[promote]]\ntopic = \"permit\"\nas = \"permit\"\n\
         [[promote]]\ntopic = \"event\"\nas = \"event\"\n"
    );
    let mut dice = Dice(7);
    let mut messages = Vec::new();
    for at in (1000..60_000).step_by(20) {
        if dice.below(60) == 0 {
            let poses = ["", "{}", "{}, {}"][dice.below(3) as usize];
            let stamp = format!(
                "{{\"stamp\": {{\"sec\": {}}}, \"frame_id\": \"map\"}}",
                at / 1000
            );
            let path = format!("{{\"header\": {stamp}, \"poses\": [{poses}]}}");
            messages.push((at, "path".to_owned(), path));
        }
        if dice.below(60) == 0 {
            let permit = format!("{{\"data\": {}}}", dice.below(3) > 0);
            messages.push((at, "permit".to_owned(), permit));
        }
    }
    let scenario = Scenario {
        composite: "alone.composite.toml",
        messages,
        seconds: 60,
        ..Scenario::default()
    };
    let files = files.clone().with("alone.composite.toml", composite);
    observed(&[scenario], &files)
}

#[test]
fn a_follower_that_reports_what_it_must_not_report_is_found() {
    let found = &followed("test::Follower")["test::Follower"];
    assert_eq!(found.deviation, None);
    assert_eq!(found.never_sent().len(), 0, "{found:?}");
    for name in [
        "test::RepeatingFollower",
        "test::UnaskedFollower",
        "test::RashFollower",
        "test::ForgetfulFollower",
    ] {
        let found = &followed(name)[name];
        assert!(found.deviation.is_some(), "{name}: {found:?}");
    }
}

#[test]
fn a_protocol_that_only_allows_more_shows_in_what_never_occurs() {
    let event = |value: &str| SentEvent {
        function: "event".to_owned(),
        value: value.to_owned(),
    };
    let halted = event("HALTED");
    let silent = &followed("test::SilentFollower")["test::SilentFollower"];
    assert_eq!(silent.deviation, None);
    assert_eq!(silent.never_sent(), [event("REACHED")].into());
    // both events occur, but the one never after the other
    let files = "test::OrderlyFollower";
    let orderly = &followed(files)[files];
    assert_eq!(orderly.deviation, None);
    assert!(orderly.never_sent().contains(&halted), "{orderly:?}");
}

#[test]
fn a_succession_that_only_the_protocol_has_is_listed() {
    let never = |files: &Files| -> Vec<EventSuccession> {
        let found = &followed_with("test::Follower", files)["test::Follower"];
        assert_eq!(found.deviation, None);
        let never = found.never_followed().into_iter();
        // a run has one first event
        never.filter(|it| it.before.is_some()).collect()
    };
    let sent = |value: &str| SentEvent {
        function: "event".to_owned(),
        value: value.to_owned(),
    };
    // the follower does everything that its protocol allows, in each order
    assert_eq!(never(&Files::default()), []);
    // the same protocol, but the arrival can be reported again and again
    let path = "components/follower/protocol.asm";
    let looser = Files::default().change(path, "order := DONE\n", "order := FOLLOW\n");
    let repeated = EventSuccession {
        before: Some(PrecedingEvent::Sent(sent("REACHED"))),
        after: sent("REACHED"),
    };
    assert_eq!(never(&looser), [repeated]);
}

#[test]
fn a_planner_that_answers_what_it_must_not_answer_is_found() {
    let navigation = "specs/navigation/navigation.composite.toml";
    for (name, is_wrong) in [
        ("test::Planner", false),
        ("test::StrangePlanner", true),
        // the runtime takes the first answer to a request only, so that no other component notices a second one
        ("test::RepeatingPlanner", false),
        ("test::LatePlanner", false),
    ] {
        let files = Files::default().change(
            navigation,
            "implementation = { rust = \"nav::TrajectoryPlanner\" }",
            &format!(
                "implementation = {{ rust = {name:?} }}\nprotocol = \"../../components/planner/protocol.asm\""
            ),
        );
        let scenario = Scenario {
            seconds: 20,
            ..crate::conformance::drive(0)
        };
        let found = observed(&[scenario], &files);
        let planner = &found[name];
        assert_eq!(planner.sent.is_empty(), is_wrong, "{name}: {planner:?}");
        assert_eq!(planner.deviation.is_some(), is_wrong, "{name}: {planner:?}");
    }
}
