//! Replays one recording.

use std::collections::BTreeMap;
use std::path::Path;
use std::rc::Rc;

use asmotion_component::Time;
use asmotion_diagnostics::{or_did_you_mean, similar};
use asmotion_lang::simulate;
use asmotion_recording::{
    ChainedCycle, CoordinatorReplay, EditedSpecification, FileEnd, RecordingItem, ReplayOptions,
    RunFiles, SourceTexts,
};
use asmotion_remote::CommandRecord;

use super::export::{Export, ExportFormat};
use super::outcome::{CoordinatorOutcome, Explained, ReachedState, RecordingOutcome};
use super::stop::StopPoint;

/// Channel of a recording with what others asked of the system.
const COMMANDS: &str = "commands";

/// Options of the replay of a recording.
#[derive(Clone, Copy)]
pub struct ReplaySession<'a> {
    /// The coordinator to replay; `None` for all.
    pub component: Option<&'a str>,
    /// Specification in the place of the recorded one.
    pub edited: Option<&'a Rc<EditedSpecification>>,
    /// The point at which it stops.
    pub until: Option<StopPoint>,
    /// Location whose last write is explained.
    pub explained: Option<&'a str>,
    /// Form in which the steps are exported.
    pub export: Option<ExportFormat>,
    /// File of the export.
    pub output: Option<&'a Path>,
}

/// A coordinator that is replayed.
struct OpenCoordinator {
    specification: String,
    replay: CoordinatorReplay,
    failure: Option<String>,
    export: Option<Export>,
    /// Time of the last step that was repeated.
    last_ns: i64,
    /// The point at which the replay stops is reached.
    is_done: bool,
}

/// What is known about a recording while it is read.
#[derive(Default)]
struct ReadRecording {
    texts: SourceTexts,
    open: BTreeMap<String, OpenCoordinator>,
    /// All coordinators with the names of their specifications, also those that are not replayed.
    known: BTreeMap<String, String>,
    end: Option<FileEnd>,
    cut: Option<String>,
    /// What others asked of the system, in the order of the file.
    commands: Vec<(Time, CommandRecord)>,
}

