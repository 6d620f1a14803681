//! The outbox of a publisher: messages that wait, messages in flight, and counts of the others.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::{Duration, Instant};

use asmotion_bus::{Assurance, Outage, Payload, PublishOptions, PublisherCounts, TraceContext};

use crate::notice::PublisherLosses;

/// Capacity of the queue while the link is open: absorbs a burst, not an outage.
const BURST: usize = 4096;
/// Limit of messages in flight.
const WINDOW: usize = 512;
/// Least time between two reports of losses.
pub(crate) const REPORT_INTERVAL: Duration = Duration::from_secs(1);
/// Limit of bytes in flight.
const WINDOW_BYTES: usize = 2 << 20;

/// A message of this publisher, not yet encoded.
#[derive(Clone)]
pub(crate) struct OutgoingMessage {
    pub header: MessageHeader,
    pub payload: Payload,
}

/// Metadata of one message.
#[derive(Clone, Copy)]
pub(crate) struct MessageHeader {
    pub sequence: u64,
    /// Time of publication, in nanoseconds of the component's clock.
    pub stamp: i64,
    /// The same instant, for measuring the message's age.
    pub published: Instant,
    pub trace: TraceContext,
}

impl MessageHeader {
    /// Returns how long ago the component published the message.
    pub(crate) fn age(&self) -> Duration {
        self.published.elapsed()
    }
}

/// An encoded message; kept until its delivery is confirmed.
#[derive(Clone)]
pub(crate) struct EncodedMessage {
    pub header: MessageHeader,
    pub bytes: Arc<[u8]>,
}

struct UnconfirmedMessage {
    tag: u64,
    size: usize,
    /// Kept if it may have to be sent again.
    encoded: Option<EncodedMessage>,
}

/// Outbox of one publisher, shared by its handle and its task.
pub(crate) struct PublisherOutbox {
    sending: PublishOptions,
    waiting: VecDeque<OutgoingMessage>,
    /// Encoded messages to be sent again, before all others.
    resend: VecDeque<EncodedMessage>,
    /// Messages in flight, in order of their delivery tags.
    in_flight: VecDeque<UnconfirmedMessage>,
    in_flight_bytes: usize,
    /// Number of messages to send one by one, to find the one that the broker refuses.
    single_sends: usize,
    /// Set after a broken link until a queue receives a message: the broker may have lost the readers' queues, or the
    /// readers may come back later than this publisher. Until then, messages are sent one by one.
    probing: bool,
    /// The broker returned the message in flight while `probing`.
    returned: bool,
    pub counts: PublisherCounts,
    /// The losses that no caller of [`push`](Self::push) has learnt of, and those that have been reported.
    losses: PublisherLosses,
    reported: PublisherLosses,
    /// Time of the last report.
    reported_at: Option<Instant>,
    /// The newest message, if it is retained for late subscribers.
    retained: Option<OutgoingMessage>,
}

/// The next thing to send.
pub(crate) enum NextToSend {
    /// A message that has not been encoded yet.
    New(OutgoingMessage),
    /// A message to be sent again.
    Resend(EncodedMessage),
}

impl PublisherOutbox {
    pub(crate) fn new(sending: PublishOptions) -> Self {
        Self {
            sending,
            waiting: VecDeque::new(),
            resend: VecDeque::new(),
            in_flight: VecDeque::new(),
            in_flight_bytes: 0,
            single_sends: 0,
            probing: false,
            returned: false,
            counts: PublisherCounts::default(),
            losses: PublisherLosses::default(),
            reported: PublisherLosses::default(),
            reported_at: None,
            retained: None,
        }
    }

    pub(crate) fn is_confirmed(&self) -> bool {
        self.sending.assurance == Assurance::Confirmed
    }

