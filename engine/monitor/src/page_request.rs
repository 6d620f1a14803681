//! The messages of a tab.

use std::collections::BTreeMap;

use asmotion_datum::Datum;
use asmotion_remote::OrderKind;
use serde::Deserialize;

use crate::log_entry::LogFilter;

/// A message of a tab, in JSON.
#[derive(Debug, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub(crate) enum PageRequest {
    /// Replaces the subscriptions.
    Subscribe {
        /// `components`, `outputs`, `steps`, `log`, or an output `Component.port`, whose newest sample is sent.
        streams: Vec<String>,
        /// Outputs, `Component.port`, of which every sample is sent, in batches.
        #[serde(default)]
        every: Vec<String>,
        /// The part of the log that is sent; all of it by default.
        #[serde(default)]
        log: Option<LogFilter>,
        /// Limit on frames per second.
        max_hz: f64,
    },
    /// Asks for a moment of a run that is over.
    Seek {
        /// Time of the run, in seconds.
        t: f64,
        /// Time around it that the tab shows, in seconds.
        span: f64,
        /// Whether the tab needs the steps and log entries around it.
        window: bool,
        /// The part of the log that the tab needs; all of it by default.
        #[serde(default)]
        log: Option<LogFilter>,
        /// Numbers of the samples that the tab has, by output.
        #[serde(default)]
        has: BTreeMap<String, u64>,
    },
    /// Asks for the guards on the way to the updates of a step.
    Guards {
        /// Name of the component.
        component: String,
        /// Number of the step.
        number: u64,
        /// Time of the step, in seconds of the run.
        t: f64,
    },
    /// The tab has processed a frame.
    Ack {
        /// Number of the frame.
        seq: u64,
    },
    /// Asks for permission to control the system.
    Arm {
        /// The token of the dashboard; not needed in a browser that has logged in.
        #[serde(default)]
        token: Option<String>,
        /// Whether to take the permission from another tab.
        #[serde(default)]
        take: bool,
    },
    /// Gives the permission back.
    Disarm,
    /// Requests an action of a component.
    Order {
        /// Number of the request, which the reply repeats.
        id: u64,
        /// Name of the component.
        component: String,
        /// The action.
        wish: OrderKind,
    },
    /// Publishes a message on a topic, for all its subscribers in this process.
    Publish {
        /// Number of the request, which the reply repeats.
        id: u64,
        /// Name of the topic.
        topic: String,
        /// The message.
        value: Datum,
    },
}
