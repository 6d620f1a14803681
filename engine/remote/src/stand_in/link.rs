//! The link to the robot of a stand-in: a thread that follows the robot's presence and passes on samples and commands.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use asmotion_bus::{
    Bus, BusError, CallFailure, Envelope, Notifier, Overflow, Pattern, PendingCall, QueuePolicy,
    Subscription,
};
use asmotion_component::declaration::Declaration;
use asmotion_component::{Losses, State};
use asmotion_datum::Datum;

use super::announced::RobotComponent;
use crate::contact::watch_topic;
use crate::order::OrderKind;
use crate::presence::{PresentComponent, RobotPresence, key, presence_topic};
use crate::remote::Remote;
use crate::roster::{ComponentLocation, SILENT};

/// Time within which every running process has published its presence; timeout of one-way calls.
pub(super) const LISTEN: Duration = Duration::from_millis(1500);
/// Period at which leases of outputs are renewed.
const AGAIN: Duration = Duration::from_secs(5);
/// Greatest number of samples and of commands that wait; older ones are dropped.
const WAITING: usize = 256;

/// The component's end of the link. Dropping it ends the thread.
pub(super) struct Link {
    shared: Arc<LinkState>,
    thread: Option<JoinHandle<()>>,
}

/// State that the component and the thread share.
struct LinkState {
    is_ending: AtomicBool,
    /// Wakes the thread.
    notifier: Arc<Notifier>,
    /// Requests a cycle of the component.
    waker: Arc<dyn Fn() + Send + Sync>,
    /// Samples of the robot by output, filled by the thread.
    samples: Mutex<VecDeque<(Arc<str>, Datum)>>,
    /// Commands by input, filled by the component.
    commands: Mutex<VecDeque<(String, Datum)>>,
    notices: Mutex<Vec<String>>,
    /// Why the robot cannot be reached; `None` while it can.
    absence: Mutex<Option<&'static str>>,
    /// The reason that the component must fail.
    fault: Mutex<Option<String>>,
    dropped: AtomicU64,
    misfits: AtomicU64,
}

impl Link {
    /// Starts the thread.
    ///
    /// # Errors
    /// The reason that the bus refuses the subscriptions, or the operating system the thread.
    pub(super) fn start(
        remote: Remote,
        robot_component: RobotComponent,
        waker: Arc<dyn Fn() + Send + Sync>,
    ) -> Result<Self, String> {
        let shared = Arc::new(LinkState {
            is_ending: AtomicBool::new(false),
            notifier: Arc::default(),
            waker,
            samples: Mutex::default(),
            commands: Mutex::default(),
            notices: Mutex::default(),
            absence: Mutex::new(Some("has not been found yet")),
            fault: Mutex::default(),
            dropped: AtomicU64::new(0),
            misfits: AtomicU64::new(0),
        });
        let name = format!("robot {}", robot_component.robot);
        let end = RobotEnd::new(remote, robot_component, Arc::clone(&shared))
            .map_err(|error| error.to_string())?;
        let thread = std::thread::Builder::new().name(name);
        let thread = thread
            .spawn(move || end.run())
            .map_err(|it| it.to_string())?;
        Ok(Self {
            shared,
            thread: Some(thread),
        })
    }

    /// Takes the samples that have arrived.
    pub(super) fn samples(&self) -> VecDeque<(Arc<str>, Datum)> {
        std::mem::take(&mut *lock(&self.shared.samples))
    }

    /// Takes the texts for the person who runs the system.
    pub(super) fn notices(&self) -> Vec<String> {
        std::mem::take(&mut *lock(&self.shared.notices))
    }

    /// Why the robot cannot be reached, as the rest of a sentence about it; `None` while it can.
    pub(super) fn absence(&self) -> Option<&'static str> {
        *lock(&self.shared.absence)
    }

    /// Sends a command to an input of the robot.
    pub(super) fn command(&self, input: &str, command: Datum) {
        let mut commands = lock(&self.shared.commands);
        if commands.len() == WAITING {
            commands.pop_front();
            self.shared.count_dropped();
        }
        commands.push_back((input.to_owned(), command));
        drop(commands);
        self.shared.notifier.notify();
    }

    /// The reason that the robot can no longer be used.
    pub(super) fn fault(&self) -> Option<String> {
        lock(&self.shared.fault).clone()
    }

    /// Counts a sample of another type.
    pub(super) fn count_misfit(&self) {
        self.shared.misfits.fetch_add(1, Ordering::Relaxed);
    }

    /// Numbers of lost messages so far.
    pub(super) fn losses(&self) -> Losses {
        Losses {
            dropped: self.shared.dropped.load(Ordering::Relaxed),
            misfits: self.shared.misfits.load(Ordering::Relaxed),
        }
    }
}