    /// Enqueues a message, if the outage policy permits. Returns whether it was accepted; dropped messages are
    /// counted.
    pub(crate) fn push(&mut self, message: OutgoingMessage, open: bool) -> bool {
        self.counts.published += 1;
        if self.sending.init {
            self.retained = Some(message.clone());
        }
        let kept = match self.sending.outage {
            Outage::Drop | Outage::KeepLatest if open => BURST,
            Outage::Drop => 0,
            Outage::KeepLatest => 1,
            Outage::Queue(size) if open => size.get().max(BURST),
            Outage::Queue(size) => size.get(),
        };
        if self.waiting.len() < kept {
            self.waiting.push_back(message);
            return true;
        }
        self.counts.dropped += 1;
        match self.sending.outage {
            Outage::KeepLatest => {
                self.waiting.pop_front();
                self.waiting.push_back(message);
                true
            }
            Outage::Drop | Outage::Queue(_) => false,
        }
    }

    /// Enqueues the retained message again, unless it is still waiting. Returns whether it was enqueued.
    pub(crate) fn push_retained(&mut self, open: bool) -> bool {
        let waits = |last: &OutgoingMessage| {
            let mut waiting = self.waiting.iter();
            waiting.any(|one| one.header.sequence == last.header.sequence)
        };
        let useful = |last: &OutgoingMessage| !waits(last) && !self.is_expired(&last.header);
        match self.retained.clone().filter(useful) {
            Some(last) => self.push(last, open),
            None => false,
        }
    }

    /// Drops the messages that the outage policy does not keep while the link is closed.
    pub(crate) fn close(&mut self) {
        let kept = match self.sending.outage {
            Outage::Drop => 0,
            Outage::KeepLatest => 1,
            Outage::Queue(_) => usize::MAX,
        };
        while self.waiting.len() > kept {
            self.waiting.pop_front();
            self.counts.dropped += 1;
        }
    }

    /// Returns the next message to send, if the window has room.
    pub(crate) fn next(&mut self) -> Option<NextToSend> {
        self.drop_expired();
        let one_by_one = self.single_sends > 0 || self.probing;
        let window = if one_by_one { 1 } else { WINDOW };
        if self.in_flight.len() >= window || self.in_flight_bytes > WINDOW_BYTES {
            return None;
        }
        let again = self.resend.pop_front().map(NextToSend::Resend);
        again.or_else(|| self.waiting.pop_front().map(NextToSend::New))
    }

    /// Returns whether a message has waited longer than any reader would accept.
    fn is_expired(&self, header: &MessageHeader) -> bool {
        let limit = self.sending.max_age;
        limit.is_some_and(|max_age| header.age() > max_age)
    }

    /// Drops the waiting messages that are too old for every reader. Messages wait in order, so the oldest is in front.
    fn drop_expired(&mut self) {
        while let Some(oldest) = self.resend.front()
            && self.is_expired(&oldest.header)
        {
            self.resend.pop_front();
            self.counts.dropped += 1;
            self.losses.expired += 1;
        }
        while let Some(oldest) = self.waiting.front()
            && self.is_expired(&oldest.header)
        {
            self.waiting.pop_front();
            self.counts.dropped += 1;
            self.losses.expired += 1;
        }
    }

    /// Returns the losses if there are new ones to report: at most once a second.
    pub(crate) fn losses_to_report(&mut self) -> Option<PublisherLosses> {
        let is_soon = self
            .reported_at
            .is_some_and(|at| at.elapsed() < REPORT_INTERVAL);
        if is_soon || !self.has_unreported_losses() {
            return None;
        }
        self.reported = self.losses;
        self.reported_at = Some(Instant::now());
        Some(self.losses)
    }

    /// Returns whether there are losses that have not been reported yet.
    pub(crate) fn has_unreported_losses(&self) -> bool {
        self.losses != self.reported
    }

