//! `asmotion up`: starts and supervises the processes of a composite on this machine.

mod relay;

use std::ffi::OsString;
use std::os::unix::process::CommandExt;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use asmotion_composite::model::{BuiltinComponent, RestartPolicy};
use asmotion_datum::Word as _;
use asmotion_plan::{Implementation, Plan, Process, Restart};
use clap::Args;
use rustix::process::{Pid, Signal, kill_process};

use crate::build::Build;
use crate::exit::Exit;
use crate::files::DiskLoader;
use crate::mission::MissionError;
use crate::programs::{ProcessChoice, this_machine};
use crate::terminal::{TerminalOutput, never_wait};
use crate::transport::BrokerAccess;
use relay::Relay;

/// Starts the processes of a composite that belong to this machine, and restarts them as its `restart` prescribes.
#[derive(Args)]
pub struct Up {
    /// Composite file
    composite: String,

    /// Profile of the composite
    #[arg(long)]
    profile: Option<String>,

    /// Machine whose processes are started [default: this one]; processes without a `host` belong to every machine
    #[arg(long)]
    host: Option<String>,

    /// Broker, as for `asmotion run`
    #[arg(long, value_name = "URL")]
    bus: Option<String>,

    #[command(flatten)]
    access: BrokerAccess,

    /// Robot name, used as the routing-key prefix [default: the composite's name]
    #[arg(long)]
    robot: Option<String>,

    /// Sets a property of the composite (`place=lab`) or of a component (`World.slip=0.01`)
    #[arg(long, value_name = "NAME=VALUE")]
    set: Vec<String>,

    /// Shows each process in a web browser while it lasts, at a port of its own; prints the addresses
    #[arg(long)]
    dashboard: bool,
}

/// Exit code of a process that was started in a wrong way ([`Exit::Usage`]).
const USAGE: i32 = 2;
/// Interval at which child processes are polled.
const LOOK: Duration = Duration::from_millis(50);
/// Default wait before a process is restarted.
const BACKOFF: Duration = Duration::from_millis(200);
/// Time that child processes have to end after SIGTERM.
const GRACE: Duration = Duration::from_secs(10);
/// Time in which the last lines of an ended process are read.
const LAST_LINES: Duration = Duration::from_secs(1);
/// Time after which processes that lead out of the system end too, although others have not.
const LEAD: Duration = Duration::from_secs(1);

impl Up {
    /// Starts the processes and waits until all have ended.
    pub fn run(self, build: &Build, terminal: &mut TerminalOutput) -> Exit {
        let properties = self.set.iter().filter_map(|set| set.split_once('='));
        let settings = properties.filter(|(name, _)| !name.contains('.'));
        let settings: Vec<(String, String)> = settings
            .map(|(name, value)| (name.to_owned(), value.to_owned()))
            .collect();
        let here = self.host.clone().unwrap_or_else(this_machine);
        let choice = ProcessChoice::OnHost(here.clone());
        let opened = build.open_for(choice, &self.composite, &settings, &DiskLoader);
        terminal.report(&opened.report, &opened.sources);
        if opened.report.has_errors() {
            return Exit::refused(&self.composite);
        }
        let Some(plan) = opened.plan(self.profile.as_deref()) else {
            let (wanted, known) = (self.profile, opened.profiles);
            terminal.error(MissionError::Profile {
                requested: wanted,
                available: known,
            });
            return Exit::Usage;
        };
        match self.children(plan, &here, terminal) {
            Ok(children) => supervise(children, terminal),
            Err(problem) => {
                terminal.error(problem);
                Exit::Usage
            }
        }
    }

