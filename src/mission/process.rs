//! Which part of a composite a mission runs, and the bus that joins it to the rest.

use std::sync::Arc;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use amqp::AmqpBus;
use assembly::plan::Broker;
use assembly::{Part, Plan};

use super::{Mission, MissionError};

/// How long to wait for a broker at the start; later on, as long as it takes.
const CONNECT: Duration = Duration::from_secs(10);

impl Mission {
    /// What of the plan runs here.
    pub(super) fn part(&self, plan: &Plan) -> Result<Part, MissionError> {
        let Some(wanted) = &self.process else {
            return Ok(match self.broker {
                None => Part::Whole,
                Some(_) => Part::WholeOverBus,
            });
        };
        let found = plan.processes.iter().find(|known| known.name == *wanted);
        match (found, &self.broker) {
            (None, _) => Err(MissionError::Process {
                wanted: wanted.clone(),
                known: plan.processes.iter().map(|it| it.name.clone()).collect(),
            }),
            (Some(_), None) if plan.processes.len() > 1 => Err(MissionError::NeedsBroker {
                process: wanted.clone(),
            }),
            (Some(_), None) => Ok(Part::Whole),
            (Some(process), Some(_)) => Ok(Part::of(process)),
        }
    }

    /// The broker that the composite names, if it does. What is wrong with the composite the run tells.
    ///
    /// # Errors
    /// It names several.
    pub fn named_broker(&self) -> Result<Option<Broker>, String> {
        let opened = self.open();
        let plan = match opened.report.has_errors() {
            true => None,
            false => opened.plan(self.profile.as_deref()),
        };
        let Some(plan) = plan.filter(|plan| plan.missing.is_empty()) else {
            return Ok(None);
        };
        let named = plan.broker().map_err(|names| {
            let names = names.join(", ");
            format!("the composite names several brokers ({names}), and a process speaks to one: say which with `--bus`")
        })?;
        Ok(named.cloned())
    }

    /// The bus over the broker, once it is there.
    pub(super) fn connect(&self, plan: &Plan) -> Result<Option<Arc<AmqpBus>>, MissionError> {
        let Some(settings) = &self.broker else {
            return Ok(None);
        };
        let mut settings = settings.clone();
        settings.robot.get_or_insert_with(|| plan.name.clone());
        if let Some(process) = &self.process {
            settings.process.clone_from(process);
        }
        let bus =
            AmqpBus::connect(settings, CONNECT).map_err(|reason| self.broker_error(reason))?;
        Ok(Some(Arc::new(bus)))
    }

    pub(super) fn broker_error(&self, reason: bus::BusError) -> MissionError {
        let place = self.broker.as_ref().map(amqp::Settings::place);
        MissionError::Broker {
            place: place.unwrap_or_default(),
            reason,
        }
    }
}

/// Which life of the process this is: it grows with every start, and no two processes share one.
pub(super) fn incarnation() -> u64 {
    let now = SystemTime::now().duration_since(UNIX_EPOCH);
    u64::try_from(now.unwrap_or_default().as_nanos()).unwrap_or(u64::MAX)
}
