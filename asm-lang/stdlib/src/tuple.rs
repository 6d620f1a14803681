//! Tuples: access to components by name and by position.
//!
//! A function over a product takes either the components or a single tuple of them: `first(1, 2)`
//! and `first(q)`. An `undef` component does not make the others `undef`.

use crate::argument::{TupleArguments, binary};
use crate::builtin::{Builtin, BuiltinBody, BuiltinContext, total};
use crate::fault::BuiltinFault;
use crate::sequence;
use asmotion_value::Value;

/// Returns the component at a position, counted from 0.
///
/// # Errors
/// [`BuiltinFault::Position`] if there is no such component.
#[inline]
pub fn at(components: &[Value], position: i64) -> Result<&Value, BuiltinFault> {
    sequence::at(components, position)
}

/// Returns the position of the first occurrence of a component, or -1 if there is none.
pub fn index_of(components: &[Value], component: &Value) -> i64 {
    sequence::index_of(components, component)
}

/// Body of `first` … `ninth`, given by position from 0; `undef` for `undef`.
fn component<const POSITION: usize>(
    arguments: &[Value],
    _: &mut BuiltinContext<'_>,
) -> Result<Value, BuiltinFault> {
    match arguments {
        [Value::Undef] => Ok(Value::Undef),
        [Value::Tuple(components)] => nth(components, POSITION),
        components => nth(components, POSITION),
    }
}

fn nth(components: &[Value], position: usize) -> Result<Value, BuiltinFault> {
    components
        .get(position)
        .cloned()
        .ok_or(BuiltinFault::Shape {
            expected: "a longer tuple",
            found: "one without this component",
        })
}

const AT: BuiltinBody = |arguments, _| {
    binary(
        arguments,
        |tuple: Option<TupleArguments<'_>>, position: Option<_>| {
            tuple
                .zip(position)
                .map(|(tuple, position)| at(tuple.0, position))
        },
    )
};

const INDEX_OF: BuiltinBody = |arguments, _| {
    binary(arguments, |tuple: Option<TupleArguments<'_>>, component| {
        tuple.map(|tuple| index_of(tuple.0, component))
    })
};

pub(crate) const TABLE: &[Builtin] = &[
    total("first", "Prod(D1,D2)", component::<0>),
    total("first", "Prod(D1,D2,D3)", component::<0>),
    total("first", "Prod(D1,D2,D3,D4)", component::<0>),
    total("first", "Prod(D1,D2,D3,D4,D5)", component::<0>),
    total("first", "Prod(D1,D2,D3,D4,D5,D6)", component::<0>),
    total("first", "Prod(D1,D2,D3,D4,D5,D6,D7)", component::<0>),
    total("first", "Prod(D1,D2,D3,D4,D5,D6,D7,D8)", component::<0>),
    total("first", "Prod(D1,D2,D3,D4,D5,D6,D7,D8,D9)", component::<0>),
    total("second", "Prod(D1,D2)", component::<1>),
    total("second", "Prod(D1,D2,D3)", component::<1>),
    total("second", "Prod(D1,D2,D3,D4)", component::<1>),
    total("second", "Prod(D1,D2,D3,D4,D5)", component::<1>),
    total("second", "Prod(D1,D2,D3,D4,D5,D6)", component::<1>),
    total("second", "Prod(D1,D2,D3,D4,D5,D6,D7)", component::<1>),
    total("second", "Prod(D1,D2,D3,D4,D5,D6,D7,D8)", component::<1>),
    total("second", "Prod(D1,D2,D3,D4,D5,D6,D7,D8,D9)", component::<1>),
    total("third", "Prod(D1,D2,D3)", component::<2>),
    total("third", "Prod(D1,D2,D3,D4)", component::<2>),
    total("third", "Prod(D1,D2,D3,D4,D5)", component::<2>),
    total("third", "Prod(D1,D2,D3,D4,D5,D6)", component::<2>),
    total("third", "Prod(D1,D2,D3,D4,D5,D6,D7)", component::<2>),
    total("third", "Prod(D1,D2,D3,D4,D5,D6,D7,D8)", component::<2>),
    total("third", "Prod(D1,D2,D3,D4,D5,D6,D7,D8,D9)", component::<2>),
    total("fourth", "Prod(D1,D2,D3,D4)", component::<3>),
    total("fourth", "Prod(D1,D2,D3,D4,D5)", component::<3>),
    total("fourth", "Prod(D1,D2,D3,D4,D5,D6)", component::<3>),
    total("fourth", "Prod(D1,D2,D3,D4,D5,D6,D7)", component::<3>),
    total("fourth", "Prod(D1,D2,D3,D4,D5,D6,D7,D8)", component::<3>),
    total("fourth", "Prod(D1,D2,D3,D4,D5,D6,D7,D8,D9)", component::<3>),
    total("fifth", "Prod(D1,D2,D3,D4,D5)", component::<4>),
    total("fifth", "Prod(D1,D2,D3,D4,D5,D6)", component::<4>),
    total("fifth", "Prod(D1,D2,D3,D4,D5,D6,D7)", component::<4>),
    total("fifth", "Prod(D1,D2,D3,D4,D5,D6,D7,D8)", component::<4>),
    total("fifth", "Prod(D1,D2,D3,D4,D5,D6,D7,D8,D9)", component::<4>),
    total("sixth", "Prod(D1,D2,D3,D4,D5,D6)", component::<5>),
    total("sixth", "Prod(D1,D2,D3,D4,D5,D6,D7)", component::<5>),
    total("sixth", "Prod(D1,D2,D3,D4,D5,D6,D7,D8)", component::<5>),
    total("sixth", "Prod(D1,D2,D3,D4,D5,D6,D7,D8,D9)", component::<5>),
    total("seventh", "Prod(D1,D2,D3,D4,D5,D6,D7)", component::<6>),
    total("seventh", "Prod(D1,D2,D3,D4,D5,D6,D7,D8)", component::<6>),
    total(
        "seventh",
        "Prod(D1,D2,D3,D4,D5,D6,D7,D8,D9)",
        component::<6>,
    ),
    total("eighth", "Prod(D1,D2,D3,D4,D5,D6,D7,D8)", component::<7>),
    total("eighth", "Prod(D1,D2,D3,D4,D5,D6,D7,D8,D9)", component::<7>),
    total("ninth", "Prod(D1,D2,D3,D4,D5,D6,D7,D8,D9)", component::<8>),
    total("at", "Prod(Prod(D1,D2),Natural)", AT),
    total("at", "Prod(Prod(D1,D2,D3),Natural)", AT),
    total("at", "Prod(Prod(D1,D2,D3,D4),Natural)", AT),
    total("indexOf", "Prod(Prod(D1,D2),Any)", INDEX_OF),
    total("indexOf", "Prod(Prod(D1,D2,D3),Any)", INDEX_OF),
    total("indexOf", "Prod(Prod(D1,D2,D3,D4),Any)", INDEX_OF),
];