impl Drop for Link {
    fn drop(&mut self) {
        self.shared.is_ending.store(true, Ordering::Relaxed);
        self.shared.notifier.notify();
        if let Some(thread) = self.thread.take() {
            // a thread that has panicked has nothing left to end
            let _ = thread.join();
        }
    }
}

impl LinkState {
    fn count_dropped(&self) {
        self.dropped.fetch_add(1, Ordering::Relaxed);
    }

    fn notice(&self, text: String) {
        lock(&self.notices).push(text);
        (self.waker)();
    }

    /// Sets whether the robot can be reached, and why not.
    fn set_absence(&self, absence: Option<&'static str>) {
        let before = std::mem::replace(&mut *lock(&self.absence), absence);
        if before != absence {
            (self.waker)();
        }
    }

    fn fail(&self, reason: String) {
        *lock(&self.fault) = Some(reason);
        (self.waker)();
    }
}

fn lock<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The thread's end of the link.
struct RobotEnd {
    remote: Remote,
    robot_component: RobotComponent,
    shared: Arc<LinkState>,
    presences: Subscription,
    /// The outputs that the system uses, with their samples.
    outputs: Vec<(Arc<str>, Subscription)>,
    /// The process that runs the component; `None` while there is none.
    process: Option<LinkedProcess>,
    /// Another process with the same component, which has been reported.
    rival: Option<String>,
    /// Commands of which the broker has not said whether the robot's queue has them.
    sent: Vec<PendingCall>,
}

/// The process of the robot that runs the component.
struct LinkedProcess {
    location: ComponentLocation,
    incarnation: u64,
    heard_at: Instant,
    renewed_at: Instant,
}

impl RobotEnd {
    fn new(
        remote: Remote,
        robot_component: RobotComponent,
        shared: Arc<LinkState>,
    ) -> Result<Self, BusError> {
        let bus = Arc::clone(remote.bus());
        let RobotComponent {
            robot, component, ..
        } = &robot_component;
        let presences = subscribe(&*bus, &key(robot, &presence_topic("*")), &shared)?;
        let outputs = robot_component.declaration.outputs.iter();
        let outputs = outputs.filter(|it| robot_component.used.contains(&it.name));
        let outputs = outputs.map(|output| {
            let topic = watch_topic(&format!("{component}.{}", output.name));
            let samples = subscribe(&*bus, &key(robot, &topic), &shared)?;
            Ok((output.name.as_str().into(), samples))
        });
        Ok(Self {
            outputs: outputs.collect::<Result<_, BusError>>()?,
            remote,
            robot_component,
            shared,
            presences,
            process: None,
            rival: None,
            sent: Vec::new(),
        })
    }

    fn run(mut self) {
        while !self.shared.is_ending.load(Ordering::Relaxed) {
            self.follow_presence();
            self.renew_leases();
            self.take_samples();
            self.send_commands();
            self.shared.notifier.wait(Duration::from_millis(500));
        }
        // the last commands of a system that stops
        self.send_commands();
    }

    /// Reads the presence of the robot's processes.
    fn follow_presence(&mut self) {
        while let Some(envelope) = self.presences.try_next() {
            let Some(RobotPresence { presence, .. }) = RobotPresence::of(&envelope) else {
                continue;
            };
            let mut components = presence.components.iter();
            let name = &self.robot_component.component;
            let Some(present) = components.find(|it| it.name == *name) else {
                continue;
            };
            self.follow_process(&envelope, &presence.process, presence.leaves, present);
        }
        let heard_at = self.process.as_ref().map(|it| it.heard_at);
        if heard_at.is_some_and(|at| at.elapsed() > SILENT) {
            self.lose("is silent");
        }
    }

    /// Reads the presence of a process that has the component.
    fn follow_process(
        &mut self,
        envelope: &Envelope,
        process: &str,
        leaves: bool,
        present: &PresentComponent,
    ) {
        match &mut self.process {
            Some(linked) if linked.location.process == process => {
                if envelope.incarnation < linked.incarnation {
                    return;
                }
                if leaves {
                    return self.lose("has left");
                }
                if linked.incarnation == envelope.incarnation {
                    linked.heard_at = Instant::now();
                    return self.shared.set_absence(absence(present));
                }
            }
            Some(linked) => {
                if !leaves && self.rival.as_deref() != Some(process) {
                    let RobotComponent {
                        robot, component, ..
                    } = &self.robot_component;
                    let first = &linked.location.process;
                    self.shared.notice(format!(
                        "the processes `{first}` and `{process}` of robot `{robot}` both have a component `{component}`; \
                         samples and commands stay with `{first}`"
                    ));
                    self.rival = Some(process.to_owned());
                }
                return;
            }
            None if leaves => return,
            None => {}
        }
        self.link_to(envelope.incarnation, process, present);
    }

