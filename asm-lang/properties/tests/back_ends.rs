//! Generated programs run the same in all back ends: a bounded, deterministic version of what the fuzzer does.

use asmotion_properties::back_ends;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Number of programs.
const PROGRAMS: u64 = 80;

/// Seeds of further programs, which back ends once ran differently: the fault of an indexed guard was at another place.
const FOUND: [u64; 1] = [1263];

#[test]
fn generated_programs_run_the_same_in_all_back_ends() {
    let mut compared = 0;
    for seed in (0..PROGRAMS).chain(FOUND) {
        let mut bytes = [0; 400];
        ChaCha8Rng::seed_from_u64(seed).fill_bytes(&mut bytes);
        compared += u64::from(back_ends(&bytes));
    }
    assert!(
        compared > PROGRAMS * 9 / 10,
        "only {compared} programs open"
    );
}
