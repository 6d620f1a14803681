//! The locomotor: the specification, running in the composite in `specs`.

use super::bench::{Log, shipped};
use asmotion_component::{Time, Transition};
use asmotion_runtime::Run;
use std::time::Duration;

/// Reachable goals around the arm: x, y, z in m, lean and roll in rad.
fn around(count: u32) -> Vec<[f64; 5]> {
    let goal = |k: u32| {
        let (turn, far) = (-2.4 + 0.24 * f64::from(k), 0.33 + 0.02 * f64::from(k % 3));
        let up = 0.28 + 0.02 * f64::from(k % 4);
        [far * turn.cos(), far * turn.sin(), up, 1.57, 0.1]
    };
    (0..count).map(goal).collect()
}

/// Position of the hand, computed with the lengths in the data sheet.
fn hand(joints: &[f64]) -> [f64; 3] {
    let leans = [
        joints[1],
        joints[1] + joints[2],
        joints[1] + joints[2] + joints[3],
    ];
    let lengths = [0.155, 0.135, 0.2175];
    let links = || leans.iter().zip(lengths);
    let far = 0.033
        + links()
            .map(|(lean, length)| length * lean.sin())
            .sum::<f64>();
    let up = 0.147
        + links()
            .map(|(lean, length)| length * lean.cos())
            .sum::<f64>();
    [far * joints[0].cos(), far * joints[0].sin(), up]
}

/// Positions of the hand when the locomotor reported that the arm was idle.
fn arrivals(log: &Log) -> Vec<[f64; 3]> {
    let idle = log.notes.iter().filter(|(_, note)| note == "NOTE_IDLE");
    let at = |at: &Time| {
        let (_, status) = log.statuses.iter().rfind(|(then, _)| then <= at).unwrap();
        hand(&status.position)
    };
    idle.map(|(then, _)| at(then)).collect()
}

#[test]
fn y1_twenty_goals_are_reached() {
    let goals = around(20);
    let (mut simulation, log) = shipped(&goals);
    simulation.run_for(Duration::from_secs(120));
    let log = log.lock().unwrap();
    let arrivals = arrivals(&log);
    assert_eq!(arrivals.len(), 20, "{:?}", log.replies);
    for (goal, hand) in goals.iter().zip(&arrivals) {
        let distance = (0..3)
            .map(|axis| (goal[axis] - hand[axis]).powi(2))
            .sum::<f64>()
            .sqrt();
        assert!(distance < 0.01, "{hand:?} is {distance} m from {goal:?}");
    }
}

#[test]
fn y1_an_unreachable_goal_is_refused_with_its_reason_and_the_next_one_is_reached() {
    let (mut simulation, log) = shipped(&[[1.5, 0.0, 0.3, 1.57, 0.0], around(1)[0]]);
    simulation.run_for(Duration::from_secs(10));
    let log = log.lock().unwrap();
    let moves = log
        .replies
        .iter()
        .filter(|(operation, ..)| operation == "moveTo");
    let results: Vec<_> = moves.map(|(_, _, result)| result.clone()).collect();
    let refused = results[0].as_ref().unwrap_err();
    let reason = "TOO_FAR: the wrist would be";
    assert!(refused.starts_with(reason), "{refused}");
    assert!(results[1].is_ok());
    assert_eq!(arrivals(&log).len(), 1);
}

#[test]
fn y10_both_listeners_hear_of_the_arrival() {
    let (mut simulation, log) = shipped(&around(2));
    simulation.run_for(Duration::from_secs(15));
    let log = log.lock().unwrap();
    // the locomotor reports it, and the operator has sent the next goal
    let said: Vec<&str> = log.notes.iter().map(|(_, note)| note.as_str()).collect();
    let motions: Vec<_> = said
        .iter()
        .filter(|note| ["NOTE_BUSY", "NOTE_IDLE"].contains(note))
        .collect();
    assert_eq!(
        motions,
        [&"NOTE_BUSY", &"NOTE_IDLE", &"NOTE_BUSY", &"NOTE_IDLE"]
    );
}

#[test]
fn y11_silence_during_a_motion_is_a_fault_of_the_locomotor() {
    let (mut simulation, log) = shipped(&around(1));
    simulation.run_for(Duration::from_millis(500));
    simulation
        .transition("Driver/SCAyouBotDriver", Transition::Stop)
        .unwrap();
    simulation.run_for(Duration::from_secs(3));
    let log = log.lock().unwrap();
    let mut notes = log.notes.iter();
    let (at, _) = notes.find(|(_, note)| note == "NOTE_FAULT").unwrap();
    let silent = at.since(Time::ZERO + Duration::from_millis(500));
    assert!((950..1200).contains(&silent.as_millis()), "{silent:?}");
}

#[test]
fn y12_the_composites_have_few_lines() {
    let files = [
        include_str!("../../specs/youbot/youbot.composite.toml"),
        include_str!("../../specs/youbot/youbot_driver.composite.toml"),
    ];
    for file in files {
        let lines = file.lines().map(str::trim);
        let count = lines
            .filter(|line| !line.is_empty() && !line.starts_with('#'))
            .count();
        assert!(count <= 60, "{count}");
    }
}
