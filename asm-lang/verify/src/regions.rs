//! Regions of inputs: an input that is only compared needs one value for each region between the values that it is compared with.

use crate::codes::m001::InputWithoutRange;
use crate::input_flow::{InputUse, input_uses};
use crate::inputs::{InputRanges, MAX_VALUES};
use asmotion_lang::ir::{DomainElements, FunctionId, FunctionKind, Program, ValueShape};
use asmotion_lang::value::Real;
use asmotion_lang::{Machine, Specification, Value};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Display;

/// An input without a finite domain, of which a few values stand for all others.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RepresentedInput {
    /// Index of the machine that reads it.
    pub machine: usize,
    /// Name of the monitored function.
    pub function: String,
    /// Its values, in ascending order.
    pub values: Vec<Representative>,
}

/// A value of an input, and those that it stands for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Representative {
    /// The value.
    pub value: String,
    /// The other values for which all steps and conditions are the same, as in `above 10`; `None` if it is the only one.
    pub stands_for: Option<String>,
}

/// Numbers without bounds are represented only if they are exact as 64-bit floats.
const EXACT: i64 = 1 << 53;

/// Gives ranges to the inputs of a machine whose values cannot be enumerated, but are only compared. `provided` are inputs that
/// other machines provide, and `are_kept` is `true` if inputs can keep their values from one step to the next.
///
/// # Errors
/// The value of such an input is needed.
pub(crate) fn represent(
    index: usize,
    machine: &Machine,
    specification: &Specification,
    provided: &BTreeSet<FunctionId>,
    are_kept: bool,
    ranges: &mut InputRanges,
) -> Result<Vec<RepresentedInput>, InputWithoutRange> {
    let program = machine.program();
    let mut inputs = BTreeSet::new();
    for (index, function) in program.functions.iter().enumerate() {
        let id = FunctionId(index as u32);
        let is_input = match function.kind {
            FunctionKind::Monitored | FunctionKind::Shared => true,
            FunctionKind::Controlled
            | FunctionKind::Out
            | FunctionKind::Local
            | FunctionKind::Fixed => false,
        };
        let is_free = is_input && function.clock.is_none() && function.mail.is_none();
        if is_free
            && !provided.contains(&id)
            && ranges.of(id).is_err()
            && RegionKind::of(program, &function.codomain).is_some()
        {
            inputs.insert(id);
        }
    }
    let mut represented = Vec::new();
    let uses = input_uses(machine, ranges, &inputs, are_kept);
    for (id, usage) in &uses {
        let (id, group) = (*id, InputGroup::of(*id, &uses));
        let function = program.functions.get(id.0 as usize);
        let kind = function.and_then(|it| RegionKind::of(program, &it.codomain));
        let regions = match (&usage.escape, kind) {
            (None, Some(kind)) => kind.regions(&group.compared, group.locations),
            (Some(_), _) | (None, None) => None,
        };
        let Some(regions) = regions.filter(|it| it.len() <= MAX_VALUES) else {
            return Err(refusal(machine, specification, id, usage));
        };
        let naming = machine.naming();
        let values = regions.iter().map(|region| Representative {
            value: region.value.show(&naming).to_string(),
            stands_for: region.stands_for.clone(),
        });
        represented.push(RepresentedInput {
            machine: index,
            function: name(program, id),
            values: values.collect(),
        });
        ranges.set(id, regions.into_iter().map(|it| it.value).collect());
    }
    Ok(represented)
}

/// Inputs that are compared with each other, directly or through others.
struct InputGroup {
    /// The values that they are compared with.
    compared: BTreeSet<Value>,
    /// Number of their locations: as many values can lie in a region in any order.
    locations: usize,
}

impl InputGroup {
    fn of(input: FunctionId, uses: &BTreeMap<FunctionId, InputUse>) -> Self {
        let mut members = BTreeSet::from([input]);
        let mut next = vec![input];
        while let Some(member) = next.pop() {
            let related = uses.get(&member).into_iter().flat_map(|it| &it.related);
            next.extend(related.filter(|it| members.insert(**it)));
        }
        let of_members = || members.iter().filter_map(|it| uses.get(it));
        let is_related = of_members().any(|it| !it.related.is_empty());
        Self {
            compared: of_members().flat_map(|it| it.compared.clone()).collect(),
            locations: if is_related {
                of_members().map(|it| it.locations).sum()
            } else {
                1
            },
        }
    }
}

fn name(program: &Program, function: FunctionId) -> String {
    let name = program.symbols.functions.get(function.0 as usize);
    name.map_or_else(String::new, ToString::to_string)
}

