//! `asmotion topic hz`: measures the rate of a topic.

use super::unknown_topic;
use crate::exit::Exit;
use crate::terminal::TerminalOutput;
use asmotion_remote::Remote;
use clap::Args;
use std::time::{Duration, Instant};

#[derive(Args)]
pub struct Hz {
    /// Key of the topic, `navigation.odom`
    topic: String,

    /// Duration of the measurement in seconds
    #[arg(long = "for", value_name = "SECONDS", default_value_t = 5.0)]
    window: f64,
}

impl Hz {
    /// Counts messages. Receiving none is a finding.
    pub fn run(self, remote: &Remote, terminal: &mut TerminalOutput) -> Result<Exit, String> {
        let window = Duration::try_from_secs_f64(self.window).map_err(|error| error.to_string())?;
        let subscription = remote
            .listen(&self.topic)
            .map_err(|error| error.to_string())?;
        let until = Instant::now() + window;
        let mut arrivals = Vec::new();
        let next = || subscription.next_within(until.saturating_duration_since(Instant::now()));
        while next().is_some() {
            arrivals.push(Instant::now());
        }
        let gaps: Vec<f64> = arrivals
            .windows(2)
            .map(|pair| pair[1].duration_since(pair[0]).as_secs_f64() * 1e3)
            .collect();
        if gaps.is_empty() {
            terminal.result(format_args!("{} messages in {window:?}", arrivals.len()));
            if arrivals.is_empty()
                && let Some(warning) = unknown_topic(&self.topic, remote)
            {
                terminal.warn(warning);
            }
            return Ok(Exit::Findings);
        }
        let (least, most) = gaps
            .iter()
            .fold((f64::INFINITY, 0.0_f64), |(least, most), gap| {
                (least.min(*gap), most.max(*gap))
            });
        let mean = gaps.iter().sum::<f64>() / gaps.len() as f64;
        terminal.result(format_args!(
            "{:.1} Hz: {} messages, {least:.1} to {most:.1} ms apart",
            1e3 / mean,
            arrivals.len()
        ));
        let received = subscription.counts();
        if received.missed + received.dropped > 0 {
            terminal.result(format_args!(
                "{} lost, {} dropped by this subscriber",
                received.missed, received.dropped
            ));
        }
        Ok(Exit::Ok)
    }
}
