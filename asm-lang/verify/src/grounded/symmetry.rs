//! Symmetry: domains whose elements all rules and properties use alike.
//!
//! Exchanging two elements exchanges locations: `f(1, x)` and `f(2, x)`. If the grounded rule, the conditions of the properties and the
//! initial state remain the same under this exchange, up to the order of parts where it has no meaning, then the successors of an
//! exchanged state are the exchanged successors of the state, and conditions have equal values in both. States that arise from each
//! other by such exchanges thus satisfy the same formulas, have the same faults up to exchanges, and are stuck together; it is enough to
//! explore one of them. Nothing is assumed about how the specification is written: literals, orders and values that name elements
//! simply make the comparison fail.
//!
//! Exchanges of a set of elements that is connected by them generate all its permutations. Of the states that permutations make of each
//! other, the one is explored in which the tuples of values of the elements are in ascending order. Where locations belong to two
//! elements, or to elements of two domains, this need not be one state for all of them; there are then more states than necessary.

use super::layout::{Field, WordLayout, Words};
use crate::inputs::MAX_VALUES;
use asmotion_ground::{
    GroundProgram, GroundTerm, Renaming, Shapes, accesses_of_rule, accesses_of_term,
};
use asmotion_lang::ir::{DomainId, FunctionId, ValueShape};
use asmotion_lang::{Machine, Value};
use std::collections::{BTreeMap, BTreeSet};

/// Greatest number of elements.
const MAX_ELEMENTS: usize = 64;

/// Limit for the size of the rule times the number of exchanges that are tried.
const MAX_EXCHANGES: usize = 512;

/// Elements that can be permuted.
#[derive(Clone, Debug)]
struct SymmetricElements {
    /// Name of the domain, with the elements if these are not all.
    name: String,
    /// The variables that belong to each element alone, in the same order.
    own: Vec<Vec<u32>>,
    /// For each function of two elements, the variable of each pair.
    pairs: Vec<Vec<Vec<u32>>>,
}

/// The symmetry of a program.
#[derive(Clone, Debug, Default)]
pub(crate) struct Symmetry(Vec<SymmetricElements>);

/// The locations of variables and inputs.
struct Locations<'a> {
    machine: &'a Machine,
    variables: Vec<(FunctionId, Vec<Value>)>,
    variable_of: BTreeMap<(FunctionId, Vec<Value>), u32>,
    inputs: Vec<(FunctionId, Vec<Value>)>,
    input_of: BTreeMap<(FunctionId, Vec<Value>), u32>,
}

impl<'a> Locations<'a> {
    fn of(machine: &'a Machine, program: &GroundProgram) -> Option<Self> {
        let (state, of) = (machine.state(), machine.program());
        let variables = program.variables.iter();
        let variables = variables.map(|variable| state.location(of, variable.slot));
        let variables = variables.collect::<Option<Vec<_>>>()?;
        let inputs = program.inputs.iter();
        let inputs: Vec<_> = inputs
            .map(|input| (input.function, input.arguments.clone()))
            .collect();
        Some(Self {
            machine,
            variable_of: variables.iter().cloned().zip(0..).collect(),
            variables,
            input_of: inputs.iter().cloned().zip(0..).collect(),
            inputs,
        })
    }

    /// Returns the positions of the arguments of a function that are elements of a domain.
    fn positions(&self, function: FunctionId, domain: DomainId) -> Vec<usize> {
        let declared = self.machine.program().functions.get(function.0 as usize);
        let parameters = declared.map(|it| it.parameters.iter().enumerate());
        let is_it = |shape: &ValueShape| *shape == ValueShape::Domain(domain);
        let found = parameters.into_iter().flatten();
        let found = found.filter(|(_, shape)| is_it(shape));
        found.map(|(index, _)| index).collect()
    }

