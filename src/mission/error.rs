//! Why a mission cannot begin.

use asmotion_lang::diagnostics::similar;
use asmotion_lang::simulate::Unawaited;
use asmotion_lang::{Report, Sources};
use std::fmt;

/// Why a mission cannot begin.
#[derive(Debug)]
pub enum MissionError {
    /// The composite has errors, or there is no such profile.
    Composite {
        /// The texts.
        sources: Sources,
        /// The findings.
        report: Report,
        /// Whether a value that was set from outside is among what is wrong.
        outside: bool,
    },
    /// The profile does not exist, or one must be chosen.
    Profile {
        /// What was asked for.
        wanted: Option<String>,
        /// What there is.
        known: Vec<String>,
    },
    /// No component of this name has a property to set.
    Component {
        /// What was written.
        name: String,
        /// A component with a name like it.
        similar: Option<String>,
    },
    /// No step can bring what the run is to end with.
    NeverEnds {
        /// As in `mode=ARRIVED`.
        wanted: String,
        /// Why, by specification.
        reasons: Vec<(String, Unawaited)>,
    },
    /// The composite is not deployed to this process.
    Process {
        /// What was asked for.
        wanted: String,
        /// What there is.
        known: Vec<String>,
    },
    /// One process of several cannot do without a broker.
    NeedsBroker {
        /// The process.
        process: String,
    },
    /// The broker is not there, or does not let us.
    Broker {
        /// Where it is.
        place: String,
        /// Why.
        reason: asmotion_bus::BusError,
    },
    /// A gateway cannot open.
    Gateway {
        /// The gateway.
        name: String,
        /// Why.
        reason: asmotion_gateway::GatewayError,
    },
    /// It cannot be put together.
    Launch(String),
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
            Self::Profile { known, .. } if known.is_empty() => {
                to.write_str("the composite has no profiles: leave out `--profile`")
            }
            Self::Profile {
                wanted: Some(wanted),
                known,
            } => {
                let similar = similar(wanted, known).cloned();
                let (meant, known) = (meant(&similar), known.join(", "));
                write!(to, "there is no profile `{wanted}`, but {known}{meant}")
            }
            Self::Profile {
                wanted: None,
                known,
            } => {
                write!(
                    to,
                    "choose a profile with `--profile`: {}",
                    known.join(", ")
                )
            }
            Self::Component { name, similar } => {
                write!(to, "there is no component `{name}`{}", meant(similar))
            }
            Self::NeverEnds { wanted, reasons } if reasons.is_empty() => write!(
                to,
                "the run cannot end with `{wanted}`: no component runs a specification"
            ),
            Self::NeverEnds { wanted, reasons } => {
                write!(to, "the run cannot end with `{wanted}`")?;
                reasons.iter().try_for_each(|(specification, reason)| {
                    write!(to, "\n  {specification}: {reason}")
                })
            }
            Self::Process { wanted, known } => {
                let similar = similar(wanted, known).cloned();
                let (meant, known) = (meant(&similar), known.join(", "));
                write!(to, "there is no process `{wanted}`, but {known}{meant}")
            }
            Self::NeedsBroker { process } => write!(
                to,
                "`{process}` is one of several processes, which meet on a broker: add \
                 `--bus amqp://user@host:port/vhost`, or leave out `--process` to run all in one"
            ),
            Self::Broker { place, reason } => write!(
                to,
                "the broker at {place}: {reason}\n  `asmotion doctor` says how to mend it; `--bus local` runs \
                 without one"
            ),
            Self::Gateway { name, reason } => write!(
                to,
                "the gateway `{name}`: {reason}\n  `--http {name}=127.0.0.1:0` takes a free port; `--http off` runs \
                 without one"
            ),
            Self::Launch(reason) => to.write_str(reason),
        }
    }
}

impl std::error::Error for MissionError {}

fn meant(similar: &Option<String>) -> String {
    similar
        .as_ref()
        .map_or_else(String::new, |name| format!("; did you mean `{name}`?"))
}
