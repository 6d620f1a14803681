//! `asmotion doctor`: diagnoses a broker.

use crate::broker::{BrokerArguments, BrokerSettings};
use crate::build::Build;
use crate::exit::Exit;
use crate::terminal::{BAD, GOOD, NOTE, TerminalOutput};
use asmotion_amqp::{AmqpBus, AmqpSettings};
use asmotion_bus::{
    Bus, BusError, CallFailure, LinkState, Notifier, Payload, PublishOptions, Request, SenderId,
};
use asmotion_datum::{Datum, Message};
use asmotion_remote::{PresentComponent, Remote, RobotPresence};
use asmotion_story::brief::brief;
use clap::Args;
use std::net::{TcpStream, ToSocketAddrs};
use std::num::NonZeroUsize;
use std::sync::Arc;
use std::time::Duration;

/// Diagnoses a broker and says how to repair it.
#[derive(Args)]
pub struct Doctor {
    #[command(flatten)]
    broker: BrokerArguments,
}

/// Time limit of each test.
const PATIENCE: Duration = Duration::from_secs(5);

/// Time in which every process publishes its presence twice.
const PRESENCE_WAIT: Duration = Duration::from_millis(2200);

/// Name of the topic and the service used by the tests.
const TRIED: &str = "asmotion.doctor";

/// A defect of the broker, with its remedy.
struct Diagnosis {
    problem: String,
    remedy: String,
}

impl Diagnosis {
    fn new(what: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self {
            problem: what.into(),
            remedy: remedy.into(),
        }
    }
}

impl Doctor {
    /// Tests what a system needs, step by step, until a step fails.
    pub fn run(self, build: &Build, terminal: &mut TerminalOutput) -> Exit {
        let settings = match self.broker.settings(build) {
            Ok(BrokerSettings::Amqp(settings)) => settings,
            Ok(BrokerSettings::Added(_)) => {
                terminal.error("`asmotion doctor` examines RabbitMQ only");
                return Exit::Usage;
            }
            Err(problem) => {
                terminal.error(problem);
                return Exit::Usage;
            }
        };
        match check_all(&settings, terminal) {
            Ok(()) => Exit::Ok,
            Err(diagnosis) => {
                terminal.result(format_args!("{BAD}bad{BAD:#}  {}", diagnosis.problem));
                for line in diagnosis.remedy.lines() {
                    terminal.result(format_args!("       {line}"));
                }
                Exit::Findings
            }
        }
    }
}

fn check_all(settings: &AmqpSettings, terminal: &mut TerminalOutput) -> Result<(), Diagnosis> {
    let mut well = |what: String| terminal.result(format_args!("{GOOD}ok{GOOD:#}   {what}"));
    check_connection(settings)?;
    well(format!("{}:{} is reachable", settings.host, settings.port));
    let bus = Arc::new(log_in(settings)?);
    well(format!(
        "user `{}` has access to the virtual host `{}`",
        settings.credentials.user(),
        settings.vhost
    ));
    if let Some(warning) = settings.login_warning() {
        terminal.result(format_args!("{NOTE}note{NOTE:#} {warning}"));
    }
    let mut well = |what: String| terminal.result(format_args!("{GOOD}ok{GOOD:#}   {what}"));
    check_alarms(&bus, settings)?;
    well("the broker accepts messages: no alarm".to_owned());
    check_topic(&bus, settings)?;
    well("a published message arrives".to_owned());
    check_service(&bus, settings)?;
    well("an offered service can be called".to_owned());
    match check_clocks(&bus, settings)? {
        0 => well("no process is running, so no clocks were compared".to_owned()),
        1 => well("the clock of 1 process agrees with that of this machine".to_owned()),
        count => well(format!(
            "the clocks of {count} processes agree with that of this machine"
        )),
    }
    for line in losses(&bus, settings)? {
        terminal.result(format_args!("{NOTE}note{NOTE:#} {line}"));
    }
    Ok(())
}

