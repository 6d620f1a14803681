//! What a tab has subscribed to, and what of it it has seen.

use std::sync::Arc;
use std::time::Duration;

use crate::feed::Feed;
use crate::output_slot::OutputSlot;

/// Highest rate of frames, in Hz.
const MAX_HZ: f64 = 60.0;
/// Lowest rate of frames, in Hz.
const MIN_HZ: f64 = 0.5;
/// Number of log entries that a new subscriber receives.
pub(crate) const RECENT: usize = 300;

/// The subscriptions of a tab.
#[derive(Default)]
pub(crate) struct Subscriptions {
    /// The outputs whose samples are sent.
    pub samples: Vec<SampleSubscription>,
    /// What the tab has seen.
    pub seen: Cursors,
}

/// The subscription to the samples of an output.
pub(crate) struct SampleSubscription {
    pub name: Arc<str>,
    /// The output; `None` until it has written.
    pub slot: Option<Arc<OutputSlot>>,
}

/// What a tab has seen. Tabs that have subscribed to the same and have seen the same receive the same.
#[derive(Clone, Default, PartialEq)]
pub(crate) struct Cursors {
    /// The last presence that was sent; `None` without a subscription.
    pub components: Option<u64>,
    /// The interval in which rates and ages of all outputs were sent last; `None` without a subscription.
    pub outputs: Option<u64>,
    /// The cursor in the steps; `None` without a subscription.
    pub steps: Option<u64>,
    /// Whether the states of the specifications and their last steps have to be sent before the steps.
    pub needs_states: bool,
    /// The cursor in the log; `None` without a subscription.
    pub log: Option<u64>,
    /// The cursor in the calls, which belong to the log.
    pub calls: Option<u64>,
    /// Number of the last sample that was sent of each output.
    pub samples: Vec<u64>,
}

impl Subscriptions {
    /// Replaces the subscriptions. What was and is still subscribed to continues.
    ///
    /// # Errors
    /// A text for the user, if there are more outputs than the limit.
    pub(crate) fn replace(
        &mut self,
        streams: &[String],
        feed: &Feed,
        max_samples: usize,
    ) -> Result<(), String> {
        let has = |name: &str| streams.iter().any(|stream| stream == name);
        let outputs = streams.iter().filter(|stream| stream.contains('.'));
        if outputs.clone().count() > max_samples {
            return Err(format!(
                "a tab can subscribe to {max_samples} outputs at most"
            ));
        }
        let state = feed.state();
        let seen = &mut self.seen;
        seen.needs_states |= has("steps") && seen.steps.is_none();
        let cursor = |old: Option<u64>, name: &str, new: u64| has(name).then(|| old.unwrap_or(new));
        seen.components = cursor(seen.components, "components", 0);
        // no interval has this number
        seen.outputs = cursor(seen.outputs, "outputs", u64::MAX);
        // older steps come with the states
        seen.steps = cursor(seen.steps, "steps", state.steps.count());
        seen.log = cursor(seen.log, "log", state.log.cursor_before(RECENT));
        seen.calls = cursor(seen.calls, "log", state.calls.cursor_before(RECENT));
        drop(state);
        let numbers = std::mem::take(&mut seen.samples);
        let mut old: Vec<_> = self.samples.drain(..).zip(numbers).collect();
        for name in outputs {
            let known = old.iter().position(|(it, _)| &*it.name == name);
            let (subscription, number) = known.map_or_else(
                || {
                    let (name, slot) = (name.as_str().into(), None);
                    (SampleSubscription { name, slot }, 0)
                },
                |index| old.swap_remove(index),
            );
            self.samples.push(subscription);
            self.seen.samples.push(number);
        }
        Ok(())
    }
}

/// The interval between frames at a rate in Hz.
pub(crate) fn interval(max_hz: f64) -> Duration {
    let hz = if max_hz.is_nan() { MIN_HZ } else { max_hz };
    Duration::from_secs_f64(1.0 / hz.clamp(MIN_HZ, MAX_HZ))
}