    /// Returns the exchange of two elements; `None` if a location is exchanged with something else.
    fn exchange(&self, domain: DomainId, one: &Value, other: &Value) -> Option<Renaming> {
        let exchanged = |(function, arguments): &(FunctionId, Vec<Value>)| {
            let mut arguments = arguments.clone();
            for position in self.positions(*function, domain) {
                if let Some(argument) = arguments.get_mut(position) {
                    if argument == one {
                        *argument = other.clone();
                    } else if argument == other {
                        *argument = one.clone();
                    }
                }
            }
            (*function, arguments)
        };
        let variables = self.variables.iter();
        let variables = variables.map(|it| self.variable_of.get(&exchanged(it)).copied());
        let inputs = self.inputs.iter();
        let inputs = inputs.map(|it| self.input_of.get(&exchanged(it)).copied());
        Some(Renaming {
            variables: variables.collect::<Option<Vec<u32>>>()?,
            inputs: inputs.collect::<Option<Vec<u32>>>()?,
        })
    }
}

impl Symmetry {
    /// Finds the symmetry of a program and of these conditions.
    pub fn of(machine: &Machine, program: &GroundProgram, conditions: &[GroundTerm]) -> Self {
        let is_known = |term: &GroundTerm| !accesses_of_term(term).needs_machine;
        let is_grounded = !accesses_of_rule(&program.rule).needs_machine;
        let locations = Locations::of(machine, program);
        let (true, true, Some(locations)) =
            (is_grounded, conditions.iter().all(is_known), locations)
        else {
            return Self::default();
        };
        let mut comparison = Comparison {
            locations: &locations,
            program,
            conditions,
            shapes: Shapes::default(),
            tried: 0,
        };
        let functions = locations.variables.iter().map(|(function, _)| function);
        let functions: BTreeSet<&FunctionId> = functions.collect();
        let mut domains: Vec<DomainId> = Vec::new();
        for function in functions {
            let declared = machine.program().functions.get(function.0 as usize);
            for shape in declared.into_iter().flat_map(|it| &it.parameters) {
                if let ValueShape::Domain(domain) = shape
                    && !domains.contains(domain)
                {
                    domains.push(*domain);
                }
            }
        }
        let found = domains.iter().flat_map(|it| comparison.domain(*it));
        Self(found.collect())
    }

    /// Returns `true` if nothing can be permuted.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Returns the names of the domains.
    pub fn names(&self) -> Vec<String> {
        self.0.iter().map(|it| it.name.clone()).collect()
    }

    /// Gives the variables that can be exchanged the same range.
    pub fn align(&self, program: &mut GroundProgram) {
        let groups = self.0.iter().flat_map(SymmetricElements::exchanged);
        // a variable can be in several groups, of which each is widened to the ranges of the others
        let groups: Vec<Vec<u32>> = groups.collect();
        for _ in 0..=self.0.len() {
            for group in &groups {
                let known = |index: &u32| program.variables.get(*index as usize);
                let ranges = group.iter().filter_map(known);
                let (low, high, may_be_undef) = ranges.fold(
                    (i64::MAX, i64::MIN, false),
                    |(low, high, may_be_undef), it| {
                        (
                            low.min(it.range.0),
                            high.max(it.range.1),
                            may_be_undef || it.may_be_undef,
                        )
                    },
                );
                for index in group {
                    if let Some(variable) = program.variables.get_mut(*index as usize) {
                        variable.range = (low, high);
                        variable.may_be_undef = may_be_undef;
                    }
                }
            }
        }
    }

    /// Returns the places of what can be exchanged.
    pub fn in_words(&self, layout: &WordLayout) -> WordSymmetry {
        let fields = |variables: &Vec<u32>| {
            let all = variables.iter();
            all.filter_map(|it| layout.field(*it).cloned()).collect()
        };
        let groups = self.0.iter().map(|it| WordGroup {
            own: it.own.iter().map(fields).collect(),
            pairs: it
                .pairs
                .iter()
                .map(|rows| rows.iter().map(fields).collect())
                .collect(),
        });
        WordSymmetry(groups.collect())
    }
}

