//! Payloads of the operations of a specification, as declared by its imported modules and by the domains of its functions.

use asmotion_coordinator::{Monitored, Receive};
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

/// Returns the payloads of an operation whose requests are bound to these functions: the domain of the one that takes the
/// whole request. The reply is a record without fields.
pub(super) fn bound<'b>(
    program: &Program,
    functions: impl Iterator<Item = &'b Monitored>,
) -> OperationTypes {
    let mut whole = functions.filter(|it| takes_whole_request(it));
    let codomain = whole.find_map(|it| {
        let names = program.symbols.functions.iter();
        let mut functions = names.zip(&program.functions);
        let found = functions.find(|(name, known)| known.own && ***name == *it.location.function);
        found.map(|(_, function)| &function.codomain)
    });
    OperationTypes {
        request: codomain.map_or_else(any, |codomain| schema(codomain, program)),
        response: any(),
        one_way: false,
    }
}

/// Returns whether the value of a function is the whole request, neither a part of it nor the fact that there is one.
fn takes_whole_request(bound: &Monitored) -> bool {
    bound.receive != Receive::Edge
        && bound.field.is_none()
        && bound.map.is_none()
        && bound.key.is_empty()
        && bound.is.is_empty()
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
