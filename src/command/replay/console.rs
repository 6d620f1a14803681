//! Prints the results of replays for people.

use std::collections::BTreeSet;
use std::time::Duration;

use asmotion_recording::{InputChange, LocationWriter};
use asmotion_remote::{CommandOutcome, CommandRecord, TabLogin};

use super::outcome::{
    CoordinatorOutcome, Explained, ReachedState, RecordingOutcome, ReplayVerdict,
};
use super::words::{self, seconds, step};
use crate::numbers::counted;
use crate::show;
use crate::terminal::{BAD, FAINT, GOOD, NAME, NOTE, TerminalOutput};

/// Limit on the commands of a recording that are printed.
const MOST_COMMANDS: usize = 20;

/// Prints all results and a summary.
pub fn print(outcomes: &[RecordingOutcome], wall: Duration, terminal: &mut TerminalOutput) {
    for outcome in outcomes {
        print_recording(outcome, terminal);
    }
    print_summary(outcomes, wall, terminal);
}

/// Prints why recordings are different or unusable.
pub fn print_trouble(outcomes: &[RecordingOutcome], terminal: &mut TerminalOutput) {
    for outcome in outcomes {
        let path = outcome.path.display();
        if let Some(failure) = &outcome.failure {
            terminal.error(format_args!("`{path}`: {failure}"));
        }
        for (name, one) in &outcome.coordinators {
            if let Some(reason) = one.reason() {
                terminal.error(format_args!("`{path}`: `{name}`: {reason}"));
            }
            if let Some(difference) = &one.difference {
                let at = step(difference.number, difference.time_ns);
                terminal.error(format_args!("`{path}`: `{name}` is different from {at} on"));
            }
        }
    }
}

fn print_recording(outcome: &RecordingOutcome, terminal: &mut TerminalOutput) {
    let path = outcome.path.display();
    let about = [
        outcome.fact("composite").map(str::to_owned),
        outcome
            .fact("process")
            .map(|name| format!("process {name}")),
        outcome.fact("clock").map(|clock| format!("{clock} clock")),
        outcome.fact("started").map(str::to_owned),
    ];
    let about: Vec<_> = about.into_iter().flatten().collect();
    let about = about.join(", ");
    terminal.result(format_args!(
        "{NAME}{path}{NAME:#}  {FAINT}{about}{FAINT:#}"
    ));
    if let Some(failure) = &outcome.failure {
        terminal.result(if outcome.is_skipped {
            format!("  {NOTE}skipped{NOTE:#}    this process has no coordinator")
        } else {
            format!("  {BAD}unusable{BAD:#}   {failure}")
        });
    }
    for (name, one) in &outcome.coordinators {
        print_coordinator(name, one, terminal);
    }
    print_commands(outcome, terminal);
    if let Some(missing) = outcome.missing().filter(|_| outcome.failure.is_none()) {
        terminal.result(format_args!("  {BAD}INCOMPLETE{BAD:#} {missing}"));
    }
}

/// Prints what others asked of the system: where it came from, and what became of it.
fn print_commands(outcome: &RecordingOutcome, terminal: &mut TerminalOutput) {
    let key = |it: &CommandRecord| (it.number, it.client.clone(), it.tab);
    let is_open = |it: &CommandRecord| it.outcome == CommandOutcome::Asked;
    let commands = outcome.commands.iter();
    let ended = commands.filter(|(_, it)| !is_open(it));
    let ended: BTreeSet<_> = ended.map(|(_, it)| key(it)).collect();
    // the record of its outcome says what was asked
    let commands = outcome.commands.iter();
    let shown = commands.filter(|(_, it)| !is_open(it) || !ended.contains(&key(it)));
    let shown: Vec<_> = shown.collect();
    for (at, command) in shown.iter().take(MOST_COMMANDS) {
        let login = match command.login {
            TabLogin::None => String::new(),
            login @ (TabLogin::Cookie | TabLogin::Token) => format!(" ({login})"),
        };
        let (at, from) = (seconds(at.nanos()), command.origin());
        let words = command.words();
        terminal.result(format_args!("  command    {at}, {from}{login}: {words}"));
    }
    if let Some(more) = shown.len().checked_sub(MOST_COMMANDS).filter(|it| *it > 0) {
        let more = counted(more as u64, "more command");
        terminal.result(format_args!(
            "  {FAINT}and {more}: `--json` has all{FAINT:#}"
        ));
    }
}

fn print_coordinator(name: &str, one: &CoordinatorOutcome, terminal: &mut TerminalOutput) {
    let verdict = one.verdict();
    let style = match verdict {
        ReplayVerdict::Equal => GOOD,
        ReplayVerdict::Skipped => NOTE,
        ReplayVerdict::Different | ReplayVerdict::Unusable => BAD,
    };
    let word = verdict.word();
    let who = format!("{name} ({})", one.specification);
    let text = match (&one.difference, one.reason()) {
        (_, Some(reason)) => format!("{who}: {reason}"),
        (Some(difference), None) => {
            let at = step(difference.number, difference.time_ns);
            format!(
                "{who}: {at}, after {}",
                equal_steps(one.counts.compared.saturating_sub(1))
            )
        }
        (None, None) => format!(
            "{who}: {}{}",
            equal_steps(one.counts.compared),
            details(one)
        ),
    };
    terminal.result(format_args!("  {style}{word:<10}{style:#} {text}"));
    if let Some(difference) = &one.difference {
        for (label, text) in words::difference(difference) {
            terminal.result(format_args!("    {label:<10} {text}"));
        }
    }
    for (text, number) in &one.notes {
        terminal.result(format_args!(
            "    {NOTE}note{NOTE:#}       {text} (from step {number} on)"
        ));
    }
    if let Some(state) = &one.state {
        print_state(state, terminal);
    }
    match &one.explanation {
        Some(Explained::Written(writer)) => print_writer(writer, terminal),
        Some(Explained::Input(change)) => print_input(change, terminal),
        Some(Explained::Initial(location, value)) => {
            let value = value.as_deref().unwrap_or("undef");
            terminal.result(format_args!(
                "{NAME}{location}{NAME:#} = {value}, its initial value: no step has written it"
            ));
        }
        None => {}
    }
}

