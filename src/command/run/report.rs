//! Prints the events and the summary of a run, as text or as JSON.

use std::collections::BTreeMap;

use asmotion_component::{LOG_REPORT, Losses, NOTICE_REPORT, Time};
use asmotion_coordinator::{
    BAD_REPLY_REPORT, BadReply, LOSSES_REPORT, STEP_REPORT, StepRecord, VIOLATION_REPORT,
    ViolationRecord,
};
use asmotion_runtime::Event;
use serde_json::json;

use crate::mission::{MissionEnd, MissionOutcome, RecordingResult, StalledCoordinator};
use crate::terminal::{BAD, FAINT, GOOD, NOTE, TerminalOutput};
use asmotion_story::{EventCounts, RobotSummary, Summary};

pub(super) fn event_json(at: Time, event: &Event<'_>) -> Option<serde_json::Value> {
    let t = at.seconds();
    match event {
        Event::Report {
            component,
            kind,
            data: what,
        } if *kind == STEP_REPORT => {
            let step: StepRecord = what.to().ok()?;
            Some(json!({ "type": "step", "v": 1, "t": t, "component": component, "step": step }))
        }
        Event::Report {
            component,
            kind,
            data,
        } if *kind == VIOLATION_REPORT => {
            let violation: ViolationRecord = data.to().ok()?;
            Some(json!({
                "type": "violation", "v": 1, "t": t, "component": component, "violation": violation,
            }))
        }
        Event::Report {
            component,
            kind,
            data,
        } if *kind == BAD_REPLY_REPORT => {
            let reply: BadReply = data.to().ok()?;
            Some(json!({
                "type": "bad_reply", "v": 1, "t": t, "component": component, "reference": reply.reference,
                "operation": reply.operation, "call": reply.call, "error": reply.error(),
            }))
        }
        Event::Report {
            component,
            kind,
            data,
        } if *kind == NOTICE_REPORT || *kind == LOG_REPORT => Some(json!({
            "type": *kind, "v": 1, "t": t, "component": component, "text": data.as_text(),
        })),
        Event::Report {
            component,
            kind,
            data,
        } if *kind == LOSSES_REPORT => {
            let Losses { dropped, misfits } = data.to().ok()?;
            Some(json!({
                "type": "losses", "v": 1, "t": t, "component": component,
                "dropped": dropped, "misfits": misfits,
            }))
        }
        Event::Denied { component, denied } => Some(json!({
            "type": "denied", "v": 1, "t": t, "component": component, "denied": denied.to_string(),
        })),
        Event::Called {
            component,
            reference,
            operation,
            call,
            attempt,
            ..
        } => Some(json!({
            "type": "call", "v": 1, "t": t, "component": component, "reference": reference,
            "operation": operation, "call": call, "attempt": attempt,
        })),
        Event::Replied {
            component,
            reference,
            operation,
            call,
            result,
        } => Some(json!({
            "type": "reply", "v": 1, "t": t, "component": component, "reference": reference,
            "operation": operation, "call": call, "error": result.err(),
        })),
        Event::Fault { component, fault } => Some(
            json!({ "type": "fault", "v": 1, "t": t, "component": component, "fault": fault.to_string() }),
        ),
        Event::Dropped {
            component,
            port,
            to,
            total,
            reason,
        } => Some(json!({
            "type": "dropped", "v": 1, "t": t, "component": component, "port": port, "to": to,
            "total": total, "reason": reason.map(ToString::to_string),
        })),
        Event::Lost { count } => Some(json!({ "type": "lost", "v": 1, "t": t, "count": count })),
        Event::Overrun { component, missed } => Some(json!({
            "type": "overrun", "v": 1, "t": t, "component": component, "missed": missed,
        })),
        Event::Late {
            component,
            took,
            deadline,
        } => Some(json!({
            "type": "late", "v": 1, "t": t, "component": component,
            "took_s": took.as_secs_f64(), "deadline_s": deadline.as_secs_f64(),
        })),
        Event::Cycle { .. }
        | Event::Published { .. }
        | Event::Injected { .. }
        | Event::Answered { .. }
        | Event::LifeCycle { .. }
        | Event::Property { .. }
        | Event::Report { .. } => None,
    }
}