    /// The processes of this machine, not started yet.
    fn children(
        &self,
        plan: &Plan,
        here: &str,
        terminal: &mut TerminalOutput,
    ) -> Result<Vec<SupervisedProcess>, String> {
        if let ([process, _, ..], None, []) = (&*plan.processes, &self.bus, &*plan.brokers) {
            let needs = MissionError::NeedsBroker {
                process: process.name.clone(),
                has_variable: std::env::var_os("ASMOTION_BUS").is_some(),
                is_supervised: true,
            };
            return Err(needs.to_string());
        }
        let is_here = |it: &&Process| it.host.as_ref().is_none_or(|host| *host == here);
        let (mine, elsewhere): (Vec<_>, Vec<_>) = plan.processes.iter().partition(is_here);
        let hosts = elsewhere.iter().filter_map(|it| it.host.as_deref());
        let hosts = hosts.collect::<Vec<_>>().join("`, `");
        if mine.is_empty() {
            return Err(format!(
                "no process runs on `{here}`, but on `{hosts}`: name this machine with `--host`"
            ));
        }
        for process in elsewhere {
            let host = process.host.as_deref().unwrap_or_default();
            let name = &process.name;
            terminal.status("Left out", format_args!("{name}, which runs on `{host}`"));
        }
        let program = std::env::current_exe().map_err(|error| error.to_string())?;
        let width = mine.iter().map(|it| it.name.chars().count()).max();
        let keeper = |process: &Process| {
            let mut command = Command::new(&program);
            // Ctrl-C must reach only this process, which then stops the children once
            command.process_group(0);
            command.args(self.arguments(&process.name));
            command.stdout(Stdio::piped()).stderr(Stdio::piped());
            SupervisedProcess {
                name: process.name.clone(),
                width: width.unwrap_or_default(),
                relay: Relay::default(),
                command,
                leads_out: leads_out(plan, process),
                restarts: Restarts::new(plan.restart.clone()),
                state: SupervisedState::Due(Instant::now()),
            }
        };
        Ok(mine.into_iter().map(keeper).collect())
    }

    /// Command-line arguments of a process.
    fn arguments(&self, process: &str) -> Vec<OsString> {
        let mut arguments: Vec<OsString> = vec!["run".into(), (&self.composite).into()];
        let mut add = |key: &str, value: &str| arguments.extend([key.into(), value.into()]);
        add("--process", process);
        add("--supervisor", &crate::supervisor::own_id());
        // this process removes the colours where its own output has none
        add("--color", "always");
        let optional = [
            ("--profile", &self.profile),
            ("--bus", &self.bus),
            ("--robot", &self.robot),
        ];
        for (key, value) in optional {
            if let Some(value) = value {
                add(key, value);
            }
        }
        self.set.iter().for_each(|set| add("--set", set));
        arguments.extend(self.access.arguments());
        arguments.extend(self.dashboard.then(|| "--dashboard".into()));
        arguments
    }
}

/// Returns whether a component of the process passes samples on to ROS, another robot or a program.
fn leads_out(plan: &Plan, process: &Process) -> bool {
    let components = plan.components.iter();
    let mut here = components.filter(|it| process.components.contains(&it.name));
    here.any(|component| match &component.implementation {
        Implementation::Builtin { name, .. } => {
            [BuiltinComponent::RosBridge, BuiltinComponent::Remote]
                .iter()
                .any(|it| it.word() == *name)
        }
        Implementation::Process { .. } => true,
        Implementation::Rust(_)
        | Implementation::Asm { .. }
        | Implementation::Ros { .. }
        | Implementation::Orocos { .. } => false,
    })
}

/// A supervised process.
struct SupervisedProcess {
    name: String,
    /// Width of the longest name, in characters.
    width: usize,
    command: Command,
    /// Passes on what other processes write, and ends after them.
    leads_out: bool,
    restarts: Restarts,
    state: SupervisedState,
    relay: Relay,
}

/// State of a supervised process.
enum SupervisedState {
    /// To be started at this time.
    Due(Instant),
    Running(Child),
    Ended {
        success: bool,
    },
}