    /// Uses the component of a process from now on, if it has the interface that the system was started with.
    fn link_to(&mut self, incarnation: u64, process: &str, present: &PresentComponent) {
        let location = ComponentLocation {
            robot: self.robot_component.robot.clone(),
            process: process.to_owned(),
            present: present.clone(),
        };
        let described = self.remote.order(&location, OrderKind::Describe);
        // a process that does not answer is asked again after its next presence
        let Ok(Ok(declared)) = described.map(|it| it.to::<Declaration>()) else {
            return;
        };
        if let Err(difference) = self.robot_component.check(&declared) {
            self.process = None;
            self.shared.set_absence(Some("has another interface"));
            return self.shared.fail(difference);
        }
        let now = Instant::now();
        self.process = Some(LinkedProcess {
            location,
            incarnation,
            heard_at: now,
            renewed_at: now,
        });
        self.shared.set_absence(absence(present));
        self.watch();
    }

    /// Has the robot publish the outputs that the system uses.
    fn watch(&self) {
        let Some(process) = &self.process else { return };
        for (output, _) in &self.outputs {
            let order = OrderKind::Watch(output.to_string());
            // an order that is lost is repeated with the next renewal
            let _ = self.remote.send_order(&process.location, order);
        }
    }

    fn renew_leases(&mut self) {
        if let Some(process) = &mut self.process
            && process.renewed_at.elapsed() >= AGAIN
        {
            process.renewed_at = Instant::now();
            self.watch();
        }
    }

    fn lose(&mut self, how: &'static str) {
        self.process = None;
        self.rival = None;
        self.shared.set_absence(Some(how));
        let RobotComponent {
            robot, component, ..
        } = &self.robot_component;
        self.shared.notice(format!(
            "`{component}` of robot `{robot}` {how}: commands are dropped until it is back"
        ));
    }

    fn take_samples(&self) {
        let mut waiting = lock(&self.shared.samples);
        let mut has_new = false;
        for (output, samples) in &self.outputs {
            while let Some(envelope) = samples.try_next() {
                let Ok(sample) = envelope.payload.to_datum() else {
                    self.shared.misfits.fetch_add(1, Ordering::Relaxed);
                    continue;
                };
                if waiting.len() == WAITING {
                    waiting.pop_front();
                    self.shared.count_dropped();
                }
                waiting.push_back((Arc::clone(output), sample));
                has_new = true;
            }
        }
        drop(waiting);
        if has_new {
            (self.shared.waker)();
        }
    }

    /// Sends the commands that wait. A command is never kept for a robot that is away: it would be stale when the robot is
    /// back.
    fn send_commands(&mut self) {
        let commands = std::mem::take(&mut *lock(&self.shared.commands));
        for (input, command) in commands {
            let sent = self.process.as_ref().and_then(|process| {
                let order = OrderKind::Write(input, command);
                let notifier = Arc::clone(&self.shared.notifier);
                let sent = self
                    .remote
                    .send_within(&process.location, order, SILENT, notifier);
                sent.ok()
            });
            match sent {
                Some(sent) => self.sent.push(sent),
                None => self.count_undelivered(),
            }
        }
        self.check_deliveries();
    }

    /// Counts the commands that the robot's queue has not received. If there is no such queue, the robot is away before it has
    /// been silent for long.
    fn check_deliveries(&mut self) {
        let mut has_no_queue = false;
        for sent in std::mem::take(&mut self.sent) {
            match sent.try_take() {
                None => self.sent.push(sent),
                Some(Ok(_)) => {}
                Some(Err(failure)) => {
                    has_no_queue |= matches!(failure, CallFailure::Unavailable);
                    self.count_undelivered();
                }
            }
        }
        if has_no_queue && self.process.is_some() {
            self.lose("takes no commands any more");
        }
    }

    fn count_undelivered(&self) {
        self.shared.count_dropped();
        (self.shared.waker)();
    }
}

/// Why a component that has been heard of takes no commands; `None` if it does.
fn absence(present: &PresentComponent) -> Option<&'static str> {
    let is_in = |state: State| present.state == state.to_string();
    let stopped = [State::PreOperational, State::Stopped];
    let failed = [State::Exception, State::FatalError];
    if stopped.into_iter().any(is_in) {
        return Some("has stopped the component");
    }
    failed
        .into_iter()
        .any(is_in)
        .then_some("has the component in a failed state")
}

/// Subscribes to the topics that match a pattern, for the thread of the link.
fn subscribe(bus: &dyn Bus, pattern: &str, shared: &LinkState) -> Result<Subscription, BusError> {
    let queue = QueuePolicy::All {
        size: WAITING,
        overflow: Overflow::DropOldest,
    };
    let notifier = Arc::clone(&shared.notifier);
    bus.subscribe("stand-in", &Pattern::new(pattern), queue, notifier)
}