    /// Records a sent message. Returns it for publishing, and keeps a copy if it may have to be sent again.
    pub(crate) fn record_sent(&mut self, tag: u64, written: EncodedMessage) -> EncodedMessage {
        let size = written.bytes.len();
        self.in_flight_bytes += size;
        let kept = self.is_confirmed().then(|| written.clone());
        self.in_flight.push_back(UnconfirmedMessage {
            tag,
            size,
            encoded: kept,
        });
        written
    }

    /// Puts back a message that could not be sent, as the next one.
    pub(crate) fn push_back_unsent(&mut self, written: EncodedMessage) {
        self.resend.push_front(written);
    }

    /// Marks messages as delivered. Returns `false` if the only one in flight was returned while probing: it is put
    /// back, to be sent again.
    pub(crate) fn confirm(&mut self, tag: u64, multiple: bool) -> bool {
        if self.returned {
            self.returned = false;
            self.resend_unconfirmed();
            return false;
        }
        let count = self.remove_in_flight(tag, multiple);
        self.counts.accepted += count;
        self.probing &= count == 0;
        true
    }

    /// Records that no queue received a message; its confirmation follows.
    pub(crate) fn returned(&mut self) {
        if self.probing {
            self.returned = true;
        } else {
            self.counts.unrouted += 1;
        }
    }

    /// Returns whether messages are sent one by one until a queue receives one.
    pub(crate) fn is_probing(&self) -> bool {
        self.probing
    }

    /// Stops waiting for a queue: a message that was returned counts as unrouted.
    pub(crate) fn stop_probing(&mut self) {
        self.probing = false;
        self.counts.unrouted += u64::from(std::mem::take(&mut self.returned));
    }

    /// Counts messages that the broker rejected. Sending them again would reorder them.
    pub(crate) fn reject(&mut self, tag: u64, multiple: bool) {
        let refused = self.remove_in_flight(tag, multiple);
        self.counts.refused += refused;
        self.losses.refused += refused;
    }

    fn remove_in_flight(&mut self, tag: u64, multiple: bool) -> u64 {
        let from = self
            .in_flight
            .partition_point(|underway| underway.tag < tag);
        let first = if multiple { 0 } else { from };
        let last = from + usize::from(self.in_flight.get(from).is_some_and(|one| one.tag == tag));
        let settled = self.in_flight.drain(first..last);
        let mut count = 0;
        for one in settled {
            self.in_flight_bytes -= one.size;
            count += 1;
        }
        self.single_sends = self.single_sends.saturating_sub(count);
        count as u64
    }

    /// Handles the loss of the channel. Confirmed messages in flight are sent again in order; the fate of others is
    /// unknown, and they count as lost. If the broker `refused` one of them, they are sent one by one until the
    /// refused message is alone.
    pub(crate) fn connection_lost(&mut self, refused: bool) {
        self.returned = false;
        // a publisher that never had a reader does not wait for one; a message in flight may have had one
        let had_reader = self.counts.accepted > self.counts.unrouted;
        let may_have_one = !refused && !self.in_flight.is_empty();
        self.probing = self.is_confirmed() && (had_reader || may_have_one);
        self.in_flight_bytes = 0;
        let count = self.in_flight.len();
        if !self.is_confirmed() {
            self.in_flight.clear();
            self.counts.lost += count as u64;
            return;
        }
        if refused && count == 1 {
            self.in_flight.clear();
            self.counts.refused += 1;
            self.losses.refused += 1;
            self.single_sends = self.single_sends.saturating_sub(1);
            return;
        }
        if refused {
            self.single_sends = self.single_sends.max(count);
        }
        self.resend_unconfirmed();
    }

    /// Puts the messages in flight back, in order.
    fn resend_unconfirmed(&mut self) {
        self.in_flight_bytes = 0;
        while let Some(one) = self.in_flight.pop_back() {
            if let Some(written) = one.encoded {
                self.resend.push_front(written);
            }
        }
    }

    /// Counts a message that cannot be encoded.
    pub(crate) fn drop_unencodable(&mut self) {
        self.counts.dropped += 1;
    }