impl ReplaySession<'_> {
    /// Replays a recording.
    pub fn replay(self, files: &RunFiles) -> RecordingOutcome {
        let refused = |failure| RecordingOutcome {
            facts: files.facts.clone(),
            ..RecordingOutcome::refused(files.path.clone(), failure)
        };
        if files.part > 1 {
            let part = files.part;
            return refused(format!(
                "it is part {part} of a recording: name its first file, which finds the others"
            ));
        }
        let read = match self.read(files) {
            Ok(read) => read,
            Err(failure) => return refused(failure),
        };
        // the specification has another name than before
        if let (Some(_), None, true) = (self.edited, self.component, read.open.is_empty())
            && let Some(only) = only(&read.known)
        {
            return self.of_component(only).replay(files);
        }
        match self.unusable(&read) {
            Some(failure) => RecordingOutcome {
                has_no_steps: read.known.is_empty() && read.cut.is_none(),
                ..refused(failure)
            },
            None => self.outcome(files, read),
        }
    }

    /// The same for one coordinator.
    fn of_component<'b>(&'b self, name: &'b str) -> ReplaySession<'b> {
        ReplaySession {
            component: Some(name),
            ..*self
        }
    }

    fn read(self, files: &RunFiles) -> Result<ReadRecording, String> {
        let mut read = ReadRecording::default();
        for item in files.items().map_err(|error| error.to_string())? {
            match item {
                RecordingItem::Text { name, text, .. } => read.texts.add(&name, text),
                RecordingItem::Step { component, step } => {
                    self.step(&component, &step, &mut read);
                    let is_done = read.open.values().all(|one| one.is_done);
                    if self.component.is_some() && is_done && !read.open.is_empty() {
                        break;
                    }
                }
                RecordingItem::Message { channel, at, data } => {
                    if channel == COMMANDS
                        && let Ok(record) = data.datum()
                        && let Ok(command) = record.to::<CommandRecord>()
                    {
                        read.commands.push((at, command));
                    }
                }
                RecordingItem::End(end) => read.end = Some(end),
                RecordingItem::Cut(reason) => read.cut = Some(reason),
            }
        }
        Ok(read)
    }

    fn step(self, component: &str, step: &ChainedCycle, read: &mut ReadRecording) {
        let name = &step.cycle.specification;
        let names = &mut read.known;
        names
            .entry(component.to_owned())
            .or_insert_with(|| name.clone());
        if !self.selects(component, name) && !read.open.contains_key(component) {
            return;
        }
        let open = read.open.entry(component.to_owned());
        let one = open.or_insert_with(|| self.open(name));
        let last = one.replay.counts().last_number;
        let is_later = |until: StopPoint| until.is_before(&step.cycle, last);
        one.is_done |= self.until.is_some_and(is_later);
        if one.is_done || one.failure.is_some() {
            return;
        }
        match one.replay.step(step, &read.texts) {
            Ok(false) => {}
            Ok(true) => {
                one.last_ns = step.cycle.time_ns;
                let has_differed = one.replay.difference().is_some();
                if let (Some(export), Some((specification, machine)), false) =
                    (&mut one.export, one.replay.machine(), has_differed)
                {
                    export.add(&step.cycle, specification, machine);
                }
            }
            Err(failure) => one.failure = Some(failure.to_string()),
        }
    }

    fn selects(self, component: &str, specification: &str) -> bool {
        match (self.component, self.edited) {
            (Some(name), _) => name == component,
            (None, Some(edited)) => *edited.name == *specification,
            (None, None) => true,
        }
    }

    fn open(self, specification: &str) -> OpenCoordinator {
        OpenCoordinator {
            specification: specification.to_owned(),
            replay: CoordinatorReplay::new(ReplayOptions {
                edited: self.edited.cloned(),
                explained: self.explained.map(str::to_owned),
                keeps_candidates: self.export == Some(ExportFormat::Scenario),
            }),
            failure: None,
            export: self.export.map(Export::new),
            last_ns: 0,
            is_done: false,
        }
    }

    /// Returns the reason that nothing can be compared, or that a single coordinator has to be selected.
    fn unusable(self, read: &ReadRecording) -> Option<String> {
        let names: Vec<_> = read.known.keys().collect();
        let listed = |names: &[&String]| {
            let names = names.iter().map(|name| format!("`{name}`"));
            names.collect::<Vec<_>>().join(", ")
        };
        if names.is_empty() {
            let lost = read.end.iter().flat_map(|end| &end.coordinators);
            let lost: Vec<_> = lost.map(|(name, _)| name).collect();
            return Some(match (lost.as_slice(), &read.cut) {
                ([], None) => {
                    "it has no steps of a coordinator, so there is nothing to replay".to_owned()
                }
                ([], Some(reason)) => {
                    format!("it ends before the first step of a coordinator: {reason}")
                }
                (lost, _) => format!("all steps of {} are lost", listed(lost)),
            });
        }
        if read.open.is_empty() {
            let known = listed(&names);
            return Some(match self.component {
                Some(name) => format!(
                    "it has no coordinator `{name}`{}; it has {known}",
                    or_did_you_mean(similar(name, names).map(String::as_str))
                ),
                None => format!(
                    "no coordinator has a specification of this name: select one of {known} with `--component`"
                ),
            });
        }
        let needs_one = self.explained.is_some()
            || self.export.is_some()
            || matches!(self.until, Some(StopPoint::Step(_)));
        (needs_one && read.open.len() > 1).then(|| {
            format!(
                "it has several coordinators: select one of {} with `--component`",
                listed(&names)
            )
        })
    }

    fn outcome(self, files: &RunFiles, read: ReadRecording) -> RecordingOutcome {
        let ReadRecording {
            open,
            end,
            cut,
            commands,
            ..
        } = read;
        let failure = read_failure(&end, &cut);
        let end = end.filter(|_| failure.is_none());
        let mut outcome = RecordingOutcome {
            path: files.path.clone(),
            facts: files.facts.clone(),
            cut: failure,
            lost: end.as_ref().map_or(0, |end| end.lost),
            commands: self.commands(commands, &open),
            ..RecordingOutcome::default()
        };
        for (name, mut one) in open {
            let of_coordinator = end.as_ref().and_then(|end| end.coordinators.get(&name));
            if let (Some(end), Some(own), false) = (&end, of_coordinator, one.is_done) {
                one.replay.end(own);
                one.replay.difference_unless_lost(own.lost.max(end.lost));
            }
            let lost = of_coordinator.map_or(0, |end| end.lost);
            outcome
                .coordinators
                .insert(name, self.coordinator(one, lost));
        }
        outcome
    }

    /// The commands up to the point at which the replay stops, by time.
    fn commands(
        self,
        mut commands: Vec<(Time, CommandRecord)>,
        open: &BTreeMap<String, OpenCoordinator>,
    ) -> Vec<(Time, CommandRecord)> {
        if self.until.is_some() {
            let last_ns = open.values().map(|one| one.last_ns).max().unwrap_or(0);
            commands.retain(|(at, _)| at.nanos() <= last_ns);
        }
        commands.sort_by_key(|(at, _)| *at);
        commands
    }

    fn coordinator(self, one: OpenCoordinator, lost: u64) -> CoordinatorOutcome {
        let replay = &one.replay;
        let mut failure = one.failure;
        if let (Some(StopPoint::Step(number)), None, None) =
            (self.until, &failure, replay.difference())
            && replay.counts().last_number < number
        {
            let last = replay.counts().last_number;
            failure = Some(format!(
                "it has no step {number}: the last one is step {last}"
            ));
        }
        let mut explanation = None;
        if let (Some(location), None) = (self.explained, &failure) {
            match explain(location, replay) {
                Ok(explained) => explanation = Some(explained),
                Err(error) => failure = Some(error),
            }
        }
        let wants_state = self.until.is_some() && self.explained.is_none() && self.export.is_none();
        let state = replay
            .machine()
            .filter(|_| wants_state && failure.is_none());
        let state = state.map(|(_, machine)| ReachedState {
            number: machine.steps(),
            time_ns: one.last_ns,
            // an input has the value of the step, not that of the last step that read it
            locations: (simulate::state(machine).into_iter())
                .filter(|(location, _)| !replay.inputs().contains_key(location))
                .collect(),
            inputs: replay.inputs().clone(),
        });
        let machine = replay.machine().map(|(_, machine)| machine);
        CoordinatorOutcome {
            specification: one.specification,
            counts: replay.counts().clone(),
            lost,
            difference: replay.difference().cloned(),
            failure,
            notes: replay
                .notes()
                .map(|(text, number)| (text.to_owned(), number))
                .collect(),
            state,
            explanation,
            export: one.export.map(|it| it.finish(self.output, machine)),
        }
    }
}

