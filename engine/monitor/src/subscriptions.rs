//! What a tab has subscribed to, and what of it it has seen.

use std::sync::Arc;
use std::time::Duration;

use crate::feed::Feed;
use crate::log_entry::LogFilter;
use crate::output_slot::{KeptSamples, OutputSlot, SlotFollower};
use crate::ticker::interval_at;

/// Highest rate of frames, in Hz. A page draws less often, and what is sampled more often comes in batches.
const MAX_HZ: f64 = 30.0;
/// Lowest rate of frames, in Hz.
const MIN_HZ: f64 = 0.5;
/// Number of log entries that a new subscriber receives.
pub(crate) const RECENT: usize = 300;

/// What a tab asks for.
#[derive(Default)]
pub(crate) struct WantedStreams<'r> {
    /// `components`, `outputs`, `steps`, `log`, and outputs whose newest sample is sent.
    pub streams: &'r [String],
    /// Outputs of which every sample is sent.
    pub every: &'r [String],
    /// The part of the log that is sent; `None` for all of it.
    pub log: Option<LogFilter>,
}

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
    /// Whether every sample is sent, and not only the newest one.
    pub every: bool,
    /// The output; `None` until it has written.
    pub slot: Option<Arc<OutputSlot>>,
    /// Lets the output keep its samples; `None` if only the newest one is sent.
    follower: Option<SlotFollower>,
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
    /// The cursor in the log; `None` without a subscription. It stands still while a part of the log is sent.
    pub log: Option<u64>,
    /// The cursor in the calls, which belong to the log.
    pub calls: Option<u64>,
    /// The part of the log that is sent; `None` for all of it.
    pub found: Option<FoundCursors>,
    /// Number of the last sample that was sent of each output.
    pub samples: Vec<u64>,
}

/// What a tab has seen of a part of the log.
#[derive(Clone, PartialEq)]
pub(crate) struct FoundCursors {
    /// In small letters.
    pub filter: Arc<LogFilter>,
    pub log: u64,
    pub calls: u64,
    /// Whether nothing was sent yet.
    pub is_new: bool,
}

impl FoundCursors {
    fn new(filter: LogFilter) -> Self {
        Self {
            filter: Arc::new(filter),
            log: 0,
            calls: 0,
            is_new: true,
        }
    }
}

impl SampleSubscription {
    /// Finds the output, once it has written.
    pub(crate) fn find(&mut self, feed: &Feed) -> Option<&Arc<OutputSlot>> {
        if self.slot.is_none() {
            self.slot = feed.output(&self.name);
        }
        let slot = self.slot.as_ref()?;
        if self.every {
            self.follower
                .get_or_insert_with(|| SlotFollower::new(slot, KeptSamples::All));
        }
        Some(slot)
    }
}

impl Subscriptions {
    /// Replaces the subscriptions. What was and is still subscribed to continues.
    ///
    /// # Errors
    /// A text for the user, if there are more outputs than the limit.
    pub(crate) fn replace(
        &mut self,
        wanted: WantedStreams<'_>,
        feed: &Feed,
        max_samples: usize,
    ) -> Result<(), String> {
        let WantedStreams {
            streams,
            every,
            log,
        } = wanted;
        let has = |name: &str| streams.iter().any(|stream| stream == name);
        let newest = streams.iter();
        let newest = newest.filter(|stream| stream.contains('.') && !every.contains(stream));
        if newest.clone().count() + every.len() > max_samples {
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
        let known = seen.found.take();
        seen.found = log.filter(|_| has("log")).map(|filter| {
            let filter = filter.lowercase();
            let known = known.filter(|known| *known.filter == filter);
            known.unwrap_or_else(|| FoundCursors::new(filter))
        });
        self.replace_samples(every, newest, feed);
        Ok(())
    }

    fn replace_samples<'n>(
        &mut self,
        every: &[String],
        newest: impl Iterator<Item = &'n String>,
        feed: &Feed,
    ) {
        let numbers = std::mem::take(&mut self.seen.samples);
        let mut old: Vec<_> = self.samples.drain(..).zip(numbers).collect();
        let every = every.iter().map(|name| (name, true));
        for (name, every) in every.chain(newest.map(|name| (name, false))) {
            let is_it = |(it, _): &(SampleSubscription, u64)| *it.name == **name;
            let known = old.iter().position(is_it).map(|at| old.swap_remove(at));
            let (known, number) = known.unzip();
            let mut subscription = SampleSubscription {
                every,
                name: name.as_str().into(),
                slot: None,
                follower: known.and_then(|it| it.follower).filter(|_| every),
            };
            // from now on its samples are kept
            subscription.find(feed);
            self.samples.push(subscription);
            self.seen.samples.push(number.unwrap_or_default());
        }
    }
}

/// The interval between frames at a rate in Hz.
pub(crate) fn interval(max_hz: f64) -> Duration {
    let hz = if max_hz.is_nan() { MIN_HZ } else { max_hz };
    interval_at(hz.clamp(MIN_HZ, MAX_HZ))
}
