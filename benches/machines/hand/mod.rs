//! The machines written directly in Rust, with plain variables instead of a general state and update sets: a lower
//! bound for comparison.
//!
//! Each runs a number of steps from the initial state, and returns the values of all locations.

mod coord;

use std::collections::VecDeque;
use std::hint::black_box;

/// Runs a machine for a number of steps. Returns one line for each location if the flag is set.
pub type Hand = fn(u64, bool) -> Vec<String>;

/// All machines by name.
pub const MACHINES: &[(&str, Hand)] = &[
    ("counter", counter),
    ("gcd", gcd),
    ("phil5", |steps, show| {
        philosophers(black_box(5), steps, show)
    }),
    ("phil50", |steps, show| {
        philosophers(black_box(50), steps, show)
    }),
    ("phil500", |steps, show| {
        philosophers(black_box(500), steps, show)
    }),
    ("life32", |steps, show| life(black_box(32), steps, show)),
    ("life128", |steps, show| life(black_box(128), steps, show)),
    // without vector instructions, which compute 16 cells at once
    ("life32_scalar", |steps, show| {
        life_by_cell(black_box(32), steps, show)
    }),
    ("life128_scalar", |steps, show| {
        life_by_cell(black_box(128), steps, show)
    }),
    ("sort64", |steps, show| sort(black_box(64), steps, show)),
    ("sort512", |steps, show| sort(black_box(512), steps, show)),
    ("agents100", |steps, show| {
        agents(black_box(100), steps, show)
    }),
    ("coord", coord::run),
    ("bfs1000", |steps, show| {
        search(black_box(1000), steps, show)
    }),
];

/// A xorshift generator, for choices.
pub struct Shifts(pub u64);

impl Shifts {
    pub const SEED: u64 = 88_172_645_463_325_252;

    pub fn below(&mut self, count: u32) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (((self.0 >> 32) * u64::from(count)) >> 32) as u32
    }
}

fn counter(steps: u64, show: bool) -> Vec<String> {
    let (mut x, mut y, mut hi, mut lo) = (1i64, 0i64, 0i64, 0i64);
    for _ in 0..steps {
        let old = x;
        x = (old * 7 + 3) % 1009;
        y = (y + old) % 1_000_003;
        if old > 500 {
            hi += 1;
        } else {
            lo += 1;
        }
        black_box((&mut x, &mut y, &mut hi, &mut lo));
    }
    if !show {
        return Vec::new();
    }
    vec![
        format!("x={x}"),
        format!("y={y}"),
        format!("hi={hi}"),
        format!("lo={lo}"),
    ]
}

fn gcd(steps: u64, show: bool) -> Vec<String> {
    let (mut a, mut b, mut k, mut acc) = (0i64, 0i64, 0i64, 0i64);
    for _ in 0..steps {
        a = 1000 + (k * k) % 997;
        b = 300 + (k * 13) % 501;
        while b != 0 {
            let rest = a % b;
            a = b;
            b = rest;
        }
        acc = (acc + a) % 1_000_003;
        k = (k + 1) % 1000;
        black_box((&mut a, &mut b, &mut k, &mut acc));
    }
    if !show {
        return Vec::new();
    }
    vec![
        format!("a={a}"),
        format!("b={b}"),
        format!("k={k}"),
        format!("acc={acc}"),
    ]
}

fn philosophers(count: usize, steps: u64, show: bool) -> Vec<String> {
    let mut eating = vec![false; count];
    let mut toggles = vec![0i64; count];
    let mut meals = vec![0i64; count];
    let mut shifts = Shifts(Shifts::SEED);
    for _ in 0..steps {
        let may = |eating: &[bool], who: usize| {
            let right = if who + 1 == count { 0 } else { who + 1 };
            let left = if who == 0 { count - 1 } else { who - 1 };
            eating[who] || (!eating[right] && !eating[left])
        };
        let mut candidates = 0u32;
        for who in 0..count {
            candidates += u32::from(may(&eating, who));
        }
        let chosen = (candidates > 0).then(|| {
            let index = shifts.below(candidates) as usize;
            let mut all = (0..count).filter(|&who| may(&eating, who));
            all.nth(index).unwrap_or(0)
        });
        for who in 0..count {
            meals[who] += i64::from(eating[who]);
        }
        if let Some(who) = chosen {
            eating[who] = !eating[who];
            toggles[who] += 1;
        }
        black_box((&mut eating, &mut toggles, &mut meals));
    }
    if !show {
        return Vec::new();
    }
    let line = |who: usize| {
        [
            format!("eating({who})={}", eating[who]),
            format!("toggles({who})={}", toggles[who]),
            format!("meals({who})={}", meals[who]),
        ]
    };
    (0..count).flat_map(line).collect()
}

fn life(size: usize, steps: u64, show: bool) -> Vec<String> {
    life_with(size, steps, show, |around, alive| {
        u8::from(around == 3) | (u8::from(around == 2) & alive)
    })
}

/// Like [`life`], one cell at a time.
fn life_by_cell(size: usize, steps: u64, show: bool) -> Vec<String> {
    life_with(size, steps, show, |around, alive| {
        let around = black_box(around);
        u8::from(around == 3) | (u8::from(around == 2) & alive)
    })
}