fn refusal(
    machine: &Machine,
    specification: &Specification,
    function: FunctionId,
    usage: &InputUse,
) -> InputWithoutRange {
    let name = |id: FunctionId| name(machine.program(), id);
    let needed = usage.escape.as_ref().map(|escape| {
        let place = specification.span(escape.at);
        (place, escape.usage.describe(&name))
    });
    InputWithoutRange {
        location: name(function),
        function: name(function),
        at: specification.span(usage.read),
        needed,
    }
}

/// The values whose regions are distinguished.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum RegionKind {
    /// Integers between two bounds, both included.
    Integers(i64, i64),
    Reals,
    Texts,
}

/// A region with one of its values.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Region {
    value: Value,
    /// The region in words; `None` if it has one value.
    stands_for: Option<String>,
}

impl RegionKind {
    fn of(program: &Program, shape: &ValueShape) -> Option<Self> {
        match shape {
            ValueShape::Int => Some(Self::Integers(i64::MIN, i64::MAX)),
            ValueShape::Natural => Some(Self::Integers(0, i64::MAX)),
            ValueShape::Real => Some(Self::Reals),
            ValueShape::Text => Some(Self::Texts),
            ValueShape::Domain(domain) => match program.domains.get(domain.0 as usize)?.elements {
                DomainElements::Ints { low, high } => Some(Self::Integers(low, high)),
                DomainElements::Atoms { .. }
                | DomainElements::Computed(_)
                | DomainElements::Undefined
                | DomainElements::Open => None,
            },
            ValueShape::Bool
            | ValueShape::Char
            | ValueShape::Complex
            | ValueShape::Rule
            | ValueShape::Tuple(_)
            | ValueShape::Seq(_)
            | ValueShape::Set(_)
            | ValueShape::Bag(_)
            | ValueShape::Map(..)
            | ValueShape::Any => None,
        }
    }

    /// Returns the regions between these values in ascending order, each with up to `several` values; `None` if there are none
    /// that can be told apart.
    fn regions(self, compared: &BTreeSet<Value>, several: usize) -> Option<Vec<Region>> {
        match self {
            Self::Integers(low, high) => Some(integer_regions(compared, low, high, several)),
            Self::Reals => real_regions(compared, several),
            Self::Texts => Some(text_regions(compared, several)),
        }
    }
}

fn integer_regions(compared: &BTreeSet<Value>, low: i64, high: i64, several: usize) -> Vec<Region> {
    let mut bounds = BTreeSet::new();
    for value in compared {
        if let Value::Int(number) = value {
            bounds.insert(*number);
        }
        // an integer lies below or above a real that is none
        if let Value::Real(real) = value {
            bounds.extend(as_integer(real.get().floor()));
            bounds.extend(as_integer(real.get().ceil()));
        }
    }
    let mut regions = Vec::new();
    let mut below = None;
    for bound in bounds.into_iter().filter(|it| (low..=high).contains(it)) {
        let first = below.map_or(Some(low), |it: i64| it.checked_add(1));
        let last = bound.checked_sub(1);
        regions.extend(integers_between(first, last, below, Some(bound), several));
        regions.push(Region {
            value: Value::Int(bound),
            stands_for: None,
        });
        below = Some(bound);
    }
    let first = below.map_or(Some(low), |it| it.checked_add(1));
    regions.extend(integers_between(first, Some(high), below, None, several));
    regions
}

/// Returns the region from the first to the last integer, which has these neighbours, with several of its values.
fn integers_between(
    first: Option<i64>,
    last: Option<i64>,
    below: Option<i64>,
    above: Option<i64>,
    several: usize,
) -> Vec<Region> {
    let (Some(first), Some(last)) = (first, last) else {
        return Vec::new();
    };
    if first > last {
        return Vec::new();
    }
    // the first value, if all of them follow
    let more = i64::try_from(several.saturating_sub(1)).unwrap_or(i64::MAX);
    let greatest = last.saturating_sub(more).max(first);
    let start = match (below, above) {
        (Some(_), _) => first,
        (None, Some(_)) => greatest,
        (None, None) => 0.clamp(first, greatest),
    };
    let all_but_one = first.abs_diff(last);
    let stands_for = (all_but_one > more as u64).then(|| between(below, above));
    (start..=last)
        .take(several)
        .map(|number| Region {
            value: Value::Int(number),
            stands_for: stands_for.clone(),
        })
        .collect()
}

/// Returns the integer that a real number without fraction is, if it has 64 bits.
fn as_integer(real: f64) -> Option<i64> {
    const END: f64 = 9_223_372_036_854_775_808.0;
    (-END..END).contains(&real).then_some(real as i64)
}

