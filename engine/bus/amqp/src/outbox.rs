//! The outbox of a publisher: messages that wait, messages in flight, and counts of the others.

use std::collections::VecDeque;
use std::sync::Arc;

use amqprs::BasicProperties;
use asmotion_bus::{Assurance, Outage, Payload, PublishOptions, PublisherCounts, TraceContext};

/// Capacity of the queue while the link is open: absorbs a burst, not an outage.
const BURST: usize = 4096;
/// Limit of messages in flight.
const WINDOW: usize = 512;
/// Limit of bytes in flight.
const WINDOW_BYTES: usize = 2 << 20;

/// A message of this publisher, not yet encoded.
#[derive(Clone)]
pub(crate) struct OutgoingMessage {
    pub sequence: u64,
    pub stamp: i64,
    pub payload: Payload,
    pub trace: TraceContext,
}

/// An encoded message; kept until its delivery is confirmed.
#[derive(Clone)]
pub(crate) struct EncodedMessage {
    pub properties: Box<BasicProperties>,
    pub bytes: Arc<[u8]>,
}

struct UnconfirmedMessage {
    tag: u64,
    size: usize,
    /// Kept if it may have to be sent again.
    written: Option<EncodedMessage>,
}

/// Outbox of one publisher, shared by its handle and its task.
pub(crate) struct PublisherOutbox {
    sending: PublishOptions,
    waiting: VecDeque<OutgoingMessage>,
    /// Encoded messages to be sent again, before all others.
    again: VecDeque<EncodedMessage>,
    /// Messages in flight, in order of their delivery tags.
    underway: VecDeque<UnconfirmedMessage>,
    underway_bytes: usize,
    /// Number of messages to send one by one, to find the one that the broker refuses.
    careful: usize,
    /// Set after a broken link until a queue receives a message: the broker may have lost the readers' queues, or the
    /// readers may come back later than this publisher. Until then, messages are sent one by one.
    probing: bool,
    /// The broker returned the message in flight while `probing`.
    returned: bool,
    pub sent: PublisherCounts,
    /// The newest message, if it is retained for late subscribers.
    last: Option<OutgoingMessage>,
}

/// The next thing to send.
pub(crate) enum NextToSend {
    /// A message that has not been encoded yet.
    Fresh(OutgoingMessage),
    /// A message to be sent again.
    Again(EncodedMessage),
}

impl PublisherOutbox {
    pub(crate) fn new(sending: PublishOptions) -> Self {
        Self {
            sending,
            waiting: VecDeque::new(),
            again: VecDeque::new(),
            underway: VecDeque::new(),
            underway_bytes: 0,
            careful: 0,
            probing: false,
            returned: false,
            sent: PublisherCounts::default(),
            last: None,
        }
    }

    pub(crate) fn is_confirmed(&self) -> bool {
        self.sending.assurance == Assurance::Confirmed
    }

    /// Enqueues a message, if the outage policy permits. Returns whether it was accepted; dropped messages are
    /// counted.
    pub(crate) fn put(&mut self, item: OutgoingMessage, open: bool) -> bool {
        self.sent.published += 1;
        if self.sending.init {
            self.last = Some(item.clone());
        }
        let kept = match self.sending.outage {
            Outage::Drop | Outage::KeepLatest if open => BURST,
            Outage::Drop => 0,
            Outage::KeepLatest => 1,
            Outage::Queue(size) if open => size.get().max(BURST),
            Outage::Queue(size) => size.get(),
        };
        if self.waiting.len() < kept {
            self.waiting.push_back(item);
            return true;
        }
        self.sent.dropped += 1;
        match self.sending.outage {
            Outage::KeepLatest => {
                self.waiting.pop_front();
                self.waiting.push_back(item);
                true
            }
            Outage::Drop | Outage::Queue(_) => false,
        }
    }

    /// Enqueues the retained message again, unless it is still waiting. Returns whether it was enqueued.
    pub(crate) fn repeat(&mut self, open: bool) -> bool {
        let waits =
            |last: &OutgoingMessage| self.waiting.iter().any(|one| one.sequence == last.sequence);
        match self.last.clone().filter(|last| !waits(last)) {
            Some(last) => self.put(last, open),
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
            self.sent.dropped += 1;
        }
    }