/// Starts and reaps processes until all have ended.
fn supervise(mut children: Vec<SupervisedProcess>, terminal: &mut TerminalOutput) -> Exit {
    let stop = Arc::new(AtomicBool::new(false));
    let stop_flag = stop.clone();
    // processes are restarted whether the output is read or not
    never_wait();
    // without the handler, Ctrl-C would end this process and leave the children running
    let _ = ctrlc::set_handler(move || stop_flag.store(true, Ordering::Relaxed));
    while !stop.load(Ordering::Relaxed) {
        for child in &mut children {
            child.poll(terminal);
        }
        if children
            .iter()
            .all(|child| matches!(child.state, SupervisedState::Ended { .. }))
        {
            break;
        }
        std::thread::sleep(LOOK);
    }
    let until = Instant::now() + GRACE;
    let (mut last, mut first): (Vec<_>, Vec<_>) = children.iter_mut().partition(|it| it.leads_out);
    first.iter_mut().for_each(|child| child.terminate());
    let lead = Instant::now() + LEAD;
    while Instant::now() < lead && first.iter_mut().any(|child| child.is_running()) {
        std::thread::sleep(LOOK);
    }
    last.iter_mut().for_each(|child| child.terminate());
    for child in &mut children {
        child.wait_for_end(until, terminal);
    }
    for child in &children {
        let (name, all) = (&child.name, child.restarts.total);
        let restarts = if all == 1 { "restart" } else { "restarts" };
        terminal.status("Ended", format_args!("{name}, {all} {restarts}"));
    }
    let well =
        |child: &SupervisedProcess| matches!(child.state, SupervisedState::Ended { success: true });
    if children.iter().all(well) {
        Exit::Ok
    } else {
        Exit::Findings
    }
}

impl SupervisedProcess {
    /// Starts the process if it is due, and handles its end.
    fn poll(&mut self, terminal: &mut TerminalOutput) {
        let now = Instant::now();
        match &mut self.state {
            SupervisedState::Due(at) if *at <= now => self.start(terminal),
            SupervisedState::Due(_) | SupervisedState::Ended { .. } => {}
            SupervisedState::Running(child) => {
                if let Ok(Some(status)) = child.try_wait() {
                    self.ended(status, now, terminal);
                }
            }
        }
    }

    fn start(&mut self, terminal: &mut TerminalOutput) {
        self.state = match self.command.spawn() {
            Ok(mut child) => {
                let (name, id) = (&self.name, child.id());
                terminal.status("Started", format_args!("{name}, process {id}"));
                self.relay = Relay::start(name, self.width, &mut child);
                SupervisedState::Running(child)
            }
            Err(error) => {
                terminal.error(format_args!("cannot start `{}`: {error}", self.name));
                SupervisedState::Ended { success: false }
            }
        };
    }

    fn ended(&mut self, status: ExitStatus, now: Instant, terminal: &mut TerminalOutput) {
        self.relay.finish(now + LAST_LINES);
        let (name, well) = (&self.name, status.success());
        if status.code() == Some(USAGE) && self.restarts.follow_failures() {
            terminal.error(format_args!(
                "`{name}` ended ({status}) and is not restarted: exit code {USAGE} means that its arguments, its surroundings or the \
                 composite are wrong, which a restart does not change; the reason is printed above"
            ));
            self.state = SupervisedState::Ended { success: false };
            return;
        }
        self.state = match self.restarts.next(well, now) {
            AfterExit::Restart(wait) => {
                let count = self.restarts.total;
                terminal.status(
                    "Restarting",
                    format_args!("{name}, restart {count}, after {status}"),
                );
                SupervisedState::Due(now + wait)
            }
            AfterExit::StayEnded => SupervisedState::Ended { success: well },
            AfterExit::GiveUp => {
                terminal.error(format_args!(
                    "`{name}` ended ({status}) after too many restarts"
                ));
                SupervisedState::Ended { success: false }
            }
        };
    }

    /// Sends SIGTERM to the process.
    fn terminate(&mut self) {
        match &self.state {
            SupervisedState::Running(child) => {
                let id = i32::try_from(child.id()).ok().and_then(Pid::from_raw);
                // the process can have ended just before
                let _ = id.map(|id| kill_process(id, Signal::TERM));
            }
            SupervisedState::Due(_) => self.state = SupervisedState::Ended { success: true },
            SupervisedState::Ended { .. } => {}
        }
    }

    fn is_running(&mut self) -> bool {
        match &mut self.state {
            SupervisedState::Running(child) => matches!(child.try_wait(), Ok(None)),
            SupervisedState::Due(_) | SupervisedState::Ended { .. } => false,
        }
    }

