//! Compares connections with the best crates: one write and one read, in one thread, alternately. Also compares the
//! writer's worst case under a slow reader, lock-free against a lock, as a histogram.
//!
//! `cargo bench -p asmotion-connection`
#![allow(missing_docs, clippy::print_stdout, reason = "a benchmark")]

use std::hint::black_box;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use asmotion_connection::{BufferKind, Pool, Receiver, Sender, channel};

/// Many short rounds: the fastest of them was not disturbed by other processes.
const ROUNDS: usize = 201;
const TURNS: u32 = 10_000;
/// The size of Orocos' buffers in RTT's published figures.
const BUFFER: usize = 16;

fn main() {
    // `cargo test --benches` only checks that it runs
    let quick = std::env::args().any(|argument| argument == "--test");
    write_and_read::<6>(quick);
    write_and_read::<512>(quick);
    writers_worst_case(quick);
}

/// A name, and a function that carries that many samples from a writer to a reader.
type Way = (&'static str, Box<dyn FnMut(u32)>);

fn ours<const N: usize>(
    (mut sender, mut receiver): (Sender<[u64; N]>, Receiver<[u64; N]>),
) -> Box<dyn FnMut(u32)> {
    Box::new(move |turns| {
        for n in 0..turns {
            sender.send(black_box([u64::from(n); N]));
            if let Some(sample) = receiver.take() {
                black_box(sample);
            }
        }
    })
}

fn triple_buffer<const N: usize>() -> Box<dyn FnMut(u32)> {
    let (mut writer, mut reader) = triple_buffer::triple_buffer(&[0; N]);
    Box::new(move |turns| {
        for n in 0..turns {
            writer.write(black_box([u64::from(n); N]));
            black_box(*reader.read());
        }
    })
}

fn rtrb<const N: usize>() -> Box<dyn FnMut(u32)> {
    let (mut writer, mut reader) = rtrb::RingBuffer::new(BUFFER);
    Box::new(move |turns| {
        for n in 0..turns {
            black_box(writer.push(black_box([u64::from(n); N])).is_ok());
            if let Ok(sample) = reader.pop() {
                black_box(sample);
            }
        }
    })
}

fn write_and_read<const N: usize>(quick: bool) {
    let locked = Pool::locked(BufferKind::Buffer(BUFFER));
    let mut ways: Vec<Way> = vec![
        ("triple_buffer", triple_buffer::<N>()),
        ("data", ours::<N>(channel(BufferKind::Data))),
        ("rtrb", rtrb::<N>()),
        ("buffer", ours::<N>(channel(BufferKind::Buffer(BUFFER)))),
        (
            "circular buffer",
            ours::<N>(channel(BufferKind::Circular(BUFFER))),
        ),
        (
            "locked buffer",
            ours::<N>((locked.sender(), locked.receiver())),
        ),
    ];
    let rounds = if quick { 1 } else { ROUNDS };
    let mut figures = vec![Vec::new(); ways.len()];
    for _ in 0..rounds {
        for ((_, way), figures) in ways.iter_mut().zip(&mut figures) {
            let begin = Instant::now();
            way(TURNS);
            figures.push(begin.elapsed().as_secs_f64() * 1e9 / f64::from(TURNS));
        }
    }
    let size = N * 8;
    println!("one write and one read of {size} bytes, ns: least and median of {rounds} rounds");
    let figures: Vec<_> = figures.into_iter().map(least_and_median).collect();
    for (index, ((name, _), (least, median))) in ways.iter().zip(&figures).enumerate() {
        let beside = match *name {
            "data" | "buffer" => {
                let (other, best) = (ways[index - 1].0, figures[index - 1].0);
                format!("  {:.2} x {other}", least / best)
            }
            _ => String::new(),
        };
        println!("  {name:<16}{least:>8.1}{median:>8.1}{beside}");
    }
}

fn least_and_median(mut figures: Vec<f64>) -> (f64, f64) {
    figures.sort_by(f64::total_cmp);
    (figures[0], figures[figures.len() / 2])
}

/// A sample of 64 KiB, large enough that reading it takes a while.
type Large = [u64; 8192];

/// Distribution of the duration of writes while a reader copies 64 KiB as fast as it can.
fn writers_worst_case(quick: bool) {
    let locked = Pool::locked(BufferKind::Data);
    let took = [
        ("lock-free", stall(channel(BufferKind::Data), quick)),
        ("mutex", stall((locked.sender(), locked.receiver()), quick)),
    ];
    println!("a write of 64 KiB under a reader that does nothing but read, number of writes");
    print!("  {:<16}", "took less than");
    for (name, _) in &took {
        print!("{name:>12}");
    }
    println!();
    for power in 10..=26_u32 {
        let bound = Duration::from_nanos(1 << power);
        print!("  {:<16}", format!("{:.1?}", bound));
        for (_, took) in &took {
            let count = took
                .iter()
                .filter(|one| **one < bound && **one >= bound / 2);
            print!("{:>12}", count.count());
        }
        println!();
    }
    for (name, took) in &took {
        let at = |part: usize| took[(took.len() - 1) * part / 1000];
        println!(
            "  {name}: median {:.1?}, 99 % {:.1?}, 99.9 % {:.1?}, worst {:.1?} of {}",
            at(500),
            at(990),
            at(999),
            at(1000),
            took.len()
        );
    }
}

fn stall(
    (mut sender, mut receiver): (Sender<Large>, Receiver<Large>),
    quick: bool,
) -> Vec<Duration> {
    let ended = AtomicBool::new(false);
    thread::scope(|scope| {
        scope.spawn(|| {
            while !ended.load(Ordering::Relaxed) {
                black_box(receiver.take());
            }
        });
        let writes = if quick { 100 } else { 100_000 };
        let mut took = Vec::with_capacity(writes);
        for n in 0..writes {
            let sample = [n as u64; 8192];
            let begin = Instant::now();
            sender.send(sample);
            took.push(begin.elapsed());
        }
        ended.store(true, Ordering::Relaxed);
        took.sort();
        took
    })
}