impl SymmetricElements {
    /// Returns the variables that are exchanged with each other.
    fn exchanged(&self) -> Vec<Vec<u32>> {
        let count = self.own.first().map_or(0, Vec::len);
        let own = (0..count).map(|index| {
            let of = self.own.iter().filter_map(|it| it.get(index));
            of.copied().collect()
        });
        let pairs = self.pairs.iter().map(|rows| rows.concat());
        own.chain(pairs).collect()
    }
}

/// A location without the elements that it belongs to.
type LocationOf<'a> = (FunctionId, Vec<Option<&'a Value>>);

/// The comparison of a program with itself after exchanges.
struct Comparison<'a> {
    locations: &'a Locations<'a>,
    program: &'a GroundProgram,
    conditions: &'a [GroundTerm],
    shapes: Shapes,
    /// Number of exchanges that were tried.
    tried: usize,
}

impl Comparison<'_> {
    /// Returns the sets of elements of a domain that can be permuted.
    fn domain(&mut self, domain: DomainId) -> Vec<SymmetricElements> {
        let machine = self.locations.machine;
        let shape = ValueShape::Domain(domain);
        let Some(all) = machine.elements(&shape, MAX_VALUES) else {
            return Vec::new();
        };
        if all.len() > MAX_ELEMENTS {
            return Vec::new();
        }
        // an element can be exchanged with all of a set if it can be with one of them
        let mut sets: Vec<Vec<&Value>> = Vec::new();
        for element in &all {
            let known = sets.iter().position(|set| {
                set.first()
                    .is_some_and(|first| self.is_unchanged(domain, first, element))
            });
            match known.and_then(|index| sets.get_mut(index)) {
                Some(set) => set.push(element),
                None => sets.push(vec![element]),
            }
        }
        let name = machine.program().symbols.domains.get(domain.0 as usize);
        let name = name.map_or_else(String::new, ToString::to_string);
        let naming = machine.naming();
        let large = sets.into_iter().filter(|set| set.len() > 1);
        let found = large.filter_map(|set| {
            let mut found = self.variables(domain, &set)?;
            found.name = if set.len() == all.len() {
                name.clone()
            } else {
                let shown = set.iter().map(|it| it.show(&naming).to_string());
                format!("{name}: {}", shown.collect::<Vec<String>>().join(", "))
            };
            Some(found)
        });
        found.collect()
    }

    /// Returns `true` if exchanging two elements changes nothing.
    fn is_unchanged(&mut self, domain: DomainId, one: &Value, other: &Value) -> bool {
        self.tried += 1;
        if self.tried > MAX_EXCHANGES {
            return false;
        }
        let Some(renaming) = self.locations.exchange(domain, one, other) else {
            return false;
        };
        let program = self.program;
        let variables = program.variables.iter().zip(&renaming.variables);
        let mut variables = variables.map(|(own, index)| {
            let other = program.variables.get(*index as usize);
            other.is_some_and(|other| {
                (own.sort, own.initial, own.is_bounded, &own.permitted)
                    == (
                        other.sort,
                        other.initial,
                        other.is_bounded,
                        &other.permitted,
                    )
            })
        });
        let mut inputs = program.inputs.iter().zip(&renaming.inputs);
        let is_alike = variables.all(|it| it)
            && inputs.all(|(own, index)| {
                let other = program.inputs.get(*index as usize);
                other.is_some_and(|other| (own.sort, &own.values) == (other.sort, &other.values))
            });
        if !is_alike {
            return false;
        }
        let same = Renaming {
            variables: (0..program.variables.len() as u32).collect(),
            inputs: (0..program.inputs.len() as u32).collect(),
        };
        let shapes = &mut self.shapes;
        shapes.rule(&program.rule, &same) == shapes.rule(&program.rule, &renaming)
            && self
                .conditions
                .iter()
                .all(|condition| shapes.term(condition, &same) == shapes.term(condition, &renaming))
    }

    /// Returns the variables of elements; `None` if there are none, or some that belong to three elements.
    fn variables(&self, domain: DomainId, set: &[&Value]) -> Option<SymmetricElements> {
        let locations = self.locations;
        let mut own: Vec<BTreeMap<LocationOf<'_>, u32>> = vec![BTreeMap::new(); set.len()];
        let mut pairs: BTreeMap<LocationOf<'_>, Vec<Vec<u32>>> = BTreeMap::new();
        let at = |value: &Value| set.iter().position(|it| *it == value);
        for (index, (function, arguments)) in (0u32..).zip(&locations.variables) {
            let positions = locations.positions(*function, domain);
            let of = |position: &usize| arguments.get(*position).and_then(at);
            let elements: Vec<(usize, usize)> = positions
                .iter()
                .filter_map(|position| Some((*position, of(position)?)))
                .collect();
            let rest = arguments.iter().enumerate();
            let rest = rest.map(|(at, it)| {
                let mut places = elements.iter().map(|(place, _)| *place);
                places.all(|place| place != at).then_some(it)
            });
            let rest = (*function, rest.collect());
            match *elements {
                [] => {}
                [(_, element)] => {
                    own.get_mut(element)?.insert(rest, index);
                }
                [(_, row), (_, column)] => {
                    let rows = pairs.entry(rest);
                    let rows = rows.or_insert_with(|| vec![vec![u32::MAX; set.len()]; set.len()]);
                    *rows.get_mut(row)?.get_mut(column)? = index;
                }
                _ => return None,
            }
        }
        let pairs: Vec<Vec<Vec<u32>>> = pairs.into_values().collect();
        let is_complete = pairs.iter().flatten().flatten().all(|it| *it != u32::MAX);
        let first = own.first()?;
        let is_even = own.iter().all(|it| it.keys().eq(first.keys()));
        (is_complete && is_even && !first.is_empty()).then(|| SymmetricElements {
            name: String::new(),
            own: own
                .iter()
                .map(|it| it.values().copied().collect())
                .collect(),
            pairs,
        })
    }
}