/// Returns the regions of real numbers; `None` if an integer that they are compared with is no 64-bit float.
fn real_regions(compared: &BTreeSet<Value>, several: usize) -> Option<Vec<Region>> {
    let mut bounds = BTreeSet::new();
    for value in compared {
        if let Value::Real(real) = value
            && real.get().is_finite()
        {
            bounds.insert(*real);
        }
        if let Value::Int(number) = value {
            let is_exact = (-EXACT..=EXACT).contains(number);
            bounds.insert(Real::new(is_exact.then_some(*number as f64)?));
        }
    }
    let text = |number: f64| format!("{number:?}");
    let mut regions = Vec::new();
    let mut region = |below: Option<f64>, above: Option<f64>| {
        let stands_for = between(below.map(text), above.map(text));
        let numbers = reals_between(below, above, several).into_iter();
        regions.extend(numbers.map(|number| Region {
            value: Value::real(number),
            stands_for: Some(stands_for.clone()),
        }));
    };
    let mut below: Option<f64> = None;
    for bound in bounds.iter().map(|it| it.get()) {
        region(below, Some(bound));
        below = Some(bound);
    }
    region(below, None);
    regions.extend(bounds.iter().map(|bound| Region {
        value: Value::real(bound.get()),
        stands_for: None,
    }));
    regions.sort_by(|a, b| a.value.cmp(&b.value));
    Some(regions)
}

/// Returns several real numbers between two others, or all if there are fewer.
fn reals_between(below: Option<f64>, above: Option<f64>, several: usize) -> Vec<f64> {
    let number = |index: usize| {
        let steps = index as f64;
        match (below, above) {
            (Some(below), Some(above)) => {
                below + (above - below) * (steps / (several as f64 + 1.0))
            }
            (None, Some(above)) => above - steps,
            (Some(below), None) => below + steps,
            (None, None) => steps - 1.0,
        }
    };
    let is_between =
        |it: &f64| below.is_none_or(|below| below < *it) && above.is_none_or(|above| *it < above);
    let mut numbers: Vec<f64> = (1..=several).map(number).collect();
    numbers.retain(|it| it.is_finite() && is_between(it));
    numbers.sort_by(f64::total_cmp);
    numbers.dedup();
    if numbers.len() == several {
        return numbers;
    }
    // so close together, or so great, that these coincide: the next ones
    let neighbour = |it: &f64| match (below, above) {
        (Some(_), _) | (None, None) => it.next_up(),
        (None, Some(_)) => it.next_down(),
    };
    let start = below.or(above).unwrap_or_default();
    let next = std::iter::successors(Some(neighbour(&start)), |it| Some(neighbour(it)));
    next.take_while(|it| it.is_finite() && is_between(it))
        .take(several)
        .collect()
}

/// Strings have no order here: those that an input is compared with, and others, each of which stands for all others.
fn text_regions(compared: &BTreeSet<Value>, several: usize) -> Vec<Region> {
    let texts = compared.iter().filter(|it| matches!(it, Value::Text(_)));
    let mut regions: Vec<Region> = texts
        .map(|text| Region {
            value: text.clone(),
            stands_for: None,
        })
        .collect();
    let mut other = String::from("other");
    for _ in 0..several {
        while compared.contains(&Value::text(other.as_str())) {
            other.push('_');
        }
        regions.push(Region {
            value: Value::text(other.clone()),
            stands_for: Some("all others".to_owned()),
        });
        other.push('_');
    }
    regions
}

