//! Library functions of scalars over finite ranges, as tables of their values.

use crate::fold;
use crate::grounding::Grounding;
use crate::known::KnownTerm;
use crate::program::{FAULT, GroundTerm, Sort, TableIndex, UNDEF};
use crate::ranges;
use asmotion_stdlib::{Builtin, BuiltinContext};
use asmotion_value::{Atom, RuleId, Value, ValueNames};
use std::fmt;

/// Limit for the elements of a table.
const MAX_TABLE: usize = 4096;

/// Names that no grounded function depends on: a function that could is left to a machine.
struct NoNames;

impl ValueNames for NoNames {
    fn atom(&self, atom: Atom, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(to, "{}", atom.0)
    }

    fn rule(&self, rule: RuleId, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(to, "{}", rule.0)
    }
}

/// Names of the functions whose values depend on their arguments alone.
fn is_pure(builtin: &Builtin) -> bool {
    // names, time and output are no arguments
    let impure = ["toString", "print", "currTime", "random"];
    !builtin.domain.is_empty() && !impure.iter().any(|it| builtin.name.starts_with(it))
}

impl Grounding<'_> {
    /// Grounds the application of a library function.
    pub fn library(&mut self, builtin: &Builtin, arguments: Vec<KnownTerm>) -> KnownTerm {
        if !is_pure(builtin) {
            return KnownTerm::Unknown;
        }
        if let [KnownTerm::Term(term, _)] = arguments.as_slice()
            && let Some(is_undef) = definedness(builtin, term)
        {
            return KnownTerm::of(is_undef, Sort::Bool);
        }
        let mut indices = Vec::new();
        let mut domains: Vec<Vec<Value>> = Vec::new();
        let mut size = 1usize;
        for argument in arguments {
            match argument {
                KnownTerm::Value(value) => domains.push(vec![value]),
                KnownTerm::Term(term, sort) => {
                    // undef leaves the table of a strict function
                    let may_be_undef = ranges::may_be_undef(&term, &self.variables, &self.inputs);
                    let Some((low, high)) = self.bounds(&term, sort) else {
                        return KnownTerm::Unknown;
                    };
                    if may_be_undef && !builtin.strict {
                        return KnownTerm::Unknown;
                    }
                    let count = high.abs_diff(low).saturating_add(1);
                    size = size.saturating_mul(usize::try_from(count).unwrap_or(usize::MAX));
                    if size > MAX_TABLE {
                        return KnownTerm::Unknown;
                    }
                    domains.push((low..=high).map(|number| sort.value(number)).collect());
                    indices.push(TableIndex {
                        term,
                        low,
                        count: count as u32,
                        stride: 1,
                    });
                }
                KnownTerm::Tuple(_) | KnownTerm::Unknown => return KnownTerm::Unknown,
            }
        }
        let mut stride = 1u32;
        for index in indices.iter_mut().rev() {
            index.stride = stride;
            stride = stride.saturating_mul(index.count);
        }
        let results = rows(&domains).into_iter().map(|row| result(builtin, &row));
        let results: Vec<Option<Value>> = results.collect();
        if let (true, [only]) = (indices.is_empty(), results.as_slice()) {
            return only.clone().map_or(KnownTerm::Unknown, KnownTerm::Value);
        }
        let mut sort = None;
        let mut elements = Vec::new();
        for value in results {
            self.parts += 1;
            // a failing combination is left to the machine
            let number = match value.as_ref().map(Sort::number) {
                None => FAULT,
                Some(None) => return KnownTerm::Unknown,
                Some(Some((known, number))) => {
                    if known.is_some() && sort.is_some() && known != sort {
                        return KnownTerm::Unknown;
                    }
                    sort = sort.or(known);
                    number
                }
            };
            elements.push(GroundTerm::Constant(number));
        }
        let Some(sort) = sort else {
            return KnownTerm::Unknown;
        };
        KnownTerm::of(
            fold::table(indices, elements, GroundTerm::Constant(UNDEF)),
            sort,
        )
    }

    /// Returns bounds for the numbers of a term.
    fn bounds(&self, term: &GroundTerm, sort: Sort) -> Option<(i64, i64)> {
        if sort == Sort::Bool {
            return Some((0, 1));
        }
        ranges::permitted_bounds(term, &self.variables, &self.inputs)
    }
}

/// Grounds `isDef` and `isUndef`, whose argument can have any range.
fn definedness(builtin: &Builtin, argument: &GroundTerm) -> Option<GroundTerm> {
    let is_undef = || fold::equal(argument.clone(), GroundTerm::Constant(UNDEF));
    match builtin.name {
        "isUndef" => Some(is_undef()),
        "isDef" => Some(fold::not(is_undef())),
        _ => None,
    }
}

fn rows(domains: &[Vec<Value>]) -> Vec<Vec<Value>> {
    let mut rows: Vec<Vec<Value>> = vec![Vec::new()];
    for domain in domains {
        let longer = |row: &Vec<Value>, value: &Value| {
            let mut row = row.clone();
            row.push(value.clone());
            row
        };
        rows = rows
            .iter()
            .flat_map(|row| domain.iter().map(move |value| longer(row, value)))
            .collect();
    }
    rows
}

/// Returns the value of a function, `None` if its evaluation fails.
fn result(builtin: &Builtin, arguments: &[Value]) -> Option<Value> {
    if builtin.strict && arguments.iter().any(Value::is_undef) {
        return Some(Value::Undef);
    }
    let mut printed = Vec::new();
    let mut context = BuiltinContext {
        names: &NoNames,
        now_ns: 0,
        printed: &mut printed,
    };
    (builtin.body)(arguments, &mut context).ok()
}
