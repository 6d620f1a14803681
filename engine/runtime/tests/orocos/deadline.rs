//! Deadlines of cycles and the actions when they are exceeded.

use std::time::Duration;

use asmotion_component::{Activity, Component, Interface, OnDeadline, Span, State, Time};
use asmotion_runtime::{Event, Log, Run, System};

use crate::common::{Number, behaviour, number};

/// Writes a count in each cycle. The third cycle sleeps, and reports its duration to simulated time.
fn dawdler(long: Duration) -> impl FnOnce(&mut Interface) -> Box<dyn Component> {
    behaviour(move |interface| {
        let out = interface.output::<Number>("n", "the count");
        let mut n = 0;
        move |cycle| {
            n += 1;
            cycle.write(out, number(n));
            if n == 3 {
                cycle.set_duration(long);
                std::thread::sleep(long);
            }
            Ok(())
        }
    })
}

/// A system with one `dawdler`, whose period is 20 ms and deadline 10 ms.
fn system(on_deadline: OnDeadline) -> System {
    let mut system = System::new();
    let activity = Activity::periodic(20.ms()).deadline(10.ms(), on_deadline);
    system.add("It", activity, dawdler(15.ms())).unwrap();
    system
}

/// The log of 100 ms in simulated time.
fn lines(on_deadline: OnDeadline) -> Vec<String> {
    let log = Log::new();
    let mut system = system(on_deadline);
    system.observe(log.clone());
    system.simulate().run_for(100.ms());
    let mut lines = log.lines_with("It");
    let late = lines.iter().position(|line| line.contains("15ms"));
    lines.split_off(late.unwrap() - 1)
}

#[test]
fn a_late_cycle_is_told_and_the_next_ones_go_on() {
    assert_eq!(
        lines(OnDeadline::Report)[..4],
        [
            "0.04 s It.n #3 = {n: 3}",
            "0.04 s It: a cycle took 15ms, and has 10ms",
            "0.06 s It: cycle 4",
            "0.06 s It.n #4 = {n: 4}"
        ]
    );
}

#[test]
fn a_late_cycle_stops_its_component_when_what_it_did_has_happened() {
    assert_eq!(
        lines(OnDeadline::Stop),
        [
            "0.04 s It.n #3 = {n: 3}",
            "0.04 s It: a cycle took 15ms, and has 10ms",
            "0.04 s It: Running -> Stopped"
        ]
    );
}

#[test]
fn a_late_cycle_is_a_fault_where_the_activity_says_so() {
    assert_eq!(
        lines(OnDeadline::Fail),
        [
            "0.04 s It.n #3 = {n: 3}",
            "0.04 s It: a cycle took 15ms, and has 10ms",
            "0.04 s It: fault: a cycle took 15ms, and has 10ms",
            "0.04 s It: Running -> Exception"
        ]
    );
}

#[test]
fn who_is_brought_back_after_a_failure_is_so_after_a_late_cycle() {
    use asmotion_component::OnException::Reset;
    let mut system = System::new();
    let activity = Activity::periodic(20.ms()).deadline(10.ms(), OnDeadline::Fail);
    let activity = activity.on_exception(Reset);
    system.add("It", activity, dawdler(15.ms())).unwrap();
    let mut run = system.simulate();
    run.run_for(100.ms());
    // the fourth cycle is a period later
    assert_eq!((run.late("It"), run.cycles("It")), (1, 6));
}

#[test]
fn live_the_clock_says_whether_a_cycle_is_late() {
    for (on_deadline, becomes) in [
        (OnDeadline::Report, State::Running),
        (OnDeadline::Stop, State::Stopped),
        (OnDeadline::Fail, State::Exception),
    ] {
        let mut run = system(on_deadline).live();
        let late = |_: Time, event: &Event<'_>| {
            matches!(
                event,
                Event::Late { took, deadline, .. } if *took >= 15.ms() && *deadline == 10.ms()
            )
        };
        assert!(run.run_until_event(Time::ZERO + 10.s(), &mut { late }));
        let until = run.now() + 10.s();
        if becomes != State::Running {
            run.run_until_event(
                until,
                &mut |_, event| matches!(event, Event::LifeCycle { to, .. } if *to == becomes),
            );
        }
        assert_eq!(run.state("It"), Some(becomes));
        assert!(run.late("It") >= 1);
    }
}
