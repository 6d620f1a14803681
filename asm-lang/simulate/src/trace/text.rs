//! Values and locations in the notation of traces: without blanks, with sorted collections.

use asmotion_ir::FunctionId;
use asmotion_machine::Naming;
use asmotion_value::Value;

/// Brackets of a collection, and the order of its items: sorted by text or as given.
struct CollectionStyle {
    open: &'static str,
    close: &'static str,
    sorted: bool,
}

const TUPLE: CollectionStyle = CollectionStyle {
    open: "(",
    close: ")",
    sorted: false,
};
const SEQUENCE: CollectionStyle = CollectionStyle {
    open: "[",
    close: "]",
    sorted: false,
};
const SET: CollectionStyle = CollectionStyle {
    open: "{",
    close: "}",
    sorted: true,
};
const BAG: CollectionStyle = CollectionStyle {
    open: "<",
    close: ">",
    sorted: true,
};

pub(super) fn applied(naming: Naming<'_>, function: FunctionId, arguments: &[Value]) -> String {
    let name = &naming.program.symbols.functions[function.0 as usize];
    match arguments {
        [] => name.to_string(),
        arguments => format!("{name}{}", items(naming, arguments, &TUPLE)),
    }
}

pub(super) fn text(naming: Naming<'_>, value: &Value) -> String {
    match value {
        Value::Tuple(tuple) => items(naming, tuple.iter(), &TUPLE),
        Value::Seq(sequence) => items(naming, sequence.iter(), &SEQUENCE),
        Value::Set(elements) => set(naming, elements.iter()),
        Value::Bag(bag) => {
            let each = bag.iter();
            let each = each.flat_map(|(item, &count)| std::iter::repeat_n(item, count));
            items(naming, each, &BAG)
        }
        Value::Map(pairs) if pairs.is_empty() => "{->}".to_owned(),
        Value::Map(pairs) => {
            let pairs = pairs.iter();
            let pair = |(key, value)| format!("{}->{}", text(naming, key), text(naming, value));
            joined(pairs.map(pair).collect(), &SET)
        }
        Value::Rule(rule) => {
            let symbols = &naming.program.symbols;
            let index = rule.0 as usize;
            match (symbols.rules.get(index), symbols.rule_domains.get(index)) {
                (Some(name), Some(domains)) => format!("rule {name}({domains})"),
                _ => format!("rule {index}"),
            }
        }
        Value::Real(number) => real(number.get()),
        Value::Undef
        | Value::Bool(_)
        | Value::Int(_)
        | Value::Char(_)
        | Value::Atom(_)
        | Value::Text(_)
        | Value::Complex(_) => value.show(&naming).to_string(),
    }
}

/// Formats a set of these elements.
pub(super) fn set<'a>(naming: Naming<'_>, elements: impl IntoIterator<Item = &'a Value>) -> String {
    items(naming, elements, &SET)
}

fn items<'a>(
    naming: Naming<'_>,
    items: impl IntoIterator<Item = &'a Value>,
    shape: &CollectionStyle,
) -> String {
    let items = items.into_iter().map(|item| text(naming, item));
    joined(items.collect(), shape)
}

fn joined(mut items: Vec<String>, shape: &CollectionStyle) -> String {
    if shape.sorted {
        items.sort();
    }
    format!("{}{}{}", shape.open, items.join(","), shape.close)
}

/// Formats a number with a decimal point, also before an exponent, as other tools do.
fn real(number: f64) -> String {
    if number.is_infinite() {
        return if number > 0.0 {
            "Infinity"
        } else {
            "-Infinity"
        }
        .to_owned();
    }
    let shown = format!("{number:?}");
    let exponent = if shown.contains('.') { "E" } else { ".0E" };
    shown.replace('e', exponent)
}