    /// Waits for the process to end, and kills it at `until`.
    fn wait_for_end(&mut self, until: Instant, terminal: &mut TerminalOutput) {
        let SupervisedState::Running(child) = &mut self.state else {
            return;
        };
        let status = loop {
            match child.try_wait() {
                Ok(Some(status)) => break Some(status),
                Ok(None) if Instant::now() < until => std::thread::sleep(LOOK),
                Ok(None) | Err(_) => {
                    terminal.error(format_args!(
                        "`{}` did not end in time and is killed",
                        self.name
                    ));
                    let _ = child.kill();
                    break child.wait().ok();
                }
            }
        };
        self.relay.finish(Instant::now() + LAST_LINES);
        let well = status.is_some_and(|status| status.success());
        self.state = SupervisedState::Ended { success: well };
    }
}

/// Decides when a process is restarted.
struct Restarts {
    rule: Option<Restart>,
    /// Restarts within the window, and their total number.
    recent: Vec<Instant>,
    total: u64,
}

/// Reaction to the end of a process.
#[derive(Debug, PartialEq)]
enum AfterExit {
    /// Restart after this time.
    Restart(Duration),
    /// No restart: the policy does not ask for one.
    StayEnded,
    /// No restart: there were too many.
    GiveUp,
}

impl Restarts {
    /// Returns whether a failure is followed by a restart at all.
    fn follow_failures(&self) -> bool {
        self.rule
            .as_ref()
            .is_some_and(|rule| rule.policy != RestartPolicy::Never)
    }

    fn new(rule: Option<Restart>) -> Self {
        Self {
            rule,
            recent: Vec::new(),
            total: 0,
        }
    }

    fn next(&mut self, success: bool, now: Instant) -> AfterExit {
        let Some(rule) = &self.rule else {
            return AfterExit::StayEnded;
        };
        let again = match rule.policy {
            RestartPolicy::Never => false,
            RestartPolicy::OnFailure => !success,
            RestartPolicy::Always => true,
        };
        if !again {
            return AfterExit::StayEnded;
        }
        let window = Duration::from_secs(rule.window_s);
        self.recent.retain(|at| now.duration_since(*at) < window);
        let count = self.recent.len();
        if count as u64 >= rule.max {
            return AfterExit::GiveUp;
        }
        self.recent.push(now);
        self.total += 1;
        let waits = &rule.backoff_ms;
        let wait = waits.get(count).or(waits.last());
        AfterExit::Restart(wait.map_or(BACKOFF, |wait| Duration::from_millis(*wait)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn restarts(policy: RestartPolicy) -> Restarts {
        Restarts::new(Some(Restart {
            policy,
            max: 2,
            window_s: 10,
            backoff_ms: vec![100, 300],
        }))
    }

    #[test]
    fn a_failure_is_followed_by_a_start_until_there_were_too_many() {
        let now = Instant::now();
        let at = |seconds| now + Duration::from_secs(seconds);
        let wait = |ms| AfterExit::Restart(Duration::from_millis(ms));
        let mut restarts = restarts(RestartPolicy::OnFailure);
        assert_eq!(restarts.next(true, now), AfterExit::StayEnded);
        assert_eq!(restarts.next(false, at(0)), wait(100));
        assert_eq!(restarts.next(false, at(1)), wait(300));
        assert_eq!(restarts.next(false, at(2)), AfterExit::GiveUp);
        // the first restart has left the window
        assert_eq!(restarts.next(false, at(10)), wait(300));
        assert_eq!(restarts.total, 3);
    }

    #[test]
    fn always_and_never_are_what_they_say() {
        let now = Instant::now();
        assert_eq!(
            restarts(RestartPolicy::Never).next(false, now),
            AfterExit::StayEnded
        );
        assert_eq!(Restarts::new(None).next(false, now), AfterExit::StayEnded);
        let again = restarts(RestartPolicy::Always).next(true, now);
        assert_eq!(again, AfterExit::Restart(Duration::from_millis(100)));
    }
}
