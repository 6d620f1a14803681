//! Figures of the system in the text format of Prometheus.

use std::fmt::Write;
use std::time::Instant;

use asmotion_remote::{Presence, PresentComponent};

use crate::bus_link::LinkSummary;
use crate::feed::Feed;

/// Type of the text.
pub(crate) const CONTENT_TYPE: &str = "text/plain; version=0.0.4; charset=utf-8";

/// A metric of a component: name, type, description and value.
type ComponentMetric = (
    &'static str,
    &'static str,
    &'static str,
    fn(&PresentComponent) -> f64,
);

const COMPONENT_METRICS: &[ComponentMetric] = &[
    (
        "component_running",
        "gauge",
        "1 if the component is running, otherwise 0.",
        |it| f64::from(u8::from(it.state == "Running")),
    ),
    (
        "component_period_seconds",
        "gauge",
        "Period of the component; 0 without a period.",
        |it| it.period_ms as f64 / 1e3,
    ),
    (
        "component_rate_hertz",
        "gauge",
        "Cycles per second over the last second.",
        |it| it.rate_hz,
    ),
    ("component_cycles_total", "counter", "Cycles begun.", |it| {
        it.cycles as f64
    }),
    (
        "component_overruns_total",
        "counter",
        "Missed periods.",
        |it| it.overruns as f64,
    ),
    (
        "component_late_cycles_total",
        "counter",
        "Cycles that exceeded their deadline.",
        |it| it.late as f64,
    ),
    (
        "component_cycle_mean_seconds",
        "gauge",
        "Mean duration of a cycle; of a coordinator, of a step.",
        |it| it.cycle_mean_ms / 1e3,
    ),
    (
        "component_cycle_max_seconds",
        "gauge",
        "Duration of the longest cycle.",
        |it| it.cycle_max_ms / 1e3,
    ),
    (
        "component_dropped_messages_total",
        "counter",
        "Messages lost on the way to the component or dropped by it, and requests refused because a queue was full.",
        |it| it.dropped as f64,
    ),
    (
        "component_unsuitable_messages_total",
        "counter",
        "Messages ignored because of their content.",
        |it| it.misfits as f64,
    ),
];

/// Figures of the dashboard itself.
pub(crate) struct ConnectionFigures {
    /// Number of connected tabs.
    pub tabs: usize,
    /// Number of connected viewers such as Foxglove.
    pub viewers: usize,
    /// Number of messages that viewers could not follow.
    pub skipped: u64,
}

/// Writes all figures.
pub(crate) fn text(feed: &Feed, connections: &ConnectionFigures) -> String {
    let mut text = MetricText(String::new());
    let (presence, time, lost, steps) = {
        let state = feed.state();
        let steps: u64 = state.steps.count();
        (state.presence.clone(), state.time, state.lost, steps)
    };
    text.single(
        "run_time_seconds",
        "gauge",
        "Time of the run.",
        time.seconds(),
    );
    text.single(
        "reported_steps_total",
        "counter",
        "Steps of specifications that wrote something.",
        steps as f64,
    );
    text.single(
        "unobserved_events_total",
        "counter",
        "Events that the dashboard did not observe.",
        lost as f64,
    );
    text.single(
        "dashboard_tabs",
        "gauge",
        "Connected tabs.",
        connections.tabs as f64,
    );
    text.single(
        "dashboard_viewers",
        "gauge",
        "Connected viewers such as Foxglove.",
        connections.viewers as f64,
    );
    text.single(
        "dashboard_skipped_messages_total",
        "counter",
        "Messages that viewers did not receive, because newer ones replaced them.",
        connections.skipped as f64,
    );
    text.links(feed);
    if let Some(presence) = presence {
        text.components(&presence.presence);
    }
    text.outputs(feed);
    text.0
}

struct MetricText(String);

impl MetricText {
    fn head(&mut self, name: &str, kind: &str, help: &str) {
        // writing to a string does not fail
        let _ = writeln!(
            self.0,
            "# HELP asmotion_{name} {help}\n# TYPE asmotion_{name} {kind}"
        );
    }

    fn value(&mut self, name: &str, labels: &[(&str, &str)], value: f64) {
        let labels: Vec<String> = labels
            .iter()
            .map(|(label, value)| format!("{label}=\"{}\"", escaped(value)))
            .collect();
        let labels = if labels.is_empty() {
            String::new()
        } else {
            format!("{{{}}}", labels.join(","))
        };
        let _ = writeln!(self.0, "asmotion_{name}{labels} {value}");
    }

    fn single(&mut self, name: &str, kind: &str, help: &str, value: f64) {
        self.head(name, kind, help);
        self.value(name, &[], value);
    }

    fn links(&mut self, feed: &Feed) {
        let now = Instant::now();
        let links: Vec<LinkSummary<'_>> = feed.links().iter().map(|it| it.summary(now)).collect();
        self.head(
            "link_up",
            "gauge",
            "1 if messages flow over the connection to a broker in both directions, otherwise 0.",
        );
        for link in &links {
            let up = f64::from(u8::from(link.is_up()));
            self.value("link_up", &[("link", link.name)], up);
        }
        self.head(
            "link_state_seconds",
            "gauge",
            "Time since the connection to a broker was made, lost or blocked.",
        );
        for link in &links {
            self.value("link_state_seconds", &[("link", link.name)], link.for_s);
        }
    }

    fn components(&mut self, presence: &Presence) {
        for (name, kind, help, value) in COMPONENT_METRICS {
            self.head(name, kind, help);
            for component in &presence.components {
                self.value(name, &[("component", &component.name)], value(component));
            }
        }
    }

    fn outputs(&mut self, feed: &Feed) {
        let outputs = feed.outputs();
        let split = |name: &'_ str| {
            let (component, port) = name.rsplit_once('.').unwrap_or(("", name));
            (component.to_owned(), port.to_owned())
        };
        let mut metric =
            |name: &str,
             kind: &str,
             help: &str,
             value: &dyn Fn(&crate::output_slot::OutputSummary) -> Option<f64>| {
                self.head(name, kind, help);
                for output in &outputs {
                    let (component, port) = split(&output.name);
                    if let Some(value) = value(output) {
                        self.value(name, &[("component", &component), ("port", &port)], value);
                    }
                }
            };
        metric(
            "output_samples_total",
            "counter",
            "Samples written.",
            &|it| Some(it.count as f64),
        );
        metric(
            "output_rate_hertz",
            "gauge",
            "Samples per second of the run.",
            &|it| it.rate_hz,
        );
        metric(
            "output_age_seconds",
            "gauge",
            "Real time since the newest sample.",
            &|it| Some(it.age.as_secs_f64()),
        );
        metric(
            "output_stale",
            "gauge",
            "1 if an output with regular samples has fallen silent, otherwise 0.",
            &|it| Some(f64::from(u8::from(it.is_stale))),
        );
    }
}

fn escaped(label: &str) -> String {
    label
        .replace('\\', "\\\\")
        .replace('"', "\\\"")
        .replace('\n', "\\n")
}
