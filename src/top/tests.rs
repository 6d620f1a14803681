//! Tests of the rendered screen.

use std::sync::Arc;
use std::time::Duration;

use asmotion_bus::{Envelope, LinkState, Payload};
use asmotion_datum::{Datum, Numbers};
use asmotion_remote::{PRESENCE, Presence, PresentComponent};
use ratatui::Terminal;
use ratatui::backend::TestBackend;

use super::{Board, Key, View, draw};

fn at(seconds: f64) -> Duration {
    Duration::from_secs_f64(seconds)
}

fn envelope(topic: &str, kind: &str, message: Datum) -> Envelope {
    Envelope {
        topic: topic.into(),
        source: "Driver".into(),
        incarnation: 1,
        sequence: 1,
        stamp: 0,
        age: Duration::ZERO,
        clock: Arc::from(""),
        trace: None,
        type_name: kind.into(),
        payload: Payload::of(message),
    }
}

fn component(
    name: &str,
    state: &str,
    period_ms: u64,
    rate_hz: f64,
    overruns: u64,
) -> PresentComponent {
    PresentComponent {
        name: name.to_owned(),
        state: state.to_owned(),
        period_ms,
        cycles: 120,
        cycle_mean_ms: 0.25,
        cycle_max_ms: 60.0,
        rate_hz,
        overruns,
        ..PresentComponent::default()
    }
}

fn presence(process: &str, components: Vec<PresentComponent>) -> Envelope {
    let presence = Presence {
        composite: "youbot".to_owned(),
        process: process.to_owned(),
        components,
        ..Presence::default()
    };
    let topic = format!("youbot.presence.{process}");
    envelope(&topic, PRESENCE, Datum::of(&presence).unwrap())
}

fn joints(shift: f64) -> Datum {
    let five = |scale: f64| {
        let numbers = (0..5).map(|joint| (f64::from(joint) + shift) * scale);
        Datum::Numbers(Numbers::F64(numbers.collect()))
    };
    Datum::record([
        ("position", five(0.1)),
        ("velocity", five(0.01)),
        ("current", five(0.25)),
        ("error_flags", Datum::List(vec![Datum::Int(0); 5])),
    ])
}

/// A model after ten seconds: joints at 10 Hz, one goal; the last message of the station is three seconds old.
fn board() -> Board {
    let mut board = Board::default();
    board.set_link(LinkState::Up, at(0.0));
    let driver = component("Driver", "Running", 100, 10.0, 0);
    let locomotor = component("Locomotor", "Running", 50, 19.4, 7);
    let monitor = component("Monitor", "Exception", 0, 0.0, 0);
    board.receive(&presence("station", vec![locomotor, monitor]), at(7.0));
    board.receive(&presence("robot", vec![driver]), at(9.5));
    for tick in 0..100 {
        let now = at(f64::from(tick) / 10.0);
        let message = envelope(
            "youbot.jointStatus",
            "youbot/JointStatus",
            joints(f64::from(tick)),
        );
        board.receive(&message, now);
        if tick < 40 {
            let fast = Datum::record([("linear", Datum::Float(0.5))]);
            board.receive(&envelope("youbot.twist", "geometry_msgs/Twist", fast), now);
        }
    }
    let goal = Datum::record([("x", Datum::Float(1.25)), ("frame", Datum::text("map"))]);
    board.receive(
        &envelope("youbot.goal", "geometry_msgs/Pose", goal),
        at(2.0),
    );
    board
}

fn screen(board: &Board, view: &View, now: f64, (width, height): (u16, u16)) -> String {
    let mut terminal = Terminal::new(TestBackend::new(width, height)).unwrap();
    terminal
        .draw(|frame| draw(frame, board, view, "127.0.0.1:5672/%2f", at(now)))
        .unwrap();
    terminal.backend().to_string()
}

fn pressed(board: &Board, keys: &[Key], now: f64) -> View {
    let mut view = View::default();
    for key in keys {
        assert!(view.press(*key, board, at(now)));
    }
    view
}

#[test]
fn it_fits_a_small_terminal() {
    let board = board();
    let view = pressed(&board, &[Key::Down], 10.0);
    insta::assert_snapshot!(screen(&board, &view, 10.0, (80, 24)));
}

#[test]
fn lost_messages_have_a_column() {
    let mut board = Board::default();
    let bridge = PresentComponent {
        dropped: 12,
        misfits: 3,
        ..component("RosBridge", "Running", 0, 40.0, 0)
    };
    let driver = component("Driver", "Running", 100, 10.0, 0);
    board.receive(&presence("robot", vec![bridge, driver]), at(9.5));
    let shown = screen(&board, &View::default(), 10.0, (100, 24));
    let rows: Vec<&str> = shown.lines().collect();
    let row = |name: &str| rows.iter().find(|it| it.contains(name)).unwrap();
    assert!(row("component ").contains("lost"), "{shown}");
    assert!(row("RosBridge").contains("12+3 bad"), "{shown}");
    assert!(
        row("Driver")
            .trim_end_matches(['│', '"', ' '])
            .ends_with('0'),
        "{shown}"
    );
}