/// The places of what can be exchanged.
#[derive(Clone, Debug, Default)]
pub(crate) struct WordSymmetry(Vec<WordGroup>);

#[derive(Clone, Debug)]
struct WordGroup {
    /// Fields of each element.
    own: Vec<Vec<Field>>,
    /// For each function of two elements, the field of each pair.
    pairs: Vec<Vec<Vec<Field>>>,
}

impl WordSymmetry {
    /// Returns the state that stands for a state.
    pub fn canonical<const W: usize>(&self, state: &Words<W>) -> Words<W> {
        self.0
            .iter()
            .fold(*state, |state, group| group.sorted(&state))
    }
}

impl WordGroup {
    fn sorted<const W: usize>(&self, state: &Words<W>) -> Words<W> {
        let mut keys = [(0u128, 0u8); MAX_ELEMENTS];
        let Some(keys) = keys.get_mut(..self.own.len()) else {
            return *state;
        };
        for (index, (key, fields)) in keys.iter_mut().zip(&self.own).enumerate() {
            // bits beyond 128 are lost: more states are then explored than necessary
            let add = |key: u128, field: &Field| key << field.bits() | u128::from(field.get(state));
            let diagonal = self.pairs.iter();
            let diagonal = diagonal.filter_map(|rows| rows.get(index)?.get(index));
            *key = (fields.iter().chain(diagonal).fold(0, add), index as u8);
        }
        if keys.is_sorted() {
            return *state;
        }
        keys.sort_unstable();
        let mut next = *state;
        for (to, (_, from)) in self.own.iter().zip(&*keys) {
            let from = self.own.get(usize::from(*from));
            for (to, from) in to.iter().zip(from.into_iter().flatten()) {
                to.set(&mut next, from.get(state));
            }
        }
        for rows in &self.pairs {
            for (to, (_, from)) in rows.iter().zip(&*keys) {
                let from = rows.get(usize::from(*from));
                for (to, (_, column)) in to.iter().zip(&*keys) {
                    let from = from.and_then(|from| from.get(usize::from(*column)));
                    if let Some(from) = from {
                        to.set(&mut next, from.get(state));
                    }
                }
            }
        }
        next
    }
}
