//! Replacement for RabbitMQ in a build without the feature `amqp`: there are no settings, so no connection is ever
//! made.

use std::sync::Arc;

use asmotion_bus::{Bus, BusError};

use crate::feature::{Amqp, LeftOut};
use crate::transport::BrokerAccess;

/// Settings of a broker: this build has none.
#[derive(Clone, Debug)]
pub enum AmqpSettings {}

/// Refuses: this build cannot connect to `address`.
pub fn settings(address: &str, _: &BrokerAccess) -> Result<AmqpSettings, String> {
    Err(format!("`--bus {address}`: {}", LeftOut::new::<Amqp>()))
}

/// Refuses: this build cannot connect to the broker that a composite names.
pub fn named(broker: &asmotion_plan::Broker, _: &BrokerAccess) -> Result<AmqpSettings, String> {
    let (name, left_out) = (&broker.name, LeftOut::new::<Amqp>());
    Err(format!(
        "broker `{name}` of the composite: {left_out}\n  `--bus local` runs without a broker"
    ))
}

/// Never called: there are no settings.
pub fn prepare(settings: &mut AmqpSettings, _: Option<String>, _: bool) {
    match *settings {}
}

/// Never called: there are no settings.
pub fn login_warning(settings: &AmqpSettings) -> Option<String> {
    match *settings {}
}

/// Never called: there are no settings.
pub fn robot(settings: &AmqpSettings) -> Option<&str> {
    match *settings {}
}

/// Never called: there are no settings.
#[cfg(feature = "ros")]
pub fn place(settings: &AmqpSettings) -> String {
    match *settings {}
}

/// Never called: there are no settings.
pub fn connect(
    settings: &AmqpSettings,
    _: &str,
    _: Option<&str>,
    _: std::time::Duration,
) -> (String, Result<Arc<dyn Bus>, BusError>) {
    match *settings {}
}

/// Never called: there are no settings.
pub fn watch(settings: &AmqpSettings) -> (String, Result<asmotion_remote::Remote, String>) {
    match *settings {}
}