/// Describes the numbers between two others.
fn between(below: Option<impl Display>, above: Option<impl Display>) -> String {
    match (below, above) {
        (None, None) => "all values".to_owned(),
        (None, Some(above)) => format!("all below {above}"),
        (Some(below), None) => format!("all above {below}"),
        (Some(below), Some(above)) => format!("all between {below} and {above}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn described(kind: RegionKind, compared: &[Value]) -> String {
        let regions = kind.regions(&compared.iter().cloned().collect(), 1);
        let Some(regions) = regions else {
            return "none".to_owned();
        };
        let parts = regions.iter().map(|region| {
            let value = if let Value::Int(number) = &region.value {
                number.to_string()
            } else if let Value::Real(real) = &region.value {
                format!("{:?}", real.get())
            } else if let Value::Text(text) = &region.value {
                text.to_string()
            } else {
                format!("{:?}", region.value)
            };
            match &region.stands_for {
                Some(text) => format!("{value} ({text})"),
                None => value,
            }
        });
        parts.collect::<Vec<String>>().join(", ")
    }

    #[test]
    fn integers_have_a_region_on_each_side_of_a_bound() {
        let all = RegionKind::Integers(i64::MIN, i64::MAX);
        let of = |kind, numbers: &[i64]| {
            let values: Vec<Value> = numbers.iter().copied().map(Value::Int).collect();
            described(kind, &values)
        };
        assert_eq!(of(all, &[]), "0 (all values)");
        assert_eq!(of(all, &[5]), "4 (all below 5), 5, 6 (all above 5)");
        assert_eq!(
            of(all, &[5, 6, 8, 20]),
            "4 (all below 5), 5, 6, 7, 8, 9 (all between 8 and 20), 20, 21 (all above 20)"
        );
        let natural = RegionKind::Integers(0, i64::MAX);
        assert_eq!(of(natural, &[-3, 0]), "0, 1 (all above 0)");
        assert_eq!(of(natural, &[1]), "0, 1, 2 (all above 1)");
        let domain = RegionKind::Integers(10, 10_000);
        assert_eq!(of(domain, &[]), "10 (all values)");
        assert_eq!(of(domain, &[10_000]), "9999 (all below 10000), 10000");
        assert_eq!(of(domain, &[9, 10_001]), "10 (all values)");
        let ends = of(all, &[i64::MIN, i64::MAX]);
        assert_eq!(
            ends,
            "-9223372036854775808, -9223372036854775807 (all between -9223372036854775808 and \
             9223372036854775807), 9223372036854775807"
        );
    }

    #[test]
    fn a_region_has_several_values_or_all() {
        let numbers = |kind: RegionKind, compared: &[Value]| -> Vec<Value> {
            let regions = kind.regions(&compared.iter().cloned().collect(), 3);
            let regions = regions.unwrap_or_default().into_iter();
            regions.map(|it| it.value).collect()
        };
        let all = RegionKind::Integers(i64::MIN, i64::MAX);
        let integers = |from: i64, to: i64| (from..=to).map(Value::Int).collect::<Vec<_>>();
        assert_eq!(numbers(all, &[]), integers(0, 2));
        assert_eq!(numbers(all, &[Value::Int(5)]), integers(2, 8));
        // two integers between the bounds are all
        let close = [Value::Int(5), Value::Int(8)];
        assert_eq!(numbers(all, &close), integers(2, 11));
        let highest = numbers(all, &[Value::Int(i64::MAX - 1)]);
        assert_eq!(highest, integers(i64::MAX - 4, i64::MAX));
        assert_eq!(numbers(RegionKind::Integers(7, 8), &[]), integers(7, 8));
        let next = 1.0_f64.next_up().next_up();
        let reals = numbers(RegionKind::Reals, &[Value::real(1.0), Value::real(next)]);
        assert_eq!(reals.len(), 3 + 1 + 1 + 1 + 3, "{reals:?}");
        assert_eq!(
            numbers(RegionKind::Texts, &[Value::text("other_")]).len(),
            4
        );
    }

    #[test]
    fn integers_compared_with_reals_have_the_integers_next_to_them() {
        let all = RegionKind::Integers(i64::MIN, i64::MAX);
        assert_eq!(
            described(all, &[Value::real(2.5)]),
            "1 (all below 2), 2, 3, 4 (all above 3)"
        );
        assert_eq!(described(all, &[Value::real(1e300)]), "0 (all values)");
    }

    #[test]
    fn reals_have_a_region_between_two_bounds() {
        let of = |values: &[Value]| described(RegionKind::Reals, values);
        assert_eq!(of(&[]), "0.0 (all values)");
        assert_eq!(
            of(&[Value::real(0.5), Value::Int(2)]),
            "-0.5 (all below 0.5), 0.5, 1.25 (all between 0.5 and 2.0), 2.0, 3.0 (all above 2.0)"
        );
        let next = 1.0_f64.next_up();
        let adjacent = of(&[Value::real(1.0), Value::real(next)]);
        assert_eq!(
            adjacent,
            format!(
                "0.0 (all below 1.0), 1.0, {next:?}, {:?} (all above {next:?})",
                next + 1.0
            )
        );
        // an integer that no float equals
        assert_eq!(of(&[Value::Int((1 << 53) + 1)]), "none");
        let large = of(&[Value::real(1e300)]);
        assert_eq!(large.matches("1e300").count(), 3, "{large}");
    }

    #[test]
    fn strings_have_one_value_for_all_others() {
        let of = |texts: &[&str]| {
            let values: Vec<Value> = texts.iter().map(|it| Value::text(*it)).collect();
            described(RegionKind::Texts, &values)
        };
        assert_eq!(of(&[]), "other (all others)");
        assert_eq!(of(&["go", "other"]), "go, other, other_ (all others)");
    }
}