    /// Drops everything when the bus closes.
    pub(crate) fn discard_all(&mut self) {
        self.connection_lost(false);
        let left = self.waiting.len() + self.resend.len();
        self.waiting.clear();
        self.resend.clear();
        self.counts.dropped += left as u64;
    }
}

#[cfg(test)]
mod tests {
    use std::num::NonZeroUsize;

    use asmotion_datum::Datum;

    use super::*;

    fn item(sequence: u64) -> OutgoingMessage {
        OutgoingMessage {
            header: MessageHeader {
                sequence,
                stamp: 0,
                published: Instant::now(),
                trace: asmotion_bus::SpanGenerator::new("", 0, "").of(sequence, None),
            },
            payload: Payload::of(Datum::Null),
        }
    }

    fn outbox(sending: PublishOptions, messages: u64, open: bool) -> PublisherOutbox {
        let mut outbox = PublisherOutbox::new(sending);
        for sequence in 1..=messages {
            outbox.push(item(sequence), open);
        }
        outbox
    }

    fn waiting(outbox: &PublisherOutbox) -> Vec<u64> {
        outbox
            .waiting
            .iter()
            .map(|item| item.header.sequence)
            .collect()
    }

    fn send(outbox: &mut PublisherOutbox, tags: std::ops::RangeInclusive<u64>) {
        for tag in tags {
            let next = outbox.next().expect("there is room");
            let written = match next {
                NextToSend::Resend(written) => written,
                NextToSend::New(item) => EncodedMessage {
                    bytes: vec![0; item.header.sequence as usize].into(),
                    header: item.header,
                },
            };
            outbox.record_sent(tag, written);
        }
    }

    /// Sizes of the messages to be sent again, which identify them.
    fn again(outbox: &PublisherOutbox) -> Vec<usize> {
        outbox.resend.iter().map(|one| one.bytes.len()).collect()
    }

    fn events(size: usize) -> PublishOptions {
        PublishOptions::events(NonZeroUsize::new(size).expect("a size"))
    }

    #[test]
    fn each_outage_policy_keeps_what_it_says_and_counts_the_rest() {
        for (sending, kept, dropped) in [
            (PublishOptions::default(), vec![], 5),
            (PublishOptions::state(), vec![5], 4),
            (events(3), vec![1, 2, 3], 2),
        ] {
            let outbox = outbox(sending, 5, false);
            assert_eq!((waiting(&outbox), outbox.counts.dropped), (kept, dropped));
            assert_eq!(outbox.counts.published, 5);
        }
    }

    #[test]
    fn a_link_that_closes_leaves_what_the_policy_keeps() {
        for (sending, kept) in [
            (PublishOptions::default(), vec![]),
            (PublishOptions::state(), vec![5]),
            (events(3), vec![1, 2, 3, 4, 5]),
        ] {
            let mut outbox = outbox(sending, 5, true);
            outbox.close();
            assert_eq!(waiting(&outbox), kept);
        }
    }

    #[test]
    fn confirmed_messages_go_again_in_order_and_others_are_lost() {
        let mut confirmed = outbox(events(9), 5, true);
        send(&mut confirmed, 1..=4);
        confirmed.confirm(2, false);
        confirmed.connection_lost(false);
        assert_eq!(again(&confirmed), [1, 3, 4]);
        assert_eq!(
            (confirmed.counts.accepted, confirmed.counts.pending()),
            (1, 4)
        );
        let mut once = outbox(PublishOptions::default(), 5, true);
        send(&mut once, 1..=4);
        once.confirm(2, true);
        once.connection_lost(false);
        assert_eq!(
            (
                once.counts.accepted,
                once.counts.lost,
                once.counts.pending()
            ),
            (2, 2, 1)
        );
    }

