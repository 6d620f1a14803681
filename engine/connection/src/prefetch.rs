//! Hints to the processor that memory will be used soon.
//!
//! A system of thousands of components does not fit into the caches, and what a cycle touches is spread over many lines. An
//! executor that knows which component is next lets the processor load its memory while another component is at work.
//! `std` has no stable function for it, and a read in its place would wait for the memory.
#![expect(
    unsafe_code,
    reason = "the instruction takes a pointer; argued at the block"
)]

/// Distance of the hints in bytes: the size of a cache line.
const LINE: usize = 64;

/// Largest number of bytes of a value that are prefetched; a larger value has rather been made for a large content of which a
/// cycle uses a part.
const MOST: usize = 4096;

/// Asks the processor to load a value into its caches, but not what the value points to. This is a hint: it does not wait, reads
/// nothing and has no effect on results. On processors other than x86-64 it does nothing.
#[inline(always)]
pub fn prefetch<T: ?Sized>(value: &T) {
    let size = size_of_val(value).min(MOST);
    if size > 0 {
        hints((&raw const *value).cast(), size);
    }
}

/// Gives a hint for each line of so many bytes, at least one.
#[inline(never)]
fn hints(begin: *const u8, size: usize) {
    let mut offset = 0;
    // a loop over an iterator takes several times the instructions without optimisation
    while offset < size {
        hint(begin.wrapping_add(offset));
        offset += LINE;
    }
    // the value need not begin with a line
    hint(begin.wrapping_add(size - 1));
}

#[cfg(all(target_arch = "x86_64", not(miri)))]
#[inline(always)]
fn hint(at: *const u8) {
    use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
    // SAFETY: PREFETCHT0 is a hint. It accesses no memory as far as the program can tell, and raises no exception, whatever the
    // address (Intel SDM, volume 2B, PREFETCHh); here the address is within a value that is borrowed.
    unsafe { _mm_prefetch::<_MM_HINT_T0>(at.cast()) }
}

#[cfg(not(all(target_arch = "x86_64", not(miri))))]
#[inline(always)]
fn hint(_: *const u8) {}

#[cfg(all(test, not(feature = "loom")))]
mod tests {
    use super::*;

    #[test]
    fn values_of_any_size_can_be_prefetched_and_do_not_change() {
        prefetch(&());
        prefetch(&[] as &[u64]);
        let large = vec![7_u8; 3 * MOST];
        for size in [1, LINE - 1, LINE, LINE + 1, MOST, 3 * MOST] {
            prefetch(&large[..size]);
        }
        prefetch("text");
        prefetch::<dyn std::fmt::Debug>(&large);
        assert!(large.iter().all(|it| *it == 7));
    }
}
