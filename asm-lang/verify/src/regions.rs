//! Regions of inputs: an input that is only compared needs one value for each region between the values that it is compared with.

use crate::codes::m001::InputWithoutRange;
use crate::input_flow::{InputUse, input_uses};
use crate::inputs::{InputRanges, MAX_VALUES};
use asmotion_lang::ir::{DomainElements, FunctionId, FunctionKind, Program, ValueShape};
use asmotion_lang::value::Real;
use asmotion_lang::{Machine, Specification, Value};
use std::collections::BTreeSet;
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
/// other machines provide.
///
/// # Errors
/// The value of such an input is needed.
pub(crate) fn represent(
    index: usize,
    machine: &Machine,
    specification: &Specification,
    provided: &BTreeSet<FunctionId>,
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
    for (id, usage) in input_uses(machine, ranges, &inputs) {
        let function = program.functions.get(id.0 as usize);
        let kind = function.and_then(|it| RegionKind::of(program, &it.codomain));
        let regions = match (&usage.escape, kind) {
            (None, Some(kind)) => kind.regions(&usage.compared),
            (Some(_), _) | (None, None) => None,
        };
        let Some(regions) = regions.filter(|it| it.len() <= MAX_VALUES) else {
            return Err(refusal(machine, specification, id, &usage));
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

    /// Returns the regions between these values in ascending order; `None` if there are none that can be told apart.
    fn regions(self, compared: &BTreeSet<Value>) -> Option<Vec<Region>> {
        match self {
            Self::Integers(low, high) => Some(integer_regions(compared, low, high)),
            Self::Reals => real_regions(compared),
            Self::Texts => Some(text_regions(compared)),
        }
    }
}

fn integer_regions(compared: &BTreeSet<Value>, low: i64, high: i64) -> Vec<Region> {
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
        regions.extend(integers_between(
            first,
            bound.checked_sub(1),
            below,
            Some(bound),
        ));
        regions.push(Region {
            value: Value::Int(bound),
            stands_for: None,
        });
        below = Some(bound);
    }
    let first = below.map_or(Some(low), |it| it.checked_add(1));
    regions.extend(integers_between(first, Some(high), below, None));
    regions
}

/// Returns the region from the first to the last integer, which has these neighbours.
fn integers_between(
    first: Option<i64>,
    last: Option<i64>,
    below: Option<i64>,
    above: Option<i64>,
) -> Option<Region> {
    let (first, last) = (first?, last?);
    let value = match (below, above) {
        _ if first > last => return None,
        (Some(_), _) => first,
        (None, Some(_)) => last,
        (None, None) => 0.clamp(first, last),
    };
    Some(Region {
        value: Value::Int(value),
        stands_for: (first < last).then(|| between(below, above)),
    })
}

/// Returns the integer that a real number without fraction is, if it has 64 bits.
fn as_integer(real: f64) -> Option<i64> {
    const END: f64 = 9_223_372_036_854_775_808.0;
    (-END..END).contains(&real).then_some(real as i64)
}

/// Returns the regions of real numbers; `None` if an integer that they are compared with is no 64-bit float.
fn real_regions(compared: &BTreeSet<Value>) -> Option<Vec<Region>> {
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
    let mut region = |number: f64, below: Option<f64>, above: Option<f64>| {
        let is_between = below.is_none_or(|it| it < number) && above.is_none_or(|it| number < it);
        if is_between && number.is_finite() {
            regions.push(Region {
                value: Value::real(number),
                stands_for: Some(between(below.map(text), above.map(text))),
            });
        }
    };
    let mut below: Option<f64> = None;
    let mut points = Vec::new();
    for bound in bounds.iter().map(|it| it.get()) {
        let number = match below {
            Some(below) => below + (bound - below) / 2.0,
            None if bound - 1.0 < bound => bound - 1.0,
            None => bound.next_down(),
        };
        region(number, below, Some(bound));
        points.push(bound);
        below = Some(bound);
    }
    let number = match below {
        Some(below) if below + 1.0 > below => below + 1.0,
        Some(below) => below.next_up(),
        None => 0.0,
    };
    region(number, below, None);
    regions.extend(points.into_iter().map(|bound| Region {
        value: Value::real(bound),
        stands_for: None,
    }));
    regions.sort_by(|a, b| a.value.cmp(&b.value));
    Some(regions)
}

/// Strings have no order here: those that an input is compared with, and one that stands for all others.
fn text_regions(compared: &BTreeSet<Value>) -> Vec<Region> {
    let texts = compared.iter().filter(|it| matches!(it, Value::Text(_)));
    let mut regions: Vec<Region> = texts
        .map(|text| Region {
            value: text.clone(),
            stands_for: None,
        })
        .collect();
    let mut other = String::from("other");
    while compared.contains(&Value::text(other.as_str())) {
        other.push('_');
    }
    regions.push(Region {
        value: Value::text(other),
        stands_for: Some("all others".to_owned()),
    });
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
        let regions = kind.regions(&compared.iter().cloned().collect());
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