    #[test]
    fn after_a_break_messages_wait_until_a_queue_receives_one() {
        let mut outbox = outbox(events(9), 5, true);
        send(&mut outbox, 1..=2);
        outbox.confirm(1, false);
        outbox.connection_lost(false);
        for tag in 1..=3 {
            send(&mut outbox, tag..=tag);
            assert!(outbox.next().is_none(), "one by one");
            outbox.returned();
            assert!(!outbox.confirm(tag, false));
            assert_eq!(again(&outbox), [2], "the same message again");
        }
        send(&mut outbox, 4..=4);
        assert!(outbox.confirm(4, false));
        send(&mut outbox, 5..=7);
        assert_eq!((outbox.counts.accepted, outbox.counts.unrouted), (2, 0));
    }

    #[test]
    fn a_publisher_waits_for_its_readers_no_longer_than_it_is_told_and_only_if_it_had_some() {
        let mut had = outbox(events(9), 3, true);
        send(&mut had, 1..=1);
        had.confirm(1, false);
        had.connection_lost(false);
        send(&mut had, 1..=1);
        had.returned();
        had.stop_probing();
        assert!(had.confirm(1, false) && !had.is_probing());
        assert_eq!((had.counts.accepted, had.counts.unrouted), (2, 1));
        let mut never = outbox(events(9), 3, true);
        send(&mut never, 1..=1);
        never.returned();
        never.confirm(1, false);
        never.connection_lost(false);
        assert!(!never.is_probing());
        let mut unconfirmed = outbox(events(9), 3, true);
        send(&mut unconfirmed, 1..=1);
        unconfirmed.connection_lost(false);
        assert!(unconfirmed.is_probing());
    }

    #[test]
    fn a_message_that_is_too_old_for_its_readers_is_dropped_and_counted() {
        let mut old = outbox(events(9).max_age(Some(Duration::ZERO)), 2, true);
        std::thread::sleep(Duration::from_millis(1));
        assert!(old.next().is_none());
        assert_eq!((old.counts.dropped, old.counts.pending()), (2, 0));
        let losses = old.losses_to_report().map(|losses| losses.expired);
        assert_eq!((losses, old.losses_to_report()), (Some(2), None));
        let mut resent = outbox(events(9).max_age(Some(Duration::from_millis(200))), 2, true);
        send(&mut resent, 1..=2);
        resent.connection_lost(false);
        std::thread::sleep(Duration::from_millis(201));
        resent.push(item(3), true);
        let next = resent.next();
        assert!(matches!(next, Some(NextToSend::New(new)) if new.header.sequence == 3));
        assert_eq!(resent.counts.dropped, 2);
        let retained = PublishOptions::state()
            .init(true)
            .max_age(Some(Duration::ZERO));
        let mut retained = outbox(retained, 1, true);
        std::thread::sleep(Duration::from_millis(1));
        retained.next();
        assert!(!retained.push_retained(true));
    }

    #[test]
    fn the_one_that_is_refused_is_found_and_the_others_go() {
        let mut outbox = outbox(events(9), 3, true);
        send(&mut outbox, 1..=3);
        outbox.connection_lost(true);
        send(&mut outbox, 1..=1);
        assert!(outbox.next().is_none(), "one by one");
        outbox.confirm(1, false);
        send(&mut outbox, 2..=2);
        outbox.connection_lost(true);
        assert_eq!((outbox.counts.refused, again(&outbox)), (1, vec![3]));
    }

    #[test]
    fn what_is_under_way_is_bounded_in_number_and_in_bytes() {
        let mut many = outbox(events(9), 2 * WINDOW as u64, true);
        send(&mut many, 1..=WINDOW as u64);
        assert!(many.next().is_none());
        many.confirm(1, false);
        assert!(many.next().is_some());
        let mut big = outbox(events(9), 2, true);
        big.next();
        let written = EncodedMessage {
            header: item(1).header,
            bytes: vec![0; WINDOW_BYTES + 1].into(),
        };
        big.record_sent(1, written);
        assert!(big.next().is_none());
    }
}