/// The reason that a recording ends before its run.
fn read_failure(end: &Option<FileEnd>, cut: &Option<String>) -> Option<String> {
    let of_writer = end.as_ref().and_then(|end| end.failure.as_ref());
    match (cut.as_ref().or(of_writer), end) {
        (Some(reason), _) => Some(format!("it ends before its run: {reason}")),
        (None, None) => Some("it ends before its run".to_owned()),
        (None, Some(_)) => None,
    }
}

/// The only coordinator.
fn only(known: &BTreeMap<String, String>) -> Option<&str> {
    let mut names = known.keys();
    let first = names.next()?;
    names.next().is_none().then_some(first)
}

/// Explains a location.
///
/// # Errors
/// The specification has no such location.
fn explain(location: &str, replay: &CoordinatorReplay) -> Result<Explained, String> {
    if let Some(writer) = replay.writer() {
        return Ok(Explained::Written(Box::new(writer)));
    }
    if let Some(change) = replay.input_change() {
        return Ok(Explained::Input(change.clone()));
    }
    let Some((specification, machine)) = replay.machine() else {
        return Err("it has no step up to there".to_owned());
    };
    let blank = |text: &str| text.split_whitespace().collect::<String>();
    let name = location.split('(').next().unwrap_or_default().trim();
    let state = simulate::state(machine);
    if let Some((known, value)) = state
        .iter()
        .find(|(known, _)| blank(known) == blank(location))
    {
        return Ok(Explained::Initial(known.clone(), Some(value.clone())));
    }
    let functions = specification.model.own_functions();
    let names: Vec<String> = functions
        .map(|(_, function)| function.name.to_string())
        .collect();
    if !names.iter().any(|known| known == name) {
        let hint = or_did_you_mean(similar(name, &names).map(String::as_str));
        return Err(format!(
            "`{location}` is no location of its specification{hint}"
        ));
    }
    let own = state
        .iter()
        .filter(|(known, _)| known.starts_with(&format!("{name}(")));
    let own: Vec<_> = own.map(|(known, _)| format!("`{known}`")).take(5).collect();
    if own.is_empty() {
        return Ok(Explained::Initial(location.to_owned(), None));
    }
    Err(format!(
        "`{location}` has no value; locations with one are {}",
        own.join(", ")
    ))
}