fn life_with(
    size: usize,
    steps: u64,
    show: bool,
    next_value: impl Fn(u8, u8) -> u8,
) -> Vec<String> {
    let width = size + 2;
    let mut cells = vec![0u8; width * width];
    for row in 1..=size {
        for column in 1..=size {
            if (row * 7 + column * 13 + row * column * (row + 3)) % 5 < 2 {
                cells[row * width + column] = 1;
            }
        }
    }
    let mut next = cells.clone();
    for _ in 0..steps {
        for row in 1..=size {
            let up = &cells[(row - 1) * width..row * width];
            let here = &cells[row * width..(row + 1) * width];
            let down = &cells[(row + 1) * width..(row + 2) * width];
            let out = &mut next[row * width + 1..row * width + 1 + size];
            let (up0, up1, up2) = (&up[..size], &up[1..=size], &up[2..size + 2]);
            let (here0, here1, here2) = (&here[..size], &here[1..=size], &here[2..size + 2]);
            let (down0, down1, down2) = (&down[..size], &down[1..=size], &down[2..size + 2]);
            for c in 0..size {
                let around = up0[c]
                    .wrapping_add(up1[c])
                    .wrapping_add(up2[c])
                    .wrapping_add(here0[c])
                    .wrapping_add(here2[c])
                    .wrapping_add(down0[c])
                    .wrapping_add(down1[c])
                    .wrapping_add(down2[c]);
                out[c] = next_value(around, here1[c]);
            }
        }
        std::mem::swap(&mut cells, &mut next);
        black_box(&mut cells);
    }
    if !show {
        return Vec::new();
    }
    let line = |index: usize| {
        let (row, column) = (index / width, index % width);
        format!("cell({row},{column})={}", cells[index])
    };
    (0..width * width).map(line).collect()
}

fn sort(count: usize, steps: u64, show: bool) -> Vec<String> {
    let mut items: Vec<i64> = (0..=count as i64)
        .map(|index| (index * 7919 + 17) % 10_007)
        .collect();
    let mut t = 0usize;
    let mut runs = 0i64;
    for _ in 0..steps {
        if t == count {
            for (index, item) in items.iter_mut().take(count).enumerate() {
                *item = ((index as i64 + 1) * 7919 + (runs + 1) * 31) % 10_007;
            }
            t = 0;
            runs = (runs + 1) % 10_007;
        } else {
            let mut index = t % 2;
            while index <= count - 2 {
                if items[index] > items[index + 1] {
                    items.swap(index, index + 1);
                }
                index += 2;
            }
            t += 1;
        }
        black_box(&mut items);
    }
    if !show {
        return Vec::new();
    }
    let mut lines: Vec<String> = items
        .iter()
        .enumerate()
        .map(|(index, item)| format!("arr({index})={item}"))
        .collect();
    lines.extend([format!("t={t}"), format!("runs={runs}")]);
    lines
}

fn agents(count: usize, steps: u64, show: bool) -> Vec<String> {
    let mut val: Vec<i64> = (0..count as i64).map(|index| (index * 7) % 1009).collect();
    let nxt: Vec<usize> = (0..count).map(|index| (index + 1) % count).collect();
    let mut cnt = vec![0i64; count];
    let mut budget = vec![5i64; count];
    let mut busy = vec![false; count];
    let mut next = val.clone();
    for _ in 0..steps {
        for index in 0..count {
            next[index] = (val[index] * 3 + val[nxt[index]] + 1) % 1009;
            if !busy[index] {
                if val[index] > 700 {
                    busy[index] = true;
                } else {
                    cnt[index] += 1;
                }
            } else if budget[index] == 0 {
                busy[index] = false;
                budget[index] = 5;
            } else {
                budget[index] -= 1;
            }
        }
        std::mem::swap(&mut val, &mut next);
        black_box((&mut val, &mut cnt, &mut budget, &mut busy));
    }
    if !show {
        return Vec::new();
    }
    let line = |index: usize| {
        let mode = if busy[index] {
            "BUSY_MODE"
        } else {
            "IDLE_MODE"
        };
        [
            format!("val(w{index})={}", val[index]),
            format!("nxt(w{index})=w{}", nxt[index]),
            format!("cnt(w{index})={}", cnt[index]),
            format!("budget(w{index})={}", budget[index]),
            format!("st(w{index})={mode}"),
        ]
    };
    (0..count).flat_map(line).collect()
}

fn search(count: usize, steps: u64, show: bool) -> Vec<String> {
    let mut dist = vec![0i64; count];
    let mut seen = vec![false; count];
    seen[0] = true;
    let mut queue = VecDeque::from([0usize]);
    let (mut rounds, mut total) = (0usize, 0u64);
    for _ in 0..steps {
        if let Some(node) = queue.pop_front() {
            total += 1;
            let (first, second) = ((node * 3 + 1) % count, (node * 5 + 2) % count);
            let far = dist[node] + 1;
            let new_first = !seen[first];
            let new_second = first != second && !seen[second];
            if new_first {
                dist[first] = far;
                seen[first] = true;
                queue.push_back(first);
            }
            if new_second {
                dist[second] = far;
                seen[second] = true;
                queue.push_back(second);
            }
        } else {
            let start = ((rounds + 1) * 37) % count;
            dist.fill(0);
            seen.fill(false);
            seen[start] = true;
            queue.push_back(start);
            rounds += 1;
        }
        black_box((&mut dist, &mut queue));
    }
    if !show {
        return Vec::new();
    }
    let listed = |items: &mut dyn Iterator<Item = usize>| {
        let items: Vec<String> = items.map(|item| item.to_string()).collect();
        items.join(",")
    };
    let mut lines: Vec<String> = (0..count)
        .map(|node| format!("dist({node})={}", dist[node]))
        .collect();
    lines.extend([
        format!("q=[{}]", listed(&mut queue.iter().copied())),
        format!(
            "seen={{{}}}",
            listed(&mut (0..count).filter(|&node| seen[node]))
        ),
        format!("rounds={rounds}"),
        format!("total={total}"),
    ]);
    lines
}