    /// Returns the next message to send, if the window has room.
    pub(crate) fn next(&mut self) -> Option<NextToSend> {
        let one_by_one = self.careful > 0 || self.probing;
        let window = if one_by_one { 1 } else { WINDOW };
        if self.underway.len() >= window || self.underway_bytes > WINDOW_BYTES {
            return None;
        }
        let again = self.again.pop_front().map(NextToSend::Again);
        again.or_else(|| self.waiting.pop_front().map(NextToSend::Fresh))
    }

    /// Records a sent message. Returns it for publishing, and keeps a copy if it may have to be sent again.
    pub(crate) fn went(&mut self, tag: u64, written: EncodedMessage) -> EncodedMessage {
        let size = written.bytes.len();
        self.underway_bytes += size;
        let kept = self.is_confirmed().then(|| written.clone());
        self.underway.push_back(UnconfirmedMessage {
            tag,
            size,
            written: kept,
        });
        written
    }

    /// Puts back a message that could not be sent, as the next one.
    pub(crate) fn stayed(&mut self, written: EncodedMessage) {
        self.again.push_front(written);
    }

    /// Marks messages as delivered. Returns `false` if the only one in flight was returned while probing: it is put
    /// back, to be sent again.
    pub(crate) fn arrived(&mut self, tag: u64, multiple: bool) -> bool {
        if self.returned {
            self.returned = false;
            self.resend_unconfirmed();
            return false;
        }
        let count = self.settle(tag, multiple);
        self.sent.arrived += count;
        self.probing &= count == 0;
        true
    }

    /// Records that no queue received a message; its confirmation follows.
    pub(crate) fn returned(&mut self) {
        if self.probing {
            self.returned = true;
        } else {
            self.sent.unheard += 1;
        }
    }

    /// Returns whether messages are sent one by one until a queue receives one.
    pub(crate) fn is_probing(&self) -> bool {
        self.probing
    }

    /// Stops waiting for a queue: a message that was returned counts as unheard.
    pub(crate) fn stop_probing(&mut self) {
        self.probing = false;
        self.sent.unheard += u64::from(std::mem::take(&mut self.returned));
    }

    /// Counts messages that the broker rejected. Sending them again would reorder them.
    pub(crate) fn refused(&mut self, tag: u64, multiple: bool) {
        self.sent.refused += self.settle(tag, multiple);
    }

    fn settle(&mut self, tag: u64, multiple: bool) -> u64 {
        let from = self.underway.partition_point(|underway| underway.tag < tag);
        let first = if multiple { 0 } else { from };
        let last = from + usize::from(self.underway.get(from).is_some_and(|one| one.tag == tag));
        let settled = self.underway.drain(first..last);
        let mut count = 0;
        for one in settled {
            self.underway_bytes -= one.size;
            count += 1;
        }
        self.careful = self.careful.saturating_sub(count);
        count as u64
    }

    /// Handles the loss of the channel. Confirmed messages in flight are sent again in order; the fate of others is
    /// unknown, and they count as lost. If the broker `refused` one of them, they are sent one by one until the
    /// refused message is alone.
    pub(crate) fn broke(&mut self, refused: bool) {
        self.returned = false;
        // a publisher that never had a reader does not wait for one
        self.probing = self.is_confirmed() && self.sent.arrived > self.sent.unheard;
        self.underway_bytes = 0;
        let count = self.underway.len();
        if !self.is_confirmed() {
            self.underway.clear();
            self.sent.lost += count as u64;
            return;
        }
        if refused && count == 1 {
            self.underway.clear();
            self.sent.refused += 1;
            self.careful = self.careful.saturating_sub(1);
            return;
        }
        if refused {
            self.careful = self.careful.max(count);
        }
        self.resend_unconfirmed();
    }

    /// Puts the messages in flight back, in order.
    fn resend_unconfirmed(&mut self) {
        self.underway_bytes = 0;
        while let Some(one) = self.underway.pop_back() {
            if let Some(written) = one.written {
                self.again.push_front(written);
            }
        }
    }

    /// Counts a message that cannot be encoded.
    pub(crate) fn unwritable(&mut self) {
        self.sent.dropped += 1;
    }

    /// Drops everything when the bus closes.
    pub(crate) fn give_up(&mut self) {
        self.broke(false);
        let left = self.waiting.len() + self.again.len();
        self.waiting.clear();
        self.again.clear();
        self.sent.dropped += left as u64;
    }
}

#[cfg(test)]
mod tests {
    use std::num::NonZeroUsize;

    use asmotion_datum::Datum;

    use super::*;