/// Tests whether a TCP connection can be opened.
fn check_connection(settings: &AmqpSettings) -> Result<(), Diagnosis> {
    let (host, port) = (&settings.host, settings.port);
    let addresses = (host.as_str(), port).to_socket_addrs().map_err(|error| {
        Diagnosis::new(
            format!("cannot resolve `{host}`: {error}"),
            "check the name, or use the IP address",
        )
    })?;
    let mut last = "it has no address".to_owned();
    for address in addresses {
        match TcpStream::connect_timeout(&address, PATIENCE) {
            Ok(_) => return Ok(()),
            Err(error) => last = error.to_string(),
        }
    }
    Err(Diagnosis::new(
        format!("cannot reach {host}:{port}: {last}"),
        "on that machine, `systemctl status rabbitmq-server` and `rabbitmq-diagnostics listeners`\nshow the port (default: 5672) and the addresses; check for a firewall in between",
    ))
}

/// Tests whether the broker accepts the credentials and the virtual host.
fn log_in(settings: &AmqpSettings) -> Result<AmqpBus, Diagnosis> {
    AmqpBus::connect(settings.clone(), PATIENCE).map_err(|error| {
        let (user, vhost) = (settings.credentials.user(), &settings.vhost);
        let problem = error.to_string();
        let text = problem.to_lowercase();
        let remedy = if text.contains("login") || text.contains("authentication") {
            format!(
                "invalid user or password: `rabbitmqctl list_users` lists the users,\n`rabbitmqctl change_password {user} …` sets a password; `guest` can connect only from the same machine"
            )
        } else if text.contains("precondition_failed") {
            let exchange = &settings.exchange;
            format!(
                "another program has declared the exchange with another type: delete it in RabbitMQ's management interface or with\n`rabbitmqadmin -V {vhost} delete exchange name={exchange}`, or choose a virtual host of its own; it is declared again at once"
            )
        } else if text.contains("no exchange") {
            format!("the user may not declare it: `{}`", permission_command(settings))
        } else if text.contains("vhost") && text.contains("not found") {
            format!("`rabbitmqctl add_vhost {vhost}`, then `{}`", permission_command(settings))
        } else if text.contains("vhost") {
            format!("the user has no access: `{}`", permission_command(settings))
        } else if text.contains("certificate") || text.contains("tls") {
            "`--ca FILE` names the authority that signed the broker's certificate; `--certificate` and `--key` identify this client"
                .to_owned()
        } else {
            "another program listens there: check the port, and see the broker's log"
                .to_owned()
        };
        Diagnosis::new(problem, remedy)
    })
}

/// The command that grants the user all permissions in the virtual host.
fn permission_command(settings: &AmqpSettings) -> String {
    let (user, vhost) = (settings.credentials.user(), &settings.vhost);
    format!("rabbitmqctl set_permissions -p {vhost} {user} '.*' '.*' '.*'")
}

/// Tests whether the broker accepts messages.
fn check_alarms(bus: &AmqpBus, settings: &AmqpSettings) -> Result<(), Diagnosis> {
    // a memory or disk alarm shows as a probe without a reply
    std::thread::sleep(settings.timing.silence_timeout + 2 * settings.timing.pulse);
    match bus.health().link {
        LinkState::Up => Ok(()),
        LinkState::Blocked { reason } | LinkState::Down { reason } => Err(Diagnosis::new(
            format!("the broker accepts no messages: {reason}"),
            "it is short of memory or disk: `rabbitmq-diagnostics alarms` shows which;\nfree some, raise `vm_memory_high_watermark`, or lower `disk_free_limit` in rabbitmq.conf",
        )),
    }
}

/// Tests whether a message published on a topic arrives.
fn check_topic(bus: &AmqpBus, settings: &AmqpSettings) -> Result<(), Diagnosis> {
    let read = asmotion_remote::listen(bus, TRIED)
        .map_err(|error| missing_permission("cannot read a topic", &error.to_string(), settings))?;
    let sending = PublishOptions::events(NonZeroUsize::MIN);
    let origin = SenderId::new("asmotion-doctor", 0);
    let message = Payload::of(Datum::text("hello"));
    let mut publisher = bus
        .publisher(TRIED, &origin, Datum::schema(), sending)
        .map_err(|error| {
            missing_permission("cannot write a topic", &error.to_string(), settings)
        })?;
    let published = publisher.publish(0, message).is_ok();
    if published && read.next_within(PATIENCE).is_some() {
        return Ok(());
    }
    // an alarm can become visible only now
    check_alarms(bus, settings)?;
    let what = "cannot write a topic";
    Err(missing_permission(
        what,
        "the published message did not arrive",
        settings,
    ))
}