#[test]
fn it_fills_a_large_terminal() {
    let board = board();
    let view = pressed(&board, &[Key::Down], 10.0);
    insta::assert_snapshot!(screen(&board, &view, 10.0, (200, 60)));
}

#[test]
fn y11_what_is_not_heard_any_more_is_stale_with_its_age() {
    let mut board = board();
    let reason = "connection reset".into();
    board.set_link(LinkState::Down { reason }, at(11.0));
    let view = pressed(&board, &[Key::Down], 14.0);
    insta::assert_snapshot!(screen(&board, &view, 14.0, (100, 24)));
}

#[test]
fn time_stops_and_says_so() {
    let mut board = board();
    let view = pressed(&board, &[Key::Char('p')], 10.0);
    board.receive(&envelope("new", "", Datum::Int(1)), at(12.0));
    let shown = screen(&board, &view, 13.0, (80, 24));
    assert!(shown.contains("PAUSED for 3.0 s"), "{shown}");
    assert!(!shown.contains("new"), "{shown}");
    let view = pressed(&board, &[Key::Char('p'), Key::Char('p')], 13.0);
    assert!(screen(&board, &view, 13.0, (80, 24)).contains("new"));
}

#[test]
fn rows_are_sorted_and_filtered() {
    let board = board();
    let names = |view: &View| -> Vec<String> {
        let topics = view.topics(&board, at(10.0)).into_iter();
        topics.map(|topic| topic.name.clone()).collect()
    };
    let (goal, joints, twist) = ("youbot.goal", "youbot.jointStatus", "youbot.twist");
    assert_eq!(names(&View::default()), [goal, joints, twist]);
    let trouble = pressed(&board, &[Key::Char('s'), Key::Char('s')], 10.0);
    assert_eq!(names(&trouble)[0], twist, "it is silent");
    let wanted = "/TWI".chars().map(Key::Char).collect::<Vec<_>>();
    let mut filtered = pressed(&board, &wanted, 10.0);
    assert_eq!(names(&filtered), [twist]);
    assert!(filtered.press(Key::Enter, &board, at(10.0)));
    assert!(
        filtered.press(Key::Escape, &board, at(10.0)),
        "clears the filter"
    );
    assert_eq!(names(&filtered).len(), 3);
    assert!(!filtered.press(Key::Escape, &board, at(10.0)), "ends");
}

#[test]
fn a_screen_without_room_or_data_is_drawn() {
    for size in [(1, 1), (20, 5), (80, 24)] {
        screen(&Board::default(), &View::default(), 0.0, size);
        screen(&board(), &View::default(), 10.0, size);
    }
}

/// A coordinator that follows a path.
fn coordinator() -> PresentComponent {
    let state = |mode: &str| Datum::record([("mode", Datum::text(mode))]);
    let status = Datum::record([
        ("step", Datum::Int(812)),
        ("state", state("FOLLOWING")),
        (
            "last_update",
            Datum::record([
                ("step", Datum::Int(80)),
                ("at_s", Datum::Float(4.2)),
                ("updates", state("FOLLOWING")),
            ]),
        ),
        ("read", Datum::record([("estop", Datum::text("false"))])),
        ("calls", Datum::List(vec![Datum::text("planner.plan")])),
        ("silent", Datum::List(vec![Datum::text("cancel")])),
        ("waiting_events", Datum::record([("event", Datum::Int(2))])),
    ]);
    let Datum::Record(entries) = status else {
        panic!("a record");
    };
    let entries = entries.into_iter();
    PresentComponent {
        inspection: entries
            .map(|(name, value)| (name.into_owned(), value))
            .collect(),
        ..component("Coordinator", "Running", 50, 20.0, 0)
    }
}

#[test]
fn the_state_of_a_coordinator_is_shown() {
    let mut board = Board::default();
    board.receive(&presence("robot", vec![coordinator()]), at(9.5));
    let view = pressed(&board, &[Key::Tab], 10.0);
    insta::assert_snapshot!(screen(&board, &view, 10.0, (100, 24)));
}

#[test]
fn rates_are_those_of_the_senders_clock() {
    let mut board = Board::default();
    for tick in 0..40_i32 {
        // a simulation at a hundred times real time
        let sent = Envelope {
            stamp: i64::from(tick) * 20_000_000,
            ..envelope("rover.odom", "nav_msgs/Odometry", Datum::Null)
        };
        board.receive(&sent, at(f64::from(tick) * 0.0002));
    }
    let rates: Vec<_> = board.topics().map(super::BoardTopic::rate).collect();
    assert_eq!(rates, [Some(50.0)]);
}