fn equal_steps(steps: u64) -> String {
    match steps {
        1 => "1 equal step".to_owned(),
        steps => format!("{steps} equal steps"),
    }
}

/// Failed steps and further machines.
fn details(one: &CoordinatorOutcome) -> String {
    let failed = match one.counts.failed {
        0 => String::new(),
        1 => ", 1 of which failed as recorded".to_owned(),
        failed => format!(", {failed} of which failed as recorded"),
    };
    let began = match one.counts.machines {
        0 | 1 => String::new(),
        2 => ", began again once".to_owned(),
        machines => format!(", began again {} times", machines - 1),
    };
    failed + &began
}

fn print_state(state: &ReachedState, terminal: &mut TerminalOutput) {
    let at = match state.number {
        0 => "before the first step".to_owned(),
        number => format!("after {}", step(number, state.time_ns)),
    };
    terminal.result(format_args!("{NAME}state {at}{NAME:#}"));
    for (location, value) in &state.locations {
        terminal.result(format_args!("  {location} = {value}"));
    }
    for (location, value) in &state.inputs {
        terminal.result(format_args!("  {FAINT}input {location} = {value}{FAINT:#}"));
    }
}

fn print_writer(writer: &LocationWriter, terminal: &mut TerminalOutput) {
    let LocationWriter {
        location,
        before,
        after,
        place: (path, line, column),
        ..
    } = writer;
    let at = step(writer.number, writer.time_ns);
    terminal.result(format_args!(
        "{NAME}{location}{NAME:#} = {after}, written in {at}  {FAINT}(was {before}){FAINT:#}"
    ));
    let rule = writer.rule.as_ref().map(|rule| format!(" in {rule}"));
    let rule = rule.unwrap_or_default();
    terminal.result(format_args!(
        "  `{}`{rule}, {path}:{line}:{column}",
        writer.text
    ));
    if let Some(rule) = &writer.safe_rule {
        terminal.result(format_args!(
            "  because    the step violated a property, and the safe rule `{rule}` made it"
        ));
    }
    for guard in &writer.guards {
        terminal.result(format_args!("  because    {}", show::guard(guard)));
    }
    terminal.result(format_args!("  cause      {}", words::cause(&writer.cause)));
    for read in &writer.read {
        terminal.result(format_args!(
            "  {FAINT}input      {} = {}{FAINT:#}",
            read.location, read.value
        ));
    }
}

fn print_input(change: &InputChange, terminal: &mut TerminalOutput) {
    let InputChange {
        location,
        before,
        value,
        number,
        time_ns,
        cause,
    } = change;
    let at = step(*number, *time_ns);
    let before = before
        .as_ref()
        .map(|value| format!("  {FAINT}(was {value}){FAINT:#}"));
    let before = before.unwrap_or_default();
    terminal.result(format_args!(
        "{NAME}{location}{NAME:#} = {value}, an input with this value since {at}{before}"
    ));
    terminal.result(format_args!("  cause      {}", words::cause(cause)));
}

fn print_summary(outcomes: &[RecordingOutcome], wall: Duration, terminal: &mut TerminalOutput) {
    let totals = Totals::of(outcomes);
    let verdict = totals.verdict;
    let style = match verdict {
        ReplayVerdict::Equal => GOOD,
        ReplayVerdict::Skipped | ReplayVerdict::Different | ReplayVerdict::Unusable => BAD,
    };
    terminal.result(format_args!(
        "{style}{}{style:#}: {}, {}, {} compared, {} of the run",
        verdict.word(),
        counted(outcomes.len() as u64, "recording"),
        counted(totals.coordinators as u64, "coordinator"),
        counted(totals.steps, "step"),
        seconds(totals.time_ns),
    ));
    let run = totals.time_ns as f64 / 1e9;
    let wall = wall.as_secs_f64();
    terminal.progress(format_args!(
        "  {FAINT}{wall:.2} s of wall-clock time: {:.0} times real time{FAINT:#}",
        run / wall.max(1e-9)
    ));
}

/// Sums over all recordings.
pub struct Totals {
    /// The worst verdict.
    pub verdict: ReplayVerdict,
    /// Number of coordinators.
    pub coordinators: usize,
    /// Number of records compared.
    pub steps: u64,
    /// Time of the runs that was replayed, in nanoseconds.
    pub time_ns: i64,
}

impl Totals {
    /// The sums over these results.
    pub fn of(outcomes: &[RecordingOutcome]) -> Self {
        let verdict = outcomes.iter().map(RecordingOutcome::verdict).max();
        let coordinators = || outcomes.iter().flat_map(|it| it.coordinators.values());
        // coordinators of one run make their steps at the same time
        let time = |outcome: &RecordingOutcome| {
            let times = outcome.coordinators.values();
            times
                .map(|one| one.counts.last_ns)
                .max()
                .unwrap_or_default()
        };
        Self {
            verdict: verdict.unwrap_or(ReplayVerdict::Unusable),
            coordinators: coordinators().count(),
            steps: coordinators().map(|one| one.counts.compared).sum(),
            time_ns: outcomes.iter().map(time).sum(),
        }
    }
}
