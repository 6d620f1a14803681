//! Payloads of the operations of a specification, as declared by its imported modules.

use asmotion_datum::{Schema, Shape as Data};
use asmotion_lang::ir::{DomainId, Elements, Program, Shape};

/// Request, response and kind of an operation.
pub(super) struct Spoken {
    pub request: Schema,
    pub response: Schema,
    pub one_way: bool,
}

/// Returns the payloads of an operation served by a specification.
pub(super) fn operation(program: &Program, name: &str) -> Spoken {
    let operation = program.operation(name);
    Spoken {
        request: schema(&operation.takes, program),
        response: schema(&operation.gives, program),
        one_way: !operation.replies,
    }
}

/// Schema of values of a shape: literals by name, tuples as lists.
fn schema(shape: &Shape, program: &Program) -> Schema {
    Schema::plain(match shape {
        Shape::Bool => Data::Bool,
        Shape::Int => Data::I64,
        Shape::Natural => Data::U64,
        Shape::Real => Data::F64,
        Shape::Char | Shape::Text | Shape::Complex | Shape::Rule => Data::Text,
        Shape::Domain(domain) => return of_domain(*domain, program),
        Shape::Tuple(items) => {
            let mut schemas = items.iter().map(|item| schema(item, program));
            let first = schemas.next().unwrap_or_else(any);
            let same = schemas.all(|schema| schema == first);
            let element = if same { first } else { any() };
            return Schema::many(element, Some(items.len()));
        }
        Shape::Seq(item) | Shape::Set(item) | Shape::Bag(item) => {
            return Schema::many(schema(item, program), None);
        }
        Shape::Map(..) | Shape::Any => return any(),
    })
}

fn of_domain(domain: DomainId, program: &Program) -> Schema {
    let domain = program.domains.get(domain.0 as usize);
    match domain.map(|domain| &domain.elements) {
        Some(Elements::Atoms { .. }) => Schema::plain(Data::Text),
        Some(Elements::Ints { .. }) => Schema::plain(Data::I64),
        Some(Elements::Computed(_) | Elements::Undefined | Elements::Open) | None => any(),
    }
}

fn any() -> Schema {
    Schema::plain(Data::Any)
}