    fn item(sequence: u64) -> OutgoingMessage {
        OutgoingMessage {
            sequence,
            stamp: 0,
            payload: Payload::of(Datum::Null),
            trace: asmotion_bus::SpanGenerator::new("", 0, "").of(sequence, None),
        }
    }

    fn outbox(sending: PublishOptions, messages: u64, open: bool) -> PublisherOutbox {
        let mut outbox = PublisherOutbox::new(sending);
        for sequence in 1..=messages {
            outbox.put(item(sequence), open);
        }
        outbox
    }

    fn waiting(outbox: &PublisherOutbox) -> Vec<u64> {
        outbox.waiting.iter().map(|item| item.sequence).collect()
    }

    fn send(outbox: &mut PublisherOutbox, tags: std::ops::RangeInclusive<u64>) {
        for tag in tags {
            let next = outbox.next().expect("there is room");
            let written = match next {
                NextToSend::Again(written) => written,
                NextToSend::Fresh(item) => EncodedMessage {
                    properties: Box::default(),
                    bytes: vec![0; item.sequence as usize].into(),
                },
            };
            outbox.went(tag, written);
        }
    }

    /// Sizes of the messages to be sent again, which identify them.
    fn again(outbox: &PublisherOutbox) -> Vec<usize> {
        outbox.again.iter().map(|one| one.bytes.len()).collect()
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
            assert_eq!((waiting(&outbox), outbox.sent.dropped), (kept, dropped));
            assert_eq!(outbox.sent.published, 5);
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
        confirmed.arrived(2, false);
        confirmed.broke(false);
        assert_eq!(again(&confirmed), [1, 3, 4]);
        assert_eq!((confirmed.sent.arrived, confirmed.sent.open()), (1, 4));
        let mut once = outbox(PublishOptions::default(), 5, true);
        send(&mut once, 1..=4);
        once.arrived(2, true);
        once.broke(false);
        assert_eq!(
            (once.sent.arrived, once.sent.lost, once.sent.open()),
            (2, 2, 1)
        );
    }

    #[test]
    fn after_a_break_messages_wait_until_a_queue_receives_one() {
        let mut outbox = outbox(events(9), 5, true);
        send(&mut outbox, 1..=2);
        outbox.arrived(1, false);
        outbox.broke(false);
        for tag in 1..=3 {
            send(&mut outbox, tag..=tag);
            assert!(outbox.next().is_none(), "one by one");
            outbox.returned();
            assert!(!outbox.arrived(tag, false));
            assert_eq!(again(&outbox), [2], "the same message again");
        }
        send(&mut outbox, 4..=4);
        assert!(outbox.arrived(4, false));
        send(&mut outbox, 5..=7);
        assert_eq!((outbox.sent.arrived, outbox.sent.unheard), (2, 0));
    }

    #[test]
    fn a_publisher_waits_for_its_readers_no_longer_than_it_is_told_and_only_if_it_had_some() {
        let mut had = outbox(events(9), 3, true);
        send(&mut had, 1..=1);
        had.arrived(1, false);
        had.broke(false);
        send(&mut had, 1..=1);
        had.returned();
        had.stop_probing();
        assert!(had.arrived(1, false) && !had.is_probing());
        assert_eq!((had.sent.arrived, had.sent.unheard), (2, 1));
        let mut never = outbox(events(9), 3, true);
        send(&mut never, 1..=1);
        never.returned();
        never.arrived(1, false);
        never.broke(false);
        assert!(!never.is_probing());
    }

    #[test]
    fn the_one_that_is_refused_is_found_and_the_others_go() {
        let mut outbox = outbox(events(9), 3, true);
        send(&mut outbox, 1..=3);
        outbox.broke(true);
        send(&mut outbox, 1..=1);
        assert!(outbox.next().is_none(), "one by one");
        outbox.arrived(1, false);
        send(&mut outbox, 2..=2);
        outbox.broke(true);
        assert_eq!((outbox.sent.refused, again(&outbox)), (1, vec![3]));
    }

    #[test]
    fn what_is_under_way_is_bounded_in_number_and_in_bytes() {
        let mut many = outbox(events(9), 2 * WINDOW as u64, true);
        send(&mut many, 1..=WINDOW as u64);
        assert!(many.next().is_none());
        many.arrived(1, false);
        assert!(many.next().is_some());
        let mut big = outbox(events(9), 2, true);
        big.next();
        let written = EncodedMessage {
            properties: Box::default(),
            bytes: vec![0; WINDOW_BYTES + 1].into(),
        };
        big.went(1, written);
        assert!(big.next().is_none());
    }
}