pub(super) fn summary_json(end: &MissionEnd) -> serde_json::Value {
    let summary = &end.summary;
    let robot = summary.robots.only();
    let robot = robot.as_ref();
    json!({
        "type": "summary", "v": 1, "outcome": end.outcome.name(),
        "time_s": end.time.as_secs_f64(), "wall_s": end.wall.as_secs_f64(),
        "steps": summary.steps, "transitions": summary.transitions,
        "driven_m": robot.map(|it| it.path.driven_m), "to_goal_m": robot.and_then(RobotSummary::to_goal_m),
        "true_to_goal_m": robot.and_then(RobotSummary::true_to_goal_m),
        "failed_calls": summary.failed_calls, "control_state": summary.control_state(),
        "control_states": control_states_json(summary),
        "heard": counts_json(&summary.received), "calls": counts_json(&summary.calls), "faults": summary.faults,
        "failed_components": end.failed,
        "lost": end.lost.iter().map(|(input, count)| json!({ "input": input, "count": count })).collect::<Vec<_>>(),
        "refused": end.refused.iter().map(|(service, count)| json!({ "service": service, "count": count })).collect::<Vec<_>>(),
        "unsuitable": end.unsuitable.iter().map(|(component, count)| json!({ "component": component, "count": count })).collect::<Vec<_>>(),
        "stalled": end.stalled.iter().map(stalled_json).collect::<Vec<_>>(),
        "collisions": summary.collisions,
        "robots": summary.robots.all().map(|robot| robot_json(&robot)).collect::<Vec<_>>(),
        "recording": end.recording.as_ref().map(recording_json),
    })
}

fn control_states_json(summary: &Summary) -> Vec<serde_json::Value> {
    let all = summary.control_states.iter();
    all.map(|(component, state)| json!({ "component": component, "state": state }))
        .collect()
}

fn counts_json(counts: &EventCounts) -> Vec<serde_json::Value> {
    let all = counts.0.iter();
    all.map(|(name, count)| json!({ "name": name, "count": count }))
        .collect()
}

fn robot_json(robot: &RobotSummary<'_>) -> serde_json::Value {
    json!({
        "name": robot.name, "control_state": robot.control_state, "cause": robot.cause,
        "driven_m": robot.path.driven_m, "to_goal_m": robot.to_goal_m(),
        "true_to_goal_m": robot.true_to_goal_m(),
    })
}

fn stalled_json(stalled: &StalledCoordinator) -> serde_json::Value {
    json!({
        "component": stalled.component, "state": stalled.state, "since_s": stalled.since_s,
        "reasons": stalled.reasons,
    })
}

/// The result of a mission on one line: `reached in ARRIVED after 41.3 s`, or, with coordinators in different control states,
/// `time up in ARRIVED (Left/Coordinator), FOLLOWING (Right/Coordinator) after 20.0 s`.
pub(super) fn headline(end: &MissionEnd) -> String {
    format!("{}{}", end.outcome.name(), circumstances(end))
}

/// Number of coordinators up to which each is named with its control state.
const MANY: usize = 4;

/// Distance from its goal, in m, up to which a robot counts as there.
const AT_GOAL_M: f64 = 0.3;

/// The control state of all coordinators, or that of each if they differ; of many, the number in each state.
fn control_states(summary: &Summary) -> String {
    if let Some(state) = summary.control_state() {
        return format!(" in {state}");
    }
    let states = &summary.control_states;
    let all: Vec<String> = if states.len() > MANY {
        let mut counts: BTreeMap<&str, u64> = BTreeMap::new();
        for state in states.values() {
            *counts.entry(state.as_str()).or_default() += 1;
        }
        let counts = counts.into_iter();
        counts
            .map(|(state, count)| format!("{state} ×{count}"))
            .collect()
    } else {
        let all = states.iter();
        all.map(|(component, state)| format!("{state} ({component})"))
            .collect()
    };
    if all.is_empty() {
        String::new()
    } else {
        format!(" in {}", all.join(", "))
    }
}

/// The control states, time and collisions at the end.
fn circumstances(end: &MissionEnd) -> String {
    let state = control_states(&end.summary);
    let seconds = end.time.as_secs_f64();
    let collisions = match end.summary.collisions {
        0 => String::new(),
        1 => ", with a collision".to_owned(),
        count => format!(", with {count} collisions"),
    };
    format!("{state} after {seconds:.1} s{collisions}")
}

/// The driven distance, and the distances to the goal.
fn driven(robot: &RobotSummary<'_>) -> String {
    let mut text = format!("{:.1} m", robot.path.driven_m);
    if let Some(metres) = robot.to_goal_m() {
        text += &format!(", {metres:.2} m from the goal by odometry");
    }
    if let Some(metres) = robot.true_to_goal_m() {
        text += &format!(", {metres:.2} m in truth (simulator)");
    }
    text
}

/// Prints the last changes that the story has only counted.
pub(super) fn print_last_changes(end: &MissionEnd, terminal: &mut TerminalOutput) {
    for line in &end.last_changes {
        terminal.progress(line);
    }
}

