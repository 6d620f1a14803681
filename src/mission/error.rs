//! Errors of starting a mission.

use asmotion_bus::BusError;
use asmotion_diagnostics::{or_did_you_mean, similar};
use asmotion_lang::simulate::AwaitError;
use asmotion_lang::{Report, Sources};
use std::fmt;
use std::path::Path;

use super::outside::OutsideSystem;
use crate::feature::LeftOut;
use crate::own_program::cargo_run;

/// Reasons why a mission cannot start.
#[derive(Debug)]
pub enum MissionError {
    /// The composite has errors.
    Composite {
        /// Texts that the report refers to.
        sources: Sources,
        /// Errors of the composite.
        report: Report,
        /// `true` if a value from the command line is among the causes.
        outside: bool,
    },
    /// The profile does not exist, or one must be chosen.
    Profile {
        /// Requested profile.
        requested: Option<String>,
        /// Existing profiles.
        available: Vec<String>,
    },
    /// There is no component of this name with properties.
    Component {
        /// Name on the command line.
        name: String,
        /// The most similar name of a component.
        similar: Option<String>,
    },
    /// No step can establish the end condition.
    NeverEnds {
        /// Condition, for example `mode=ARRIVED`.
        requested: String,
        /// Reason for each specification.
        reasons: Vec<(String, AwaitError)>,
    },
    /// The composite is not deployed to this process.
    Process {
        /// Requested process.
        requested: String,
        /// Existing processes.
        available: Vec<String>,
    },
    /// One process of several needs a broker.
    NeedsBroker {
        /// The process that was to run.
        process: String,
        /// Whether the environment variable ASMOTION_BUS is set, which a run does not read.
        has_variable: bool,
        /// Whether `asmotion up` was to start it, which starts all processes of the machine.
        is_supervised: bool,
    },
    /// The broker is unreachable or refuses the connection.
    Broker {
        /// Address of the broker.
        location: String,
        /// Error of the connection.
        reason: BusError,
    },
    /// A gateway cannot listen.
    Gateway {
        /// Name of the gateway in the composite.
        name: String,
        /// Error of listening.
        reason: String,
    },
    /// The composite has a gateway, and this build does not.
    WithoutGateway {
        /// Name of the gateway in the composite.
        name: String,
        /// Names the feature that adds gateways.
        reason: LeftOut,
    },
    /// A component is not in this build; the program of the composite's own project may contain it.
    NotInBuild {
        /// The component and its implementation, in words.
        reason: String,
        /// Path of the composite.
        composite: String,
    },
    /// The run needs a system outside that its clock and brokers do not reach.
    Outside(OutsideSystem),
    /// Environment variables that the composite uses are not set: their names.
    UnsetVariables(Vec<String>),
    /// The composite starts only if its properties are verified, and they are not: each finding.
    NotVerified(Vec<String>),
    /// The director refuses the plan.
    Director(Report),
    /// The system cannot be assembled.
    Launch(String),
}

impl MissionError {
    /// Returns whether the reason may be gone when the mission is started again: a broker that does not answer, or that has not
    /// noticed the end of an earlier run of the process.
    pub(crate) fn may_improve(&self) -> bool {
        matches!(
            self,
            Self::Broker {
                reason: BusError::Disconnected { .. } | BusError::Served { .. },
                ..
            }
        )
    }
}

impl fmt::Display for MissionError {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Composite {
                sources, report, ..
            } => to.write_str(&asmotion_lang::render_all(
                report,
                sources,
                asmotion_lang::Style::Plain,
            )),
            Self::Profile { available, .. } if available.is_empty() => {
                to.write_str("the composite has no profiles: leave the profile out")
            }
            Self::Profile {
                requested: Some(requested),
                available,
            } => {
                let suggestion = or_did_you_mean(similar(requested, available).map(String::as_str));
                let available = available.join(", ");
                write!(
                    to,
                    "unknown profile `{requested}`; the profiles are {available}{suggestion}"
                )
            }
            Self::Profile {
                requested: None,
                available,
            } => {
                write!(
                    to,
                    "select a profile (`--profile`, or `profile` in a mission): {}",
                    available.join(", ")
                )
            }
            Self::Component { name, similar } => {
                write!(
                    to,
                    "unknown component `{name}`{}",
                    or_did_you_mean(similar.as_deref())
                )
            }
            Self::NeverEnds { requested, reasons } if reasons.is_empty() => write!(
                to,
                "the run cannot end with `{requested}`: no component runs a specification"
            ),
            Self::NeverEnds { requested, reasons } => {
                write!(to, "the run cannot end with `{requested}`")?;
                reasons.iter().try_for_each(|(specification, reason)| {
                    write!(to, "\n  {specification}: {reason}")
                })
            }
            Self::Process {
                requested,
                available,
            } => {
                let suggestion = or_did_you_mean(similar(requested, available).map(String::as_str));
                let available = available.join(", ");
                write!(
                    to,
                    "unknown process `{requested}`; the processes are {available}{suggestion}"
                )
            }
            Self::NeedsBroker {
                process,
                has_variable,
                is_supervised,
            } => {
                let (address, hint) = if *has_variable {
                    let hint = ", which only the commands on a running system read by themselves";
                    ("$ASMOTION_BUS", hint)
                } else {
                    ("amqp://user@host:port/vhost", "")
                };
                let alone = if *is_supervised {
                    "run all of them in one with `asmotion run`"
                } else {
                    "remove `--process` to run all of them in one"
                };
                write!(
                    to,
                    "`{process}` is one of several processes, which communicate over a broker: add `--bus {address}`{hint}, or {alone}"
                )
            }
            Self::Broker {
                location,
                reason: reason @ BusError::Served { address },
            } => {
                let other = match address.strip_prefix("reconfigure.") {
                    Some(process) => {
                        format!("the process `{process}` of a robot of this name runs already")
                    }
                    None => "another process of a robot of this name provides it".to_owned(),
                };
                write!(
                    to,
                    "broker at {location}: {reason}: {other}\n  `asmotion component list` shows what runs; stop it, or give this robot another name with `--robot NAME`"
                )
            }
            Self::Broker { location, reason } => write!(
                to,
                "broker at {location}: {reason}\n  `asmotion doctor` shows how to fix it; `--bus local` runs without a broker"
            ),
            Self::Gateway { name, reason } => write!(
                to,
                "gateway `{name}`: {reason}\n  `--http {name}=127.0.0.1:0` selects a free port; `--http off` runs without a gateway"
            ),
            Self::WithoutGateway { name, reason } => write!(
                to,
                "gateway `{name}`: {reason}\n  `--http off` runs without a gateway"
            ),
            Self::Director(report) => {
                let mut findings = report.diagnostics.iter();
                findings.try_for_each(|finding| writeln!(to, "{}", finding.message))
            }
            Self::NotInBuild { reason, composite } => {
                to.write_str(reason)?;
                match cargo_run(Path::new(composite)) {
                    Some(program) => write!(
                        to,
                        "\n  the program of this project contains its own components: `{program} run {composite}`"
                    ),
                    None => Ok(()),
                }
            }
            Self::Outside(system) => write!(to, "{system}: {}", system.option()),
            Self::UnsetVariables(names) => {
                write!(to, "environment variables not set: {}", names.join(", "))
            }
            Self::NotVerified(findings) => write!(
                to,
                "the composite does not start, because a verification failed (`refuse_start_on_failure`): {}",
                findings.join("\n")
            ),
            Self::Launch(reason) => to.write_str(reason),
        }
    }
}

impl std::error::Error for MissionError {}
