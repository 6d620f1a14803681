//! Sets, against `BTreeSet`.

use crate::random::Random;
use asmotion_temporal::Bits;
use std::collections::BTreeSet;

#[test]
fn sets_behave_like_ordered_sets() {
    for seed in 0..300 {
        let mut random = Random::new(seed);
        let size = random.below(200);
        let (one, other) = (random.bits(size, 3), random.bits(size, 2));
        let set = |bits: &Bits| bits.ones().collect::<BTreeSet<usize>>();
        let (ones, others) = (set(&one), set(&other));
        assert_eq!(one.count(), ones.len());
        assert_eq!(one.is_empty(), ones.is_empty());
        assert_eq!(one.intersects(&other), !ones.is_disjoint(&others));
        assert_eq!(one.is_subset(&other), ones.is_subset(&others));
        let apply = |change: fn(&mut Bits, &Bits)| {
            let mut changed = one.clone();
            change(&mut changed, &other);
            set(&changed)
        };
        assert_eq!(apply(Bits::union_with), &ones | &others);
        assert_eq!(apply(Bits::intersect_with), &ones & &others);
        assert_eq!(apply(Bits::subtract), &ones - &others);
        let all: BTreeSet<usize> = (0..size).collect();
        assert_eq!(set(&Bits::full(size)), all);
        assert_eq!(set(&one.clone().complemented()), &all - &ones);
        assert_eq!(Bits::from_ones(size, ones.iter().copied()), one);
        let mut changed = one.clone();
        for number in 0..size + 70 {
            let is_new = number < size && !ones.contains(&number);
            assert_eq!(changed.insert(number), is_new);
            assert_eq!(changed.contains(number), number < size);
            changed.remove(number);
        }
        assert!(changed.is_empty());
    }
}

#[test]
fn sets_of_different_sizes_can_be_combined() {
    let small = Bits::full(3);
    let large = Bits::full(130);
    let mut union = small.clone();
    union.union_with(&large);
    assert_eq!(union, small);
    let mut common = large.clone();
    common.intersect_with(&small);
    assert_eq!(common.ones().collect::<Vec<_>>(), [0, 1, 2]);
    assert!(small.is_subset(&large) && !large.is_subset(&small));
}