/// Tests whether a service can be offered and called.
fn check_service(bus: &AmqpBus, settings: &AmqpSettings) -> Result<(), Diagnosis> {
    let ill = |what: String| missing_permission("cannot offer or call a service", &what, settings);
    let serving = match bus.serve(TRIED, 1, Arc::new(Notifier::new())) {
        Ok(serving) => serving,
        // another `asmotion doctor` is running
        Err(BusError::Served { .. }) => return Ok(()),
        Err(error) => return Err(ill(error.to_string())),
    };
    let request = Request::new(
        SenderId::new("asmotion-doctor", 0),
        Payload::of(Datum::Null),
        PATIENCE,
    );
    let pending = bus
        .call(TRIED, request, Arc::new(Notifier::new()))
        .map_err(|error| ill(error.to_string()))?;
    if let Some(call) = serving.next_within(PATIENCE) {
        call.reply(Ok(Payload::of(Datum::Null)));
    }
    pending
        .wait()
        .map(drop)
        .map_err(|failure: CallFailure| ill(failure.to_string()))
}

/// Compares the clocks of the running processes with that of this machine. Returns the number of processes.
fn check_clocks(bus: &AmqpBus, settings: &AmqpSettings) -> Result<usize, Diagnosis> {
    let offsets = asmotion_remote::clock_offsets(bus, PRESENCE_WAIT)
        .map_err(|error| missing_permission("cannot read a topic", &error.to_string(), settings))?;
    let wrong = offsets
        .iter()
        .filter(|it| it.is_beyond(asmotion_remote::CLOCK_TOLERANCE));
    let wrong: Vec<String> = wrong.map(ToString::to_string).collect();
    if wrong.is_empty() {
        return Ok(offsets.len());
    }
    Err(Diagnosis::new(
        wrong.join("; "),
        asmotion_remote::CLOCK_REMEDY,
    ))
}

/// The losses of all running components, and what passes their bridges to ROS.
fn losses(bus: &Arc<AmqpBus>, settings: &AmqpSettings) -> Result<Vec<String>, Diagnosis> {
    let bus: Arc<dyn Bus> = Arc::<AmqpBus>::clone(bus);
    let remote = Remote::over_bus(bus, None)
        .map_err(|error| missing_permission("cannot read a topic", &error.to_string(), settings))?;
    let mut lines = Vec::new();
    for RobotPresence { robot, presence } in remote.processes() {
        for component in &presence.components {
            let PresentComponent {
                name,
                dropped,
                misfits,
                inspection,
                ..
            } = component;
            let passages = inspection.iter();
            let passages = passages.filter(|(_, it)| it.get("per_second").is_some());
            let process = &presence.process;
            lines.extend(passages.map(|(passage, flow)| {
                format!(
                    "`{name}` of process `{process}` of {robot}: {passage} {}",
                    brief(flow)
                )
            }));
            if dropped + misfits > 0 {
                lines.push(format!(
                    "`{name}` of process `{process}` of {robot} has lost messages: {dropped} dropped, {misfits} unsuitable"
                ));
            }
        }
    }
    Ok(lines)
}

fn missing_permission(problem: &str, reason: &str, settings: &AmqpSettings) -> Diagnosis {
    let (user, vhost) = (settings.credentials.user(), &settings.vhost);
    Diagnosis::new(
        format!("{problem}: {reason}"),
        format!(
            "`rabbitmqctl list_permissions -p {vhost}` shows the permissions of `{user}`;\n`{}` allows everything, docs/wire.md lists what is needed",
            permission_command(settings)
        ),
    )
}
