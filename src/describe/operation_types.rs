//! Payloads of the operations of a specification, as declared by its imported modules.

use asmotion_datum::{Schema, Shape as Data};
use asmotion_lang::ir::{DomainElements, DomainId, Program, ValueShape};

/// Request, response and kind of an operation.
pub(super) struct OperationTypes {
    pub request: Schema,
    pub response: Schema,
    pub one_way: bool,
}

/// Returns the payloads of an operation served by a specification.
pub(super) fn operation(program: &Program, name: &str) -> OperationTypes {
    let operation = program.operation(name);
    OperationTypes {
        request: schema(&operation.takes, program),
        response: schema(&operation.gives, program),
        one_way: !operation.replies,
    }
}

/// Schema of values of a shape: literals by name, tuples as lists.
fn schema(shape: &ValueShape, program: &Program) -> Schema {
    Schema::plain(match shape {
        ValueShape::Bool => Data::Bool,
        ValueShape::Int => Data::I64,
        ValueShape::Natural => Data::U64,
        ValueShape::Real => Data::F64,
        ValueShape::Char | ValueShape::Text | ValueShape::Complex | ValueShape::Rule => Data::Text,
        ValueShape::Domain(domain) => return of_domain(*domain, program),
        ValueShape::Tuple(items) => {
            let mut schemas = items.iter().map(|item| schema(item, program));
            let first = schemas.next().unwrap_or_else(any);
            let same = schemas.all(|schema| schema == first);
            let element = if same { first } else { any() };
            return Schema::many(element, Some(items.len()));
        }
        ValueShape::Seq(item) | ValueShape::Set(item) | ValueShape::Bag(item) => {
            return Schema::many(schema(item, program), None);
        }
        ValueShape::Map(..) | ValueShape::Any => return any(),
    })
}

fn of_domain(domain: DomainId, program: &Program) -> Schema {
    let domain = program.domains.get(domain.0 as usize);
    match domain.map(|domain| &domain.elements) {
        Some(DomainElements::Atoms { .. }) => Schema::plain(Data::Text),
        Some(DomainElements::Ints { .. }) => Schema::plain(Data::I64),
        Some(DomainElements::Computed(_) | DomainElements::Undefined | DomainElements::Open)
        | None => any(),
    }
}

fn any() -> Schema {
    Schema::plain(Data::Any)
}