pub(super) fn print_summary(end: &MissionEnd, terminal: &mut TerminalOutput) {
    let summary = &end.summary;
    let style = match end.outcome {
        MissionOutcome::Reached | MissionOutcome::Completed if summary.collisions > 0 => BAD,
        MissionOutcome::Reached | MissionOutcome::Completed => GOOD,
        MissionOutcome::Failed | MissionOutcome::Fault => BAD,
        MissionOutcome::TimeUp | MissionOutcome::Stopped => NOTE,
    };
    let seconds = end.time.as_secs_f64();
    terminal.progress("");
    terminal.result(format_args!(
        "{style}{}{style:#}{}",
        end.outcome.name(),
        circumstances(end)
    ));
    match summary.robots.only() {
        Some(robot) => terminal.result(format_args!("  driven     {}", driven(&robot))),
        None => {
            for robot in summary.robots.all() {
                let is_elsewhere = robot.to_goal_m().is_some_and(|it| it > AT_GOAL_M);
                let cause = match robot.cause {
                    cause if is_elsewhere && !cause.is_empty() => format!(" ({cause})"),
                    _ => String::new(),
                };
                let state = robot.control_state;
                let state = state.map_or_else(String::new, |state| format!("{state}{cause}, "));
                let (name, driven) = (robot.name, driven(&robot));
                terminal.result(format_args!("  {name:<9}  {state}driven {driven}"));
            }
        }
    }
    if !summary.received.0.is_empty() {
        terminal.result(format_args!("  received   {}", summary.received));
    }
    if !summary.calls.0.is_empty() {
        let failed = summary.failed_calls;
        terminal.result(format_args!(
            "  calls      {}; {failed} failed",
            summary.calls
        ));
    }
    terminal.result(format_args!(
        "  steps      {} with updates, {} changes of control state",
        summary.steps, summary.transitions
    ));
    for fault in &summary.faults {
        terminal.result(format_args!("  {BAD}fault{BAD:#}      {fault}"));
    }
    if !end.failed.is_empty() {
        let failed = end.failed.join(", ");
        terminal.result(format_args!(
            "  {BAD}failed{BAD:#}     {failed}: not running at the end"
        ));
    }
    for (input, count) in &end.lost {
        terminal.result(format_args!(
            "  {NOTE}lost{NOTE:#}       {count} messages to {input}"
        ));
    }
    for (service, count) in &end.refused {
        terminal.result(format_args!(
            "  {NOTE}refused{NOTE:#}    {count} requests to {service}: its queue was full"
        ));
    }
    for (component, count) in &end.unsuitable {
        terminal.result(format_args!(
            "  {NOTE}unsuitable{NOTE:#} {count} messages to {component}"
        ));
    }
    for stalled in &end.stalled {
        terminal.result(format_args!("  {NOTE}waits{NOTE:#}      {stalled}"));
    }
    if let Some(recording) = &end.recording {
        print_recording(recording, terminal);
    }
    let wall = end.wall.as_secs_f64();
    terminal.progress(format_args!(
        "  {FAINT}{wall:.2} s of wall-clock time: {:.0} times real time{FAINT:#}",
        seconds / wall.max(1e-9)
    ));
}

fn print_recording(recording: &RecordingResult, terminal: &mut TerminalOutput) {
    let paths = recording.paths.iter();
    let paths: Vec<_> = paths.map(|path| path.display().to_string()).collect();
    let paths = paths.join(", ");
    let megabytes = recording.bytes as f64 / 1e6;
    if let ([], Some(failure)) = (&*recording.paths, &recording.failure) {
        terminal.result(format_args!("  {BAD}recording{BAD:#}  none: {failure}"));
        return;
    }
    if recording.is_complete() {
        terminal.result(format_args!("  recording  {paths} ({megabytes:.1} MB)"));
        return;
    }
    let lost = match recording.lost {
        0 => String::new(),
        1 => ": 1 message is lost".to_owned(),
        count => format!(": {count} messages are lost"),
    };
    let failure = recording.failure.iter();
    let failure: String = failure.map(|reason| format!("; {reason}")).collect();
    terminal.result(format_args!(
        "  {BAD}recording{BAD:#}  {paths} ({megabytes:.1} MB) is INCOMPLETE{lost}{failure}"
    ));
}

fn recording_json(recording: &RecordingResult) -> serde_json::Value {
    json!({
        "paths": recording.paths, "bytes": recording.bytes, "complete": recording.is_complete(),
        "lost": recording.lost, "failure": recording.failure,
    })
}
