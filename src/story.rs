//! The story of a mission: what happens, told as it happens.
//!
//! [`Story`] turns the events of a run into lines; [`Summary`] is what is left of it in the end. Both
//! know the words of navigation (goal, path, odometry) and show other messages by topic.

use std::fmt::{self, Write};

use component::{CallError, Event, Losses, Time};
use coordinator::{LOSSES_REPORT, STEP_REPORT, StepRecord, UNSENT_REPORT, UpdateRecord};
use datum::{Datum, Sample};
use messages::{Bool, OccupancyGrid, Odometry, Path, Point, PoseStamped};

use crate::terminal::{BAD, FAINT, GOOD, NAME, NOTE};

/// The functions that hold a control state, by custom.
const CONTROL_STATES: &[&str] = &["mode", "ctl_state", "ctlState", "state"];

/// How often progress is told while nothing else happens, in seconds of the run.
const PROGRESS_S: f64 = 5.0;

/// What is left of a mission in the end.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Summary {
    /// Steps that wrote something.
    pub steps: u64,
    /// Changes of the control state.
    pub transitions: u64,
    /// Service calls begun, by name and in order of first use.
    pub calls: Vec<(String, u64)>,
    /// Calls that failed or came too late.
    pub failed_calls: u64,
    /// Paths received from the planner.
    pub paths: u64,
    /// Times the way was found blocked.
    pub blocked: u64,
    /// Metres driven, by odometry.
    pub driven_m: f64,
    /// Metres from the last goal, by odometry.
    pub to_goal_m: Option<f64>,
    /// The control state.
    pub control_state: Option<String>,
    /// Faults of components, as "component: fault".
    pub faults: Vec<String>,
    /// The last time anything was seen at.
    pub ended: Option<Time>,
}

/// Tells the events of a run.
#[derive(Debug, Default)]
pub struct Story {
    summary: Summary,
    goal: Option<Point>,
    pose: Option<Point>,
    told_progress: f64,
    moving: bool,
}

impl Story {
    /// Nothing happened yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// What is left of it so far.
    pub fn summary(&self) -> &Summary {
        &self.summary
    }

    /// Takes in an event; the lines to tell about it, mostly none.
    pub fn tell(&mut self, at: Time, event: &Event<'_>) -> Option<String> {
        self.summary.ended = Some(at);
        let what = match event {
            Event::Published {
                component,
                topic,
                sample,
                port,
                ..
            } => self.published(at, component, topic.unwrap_or(port), *sample),
            Event::Injected { place, sample } => self.published(at, "outside", place, *sample),
            Event::Called {
                reference,
                operation,
                attempt,
                ..
            } => Some(self.called(reference, operation, *attempt)),
            Event::Replied {
                reference,
                operation,
                result,
                ..
            } => Some(self.replied(reference, operation, *result)),
            Event::Report {
                component,
                kind,
                what,
            } if *kind == STEP_REPORT => self.step(component, what),
            Event::Report {
                component,
                kind,
                what,
            } if *kind == UNSENT_REPORT => {
                let missing = what.as_text().unwrap_or_default();
                Some(format!(
                    "{NOTE}unsent{NOTE:#} {component} has no `{missing}` yet"
                ))
            }
            Event::Report {
                component,
                kind,
                what,
            } if *kind == LOSSES_REPORT => {
                let Losses { dropped, misfits } = what.to().ok()?;
                Some(format!(
                    "{NOTE}lost{NOTE:#} {component}: {dropped} events dropped, {misfits} messages did not fit, so far"
                ))
            }
            Event::Fault { component, fault } => {
                self.summary.faults.push(format!("{component}: {fault}"));
                Some(format!("{BAD}fault{BAD:#} of {component}: {fault}"))
            }
            Event::Overrun { component, missed } => Some(format!(
                "{NOTE}overrun{NOTE:#} {component} missed {missed} periods"
            )),
            Event::Late {
                component,
                took,
                deadline,
            } => Some(format!(
                "{NOTE}late{NOTE:#} {component} took {took:.1?} for a cycle, and has {deadline:?}"
            )),
            Event::Denied { component, denied } => {
                Some(format!("{NOTE}denied{NOTE:#} {component}: {denied}"))
            }
            Event::Dropped {
                component,
                port,
                to,
                total,
                ..
            } => Some(format!(
                "{NOTE}dropped{NOTE:#} {component}.{port} → {to}: {total} so far"
            )),
            Event::Lost { count } => {
                Some(format!("{NOTE}lost{NOTE:#} {count} events of this story"))
            }
            Event::Cycle { .. }
            | Event::Answered { .. }
            | Event::LifeCycle { .. }
            | Event::Property { .. }
            | Event::Report { .. } => None,
        }?;
        Some(format!("{FAINT}{:>8.2} s{FAINT:#}  {what}", at.seconds()))
    }

    fn published(
        &mut self,
        at: Time,
        component: &str,
        place: &str,
        sample: &dyn Sample,
    ) -> Option<String> {
        if let Some(odometry) = sample.downcast_ref::<Odometry>() {
            return self.moved(at, &odometry.pose.pose.position);
        }
        if let Some(goal) = sample
            .downcast_ref::<PoseStamped>()
            .filter(|_| place == "goal")
        {
            let to = goal.pose.position;
            self.goal = Some(to);
            return Some(format!("{NAME}goal{NAME:#}  ({:.1}, {:.1})", to.x, to.y));
        }
        if let Some(pressed) = sample.downcast_ref::<Bool>().filter(|_| place == "estop") {
            let what = if pressed.data { "pressed" } else { "let go of" };
            return Some(format!("{BAD}e-stop{BAD:#} {what}"));
        }
        if let Some(event) = sample.downcast_ref::<messages::Event>() {
            self.summary.blocked += u64::from(event.code == messages::Event::BLOCKED);
            let detail = if event.detail.is_empty() { "" } else { ": " };
            let (code, text) = (&event.code, &event.detail);
            return Some(format!(
                "{NOTE}event{NOTE:#} {code} of {component}{detail}{text}"
            ));
        }
        (place == "cancel").then(|| format!("{NOTE}cancel{NOTE:#}"))
    }