#[cfg(test)]
mod tests {
    use crate::testing::*;
    use asmotion_value::Value;

    const NAMES: [&str; 9] = [
        "first", "second", "third", "fourth", "fifth", "sixth", "seventh", "eighth", "ninth",
    ];

    #[test]
    fn every_component_of_every_width() {
        for width in 2..=9 {
            let domains: Vec<String> = (1..=width).map(|each| format!("D{each}")).collect();
            let domain = format!("Prod({})", domains.join(","));
            let components: Vec<Value> = (1..=width).map(Value::Int).collect();
            for (name, position) in NAMES.into_iter().zip(1..=width) {
                check(name, &domain, &components, &position.to_string());
                check(
                    name,
                    &domain,
                    &[Value::tuple(components.clone())],
                    &position.to_string(),
                );
                check(name, &domain, &[UNDEF], "undef");
            }
        }
    }

    #[test]
    fn an_undefined_component_leaves_the_others() {
        check("first", "Prod(D1,D2)", &[UNDEF, int(2)], "undef");
        check("second", "Prod(D1,D2)", &[UNDEF, int(2)], "2");
        check(
            "third",
            "Prod(D1,D2,D3)",
            &[int(1), int(2)],
            "expected a longer tuple, found one without this component",
        );
    }

    #[test]
    fn positions() {
        let pair = || Value::tuple([text("a"), UNDEF]);
        let at = |tuple, position, expected| {
            check(
                "at",
                "Prod(Prod(D1,D2),Natural)",
                &[tuple, position],
                expected,
            );
        };
        at(pair(), int(0), r#""a""#);
        at(pair(), int(1), "undef");
        at(
            pair(),
            int(2),
            "position 2 of `at` is outside a length of 2",
        );
        at(pair(), UNDEF, "undef");
        at(UNDEF, int(0), "undef");
        let index_of = |tuple, component, expected| {
            check(
                "indexOf",
                "Prod(Prod(D1,D2),Any)",
                &[tuple, component],
                expected,
            );
        };
        index_of(pair(), text("a"), "0");
        index_of(pair(), UNDEF, "1");
        index_of(pair(), int(1), "-1");
        index_of(UNDEF, int(1), "undef");
    }
}
