//! A writer at full speed against a reader at full speed: never torn, never out of order.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    missing_docs,
    reason = "tests"
)]

use std::hint::spin_loop;
use std::thread;

use asmotion_connection::{BufferKind, Pool, PushOutcome, Receiver, Sender, channel};

const SHORT: u64 = 1_000_000;
const LONG: u64 = 100_000_000;

/// Every part is the sample's number, so that a torn sample can be detected.
type Wide = [u64; 6];

type Ends = (Sender<Wide>, Receiver<Wide>);

fn kinds() -> [(&'static str, Ends); 4] {
    let circular = Pool::locked(BufferKind::Circular(16));
    [
        ("data", channel(BufferKind::Data)),
        ("buffer", channel(BufferKind::Buffer(16))),
        ("circular buffer", channel(BufferKind::Circular(16))),
        ("locked", (circular.sender(), circular.receiver())),
    ]
}

/// Writes samples while a reader reads. Returns how many were read, and how many were dropped because the queue was
/// full.
fn race(writes: u64, (mut sender, mut receiver): Ends) -> (u64, u64) {
    let writing = thread::spawn(move || {
        let mut refused = 0;
        for n in 1..=writes {
            let full = sender.send([n; 6]) == PushOutcome::DroppedNewest;
            refused += u64::from(full);
            // with fewer processors than threads, lets the reader run
            if full || n % 1024 == 0 {
                thread::yield_now();
            }
        }
        // the last sample must arrive: it ends the loop of the reader
        while sender.send([u64::MAX; 6]) == PushOutcome::DroppedNewest {
            thread::yield_now();
        }
        refused
    });
    let (mut newest, mut read) = (0, 0);
    loop {
        let Some(sample) = receiver.take() else {
            spin_loop();
            continue;
        };
        assert!(sample.iter().all(|part| *part == sample[0]), "{sample:?}");
        assert!(sample[0] > newest, "{} after {newest}", sample[0]);
        if sample[0] == u64::MAX {
            return (read, writing.join().unwrap());
        }
        newest = sample[0];
        read += 1;
    }
}

fn race_all(writes: u64) {
    for (name, ends) in kinds() {
        let (read, refused) = race(writes, ends);
        println!("{name}: {writes} written, {read} read, {refused} refused");
        assert!(read > 0 && read + refused <= writes, "{name}");
        if name == "buffer" {
            assert_eq!(read + refused, writes, "what was not refused is read");
        }
    }
}

#[test]
fn o5_o6_a_million_writes_are_never_torn_and_never_out_of_order() {
    race_all(SHORT);
}

/// Run with `cargo test -p asmotion-connection --release -- --ignored --nocapture hundred`.
#[test]
#[ignore = "takes a minute"]
fn o5_o6_a_hundred_million_writes_are_never_torn_and_never_out_of_order() {
    race_all(LONG);
}

#[test]
fn o8_what_several_write_is_read_once_by_one_of_several() {
    for pool in [
        Pool::lock_free(BufferKind::Buffer(64)),
        Pool::locked(BufferKind::Buffer(64)),
    ] {
        const EACH: u64 = 50_000;
        let sum: u64 = thread::scope(|scope| {
            for writer in 0..3 {
                let mut sender = pool.sender();
                scope.spawn(move || {
                    for n in 0..EACH {
                        while sender.send(writer * EACH + n) == PushOutcome::DroppedNewest {
                            thread::yield_now();
                        }
                    }
                    while sender.send(u64::MAX) == PushOutcome::DroppedNewest {
                        thread::yield_now();
                    }
                });
            }
            let readers: Vec<_> = (0..3)
                .map(|_| {
                    let mut receiver = pool.receiver();
                    scope.spawn(move || {
                        let mut sum = 0;
                        loop {
                            match receiver.take() {
                                // one end marker for each reader
                                Some(u64::MAX) => return sum,
                                Some(n) => sum += n,
                                None => thread::yield_now(),
                            }
                        }
                    })
                })
                .collect();
            readers.into_iter().map(|one| one.join().unwrap()).sum()
        });
        let all = 3 * EACH;
        assert_eq!(sum, all * (all - 1) / 2);
    }
}