    fn moved(&mut self, at: Time, to: &Point) -> Option<String> {
        if let Some(from) = self.pose.replace(*to) {
            self.summary.driven_m += (to.x - from.x).hypot(to.y - from.y);
        }
        let goal = self.goal?;
        let left = (goal.x - to.x).hypot(goal.y - to.y);
        self.summary.to_goal_m = Some(left);
        if !self.moving || at.seconds() - self.told_progress < PROGRESS_S {
            return None;
        }
        self.told_progress = at.seconds();
        Some(format!(
            "{FAINT}at ({:.1}, {:.1}), {left:.1} m from the goal{FAINT:#}",
            to.x, to.y
        ))
    }

    fn called(&mut self, reference: &str, operation: &str, attempt: u32) -> String {
        let name = format!("{reference}.{operation}");
        match self
            .summary
            .calls
            .iter_mut()
            .find(|(known, _)| *known == name)
        {
            Some((_, count)) => *count += 1,
            None => self.summary.calls.push((name.clone(), 1)),
        }
        let again = if attempt > 1 {
            format!(" (attempt {attempt})")
        } else {
            String::new()
        };
        format!("{NAME}call{NAME:#}  {name}{again}")
    }

    fn replied(
        &mut self,
        reference: &str,
        operation: &str,
        result: Result<&dyn Sample, &CallError>,
    ) -> String {
        let what = match result {
            Ok(sample) => self.reply(sample),
            Err(error) => {
                self.summary.failed_calls += 1;
                format!("{NOTE}{error}{NOTE:#}")
            }
        };
        format!("{NAME}reply{NAME:#} {reference}.{operation}: {what}")
    }

    fn reply(&mut self, sample: &dyn Sample) -> String {
        // a reply may come typed, or as the data the coordinator keeps
        let shared = sample.to_shared();
        match sample.type_name() {
            "" => {}
            name => {
                if let Some(path) = sample.downcast_ref::<Path>() {
                    return self.path(path);
                }
                if let Some(map) = sample.downcast_ref::<OccupancyGrid>() {
                    return describe_map(map);
                }
                return name.to_owned();
            }
        }
        // what a message lacks gets its initial value: any data could be read as a path
        let has = |field: &str| matches!(shared.clone().read::<Datum>(), Ok(it) if it.get(field).is_some());
        if has("poses")
            && let Ok(path) = shared.clone().read::<Path>()
        {
            return self.path(&path);
        }
        match shared.clone().read::<OccupancyGrid>() {
            Ok(map) if has("info") => describe_map(&map),
            _ => "done".to_owned(),
        }
    }

    fn path(&mut self, path: &Path) -> String {
        let metres = length(path);
        self.summary.paths += 1;
        format!("a path of {metres:.1} m in {} poses", path.poses.len())
    }

    fn step(&mut self, component: &str, what: &Datum) -> Option<String> {
        let record: StepRecord = what.to().ok()?;
        self.summary.steps += 1;
        for update in &record.updates {
            if update.location == "moving" {
                self.moving = update.after == "true";
            }
        }
        let is_control =
            |update: &&UpdateRecord| CONTROL_STATES.contains(&update.location.as_str());
        let control = record.updates.iter().find(is_control);
        let changed = control.filter(|control| control.before != control.after);
        let Some(control) = changed else {
            return Some(format!(
                "{FAINT}step {}  {}{FAINT:#}",
                record.number,
                OnOneLine(&record)
            ));
        };
        self.summary.transitions += 1;
        self.summary.control_state = Some(control.after.clone());
        let mut line = String::new();
        // writing to a string cannot fail
        let _ = write!(
            line,
            "{GOOD}step {}{GOOD:#}  {} → {GOOD}{}{GOOD:#}   {FAINT}{component}{FAINT:#}",
            record.number, control.before, control.after
        );
        for update in &record.updates {
            let _ = write!(line, "\n{:>12}{}", "", Shown(update));
        }
        Some(line)
    }
}

/// A step that left the control state alone: its updates that changed something.
struct OnOneLine<'a>(&'a StepRecord);

impl fmt::Display for OnOneLine<'_> {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        let changed = self
            .0
            .updates
            .iter()
            .filter(|update| update.before != update.after);
        let changed: Vec<String> = changed
            .map(|update| format!("{} := {}", update.location, update.after))
            .collect();
        match changed.is_empty() {
            true => to.write_str("changed nothing"),
            false => to.write_str(&changed.join(", ")),
        }
    }
}

/// An update as the language writes it, with what was there before.
struct Shown<'a>(&'a UpdateRecord);

impl fmt::Display for Shown<'_> {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        let UpdateRecord {
            location,
            before,
            after,
        } = self.0;
        write!(to, "{location} := {after}")?;
        if before != after {
            write!(to, "  {FAINT}(was {before}){FAINT:#}")?;
        }
        Ok(())
    }
}

fn describe_map(map: &OccupancyGrid) -> String {
    let info = &map.info;
    format!(
        "a map of {} × {} cells, {:.2} m each",
        info.width, info.height, info.resolution
    )
}

/// m.
fn length(path: &Path) -> f64 {
    let points = path.poses.iter().map(|pose| pose.pose.position);
    let pairs = points.clone().zip(points.skip(1));
    pairs.map(|(a, b)| (b.x - a.x).hypot(b.y - a.y)).sum()
}