#[test]
fn rows_that_do_not_fit_are_counted() {
    let mut board = Board::default();
    let many = (0..9).map(|number| component(&format!("C{number}"), "Running", 10, 100.0, 0));
    board.receive(&presence("robot", many.collect()), at(9.5));
    let view = pressed(&board, &[Key::Char('f')], 10.0);
    let shown = screen(&board, &view, 10.0, (80, 24));
    assert!(shown.contains("↓ 5 more"), "{shown}");
    let mut down = pressed(&board, &[Key::Char('f'), Key::Tab], 10.0);
    for _ in 0..8 {
        assert!(down.press(Key::Down, &board, at(10.0)));
    }
    let shown = screen(&board, &down, 10.0, (80, 24));
    assert!(
        shown.contains("↑ 5 more") && shown.contains("C8"),
        "{shown}"
    );
    let tall = screen(&board, &view, 10.0, (80, 60));
    assert!(!tall.contains("more"), "{tall}");
}

#[test]
fn the_result_remains_after_the_end_of_a_run() {
    let mut board = board();
    let leaving = Presence {
        process: "robot".to_owned(),
        leaves: true,
        ..Presence::default()
    };
    let leaving = Datum::of(&leaving).unwrap();
    board.receive(
        &envelope("youbot.presence.robot", PRESENCE, leaving),
        at(10.0),
    );
    let mut view = View::default();
    view.result = Some(("reached in ARRIVED after 41.3 s".to_owned(), at(10.0)));
    let shown = screen(&board, &view, 60.0, (100, 24));
    assert!(
        shown.contains("ended: reached in ARRIVED after 41.3 s"),
        "{shown}"
    );
    assert!(
        !shown.contains("left") && !shown.contains("stale 5"),
        "{shown}"
    );
}

#[test]
fn the_last_message_of_a_process_shows_how_its_components_have_ended() {
    let mut board = board();
    let leaving = Presence {
        process: "robot".to_owned(),
        leaves: true,
        components: vec![component("Driver", "Exception", 100, 10.0, 3)],
        ..Presence::default()
    };
    let leaving = Datum::of(&leaving).unwrap();
    board.receive(
        &envelope("youbot.presence.robot", PRESENCE, leaving),
        at(10.0),
    );
    let mut view = View::default();
    view.result = Some(("failed".to_owned(), at(10.0)));
    let shown = screen(&board, &view, 60.0, (100, 24));
    let driver = shown.lines().find(|line| line.contains("Driver"));
    assert!(driver.is_some_and(|it| it.contains("Exception")), "{shown}");
}

#[test]
fn a_message_that_waited_for_a_stopped_terminal_is_shown_as_old() {
    let mut board = board();
    let mut late = envelope("youbot.twist", "geometry_msgs/Twist", Datum::Int(1));
    late.age = Duration::from_secs(5);
    board.receive(&late, at(10.0));
    let leaves = board.topics().find(|it| it.name == "youbot.twist").unwrap();
    assert_eq!(leaves.age(at(10.0)), Duration::from_secs(5));
    assert!(leaves.is_stale(at(10.0)));
    // a process that sent its presence before the standstill, and nothing since
    let mut old = presence("robot", vec![component("Driver", "Running", 100, 10.0, 0)]);
    old.age = Duration::from_secs(4);
    board.receive(&old, at(10.0));
    let shown = screen(&board, &View::default(), 10.0, (100, 24));
    assert!(shown.contains("stale 4"), "{shown}");
}

#[test]
fn instances_are_one_row_unless_they_are_unfolded_or_in_another_state() {
    let mut all: Vec<_> = (1..=20)
        .map(|it| component(&format!("Rover{it}/World"), "Running", 20, 50.0, it))
        .collect();
    all[6].state = "Exception".to_owned();
    all.extend((1..=3).map(|it| component(&format!("Arm{it}"), "Running", 20, 50.0, 0)));
    let mut board = Board::default();
    board.receive(&presence("all", all), at(1.0));
    let names = |view: &View| -> Vec<_> {
        let rows = view.components(&board, at(1.0)).into_iter();
        rows.map(|it| it.present.name.clone()).collect()
    };
    let mut view = View::default();
    let folded = [
        "Rover1…20/World ×19",
        "Rover7/World",
        "Arm1",
        "Arm2",
        "Arm3",
    ];
    assert_eq!(names(&view), folded);
    let rows = view.components(&board, at(1.0));
    let first = &rows[0].present;
    // all but the seventh
    assert_eq!((first.overruns, first.rate_hz), (210 - 7, 50.0));
    let drawn = screen(&board, &view, 1.0, (110, 30));
    assert!(drawn.contains("f unfold"), "{drawn}");
    assert!(view.press(Key::Char('f'), &board, at(1.0)));
    assert_eq!(names(&view).len(), 23);
    assert!(screen(&board, &view, 1.0, (110, 30)).contains("f fold"));
}
