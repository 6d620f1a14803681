//! The binding of a specification.

use toml_edit::{Array, InlineTable, Item, Table, Value as Toml};

use super::write::{Keys, inline, value};
use crate::value::{REDACTED, Value};
use asmotion_coordinator::{Action, Argument, Binding, Call, Constant, Effect, Monitored, Source};
use asmotion_datum::Datum;

pub(super) fn bind(binding: &Binding) -> Table {
    let mut monitored = Table::new();
    for it in &binding.monitored {
        monitored.insert(
            &it.function,
            Item::Value(inline(self::monitored(it)).into()),
        );
    }
    let mut out = Table::new();
    // the functions with literals come last: they are tables of their own
    let (plain, literals): (Vec<_>, Vec<_>) =
        (binding.out.iter()).partition(|it| matches!(it.effect, Effect::Publish { .. }));
    for it in plain.into_iter().chain(literals) {
        out.insert(&it.function, effect(&it.effect));
    }
    let mut bind = Table::new();
    bind.set_implicit(true);
    for (key, table) in [("monitored", monitored), ("out", out)] {
        if !table.is_empty() {
            bind.insert(key, Item::Table(table));
        }
    }
    bind
}

fn monitored(monitored: &Monitored) -> Keys {
    let mut keys = Keys::new();
    match &monitored.from {
        Source::Port(port) => keys.text("topic", port),
        Source::Request { service, operation } => {
            keys.text("service", &format!("{service}.{operation}"));
        }
    }
    keys.word("receive", monitored.receive);
    keys.texts("field", monitored.field.iter());
    keys.texts("map", monitored.map.iter());
    if !monitored.is.is_empty() {
        keys.put("is", monitored.is.iter().collect::<Array>());
    }
    if let Some(none) = &monitored.none {
        keys.put("none", constant(none));
    }
    keys.wholes("stale_ms", monitored.stale_ms);
    if let Some(on_stale) = &monitored.on_stale {
        keys.put("on_stale", constant(on_stale));
    }
    keys
}

fn effect(effect: &Effect) -> Item {
    match effect {
        Effect::Publish { port, field, when } => {
            let mut keys = Keys::new();
            keys.text("topic", port);
            keys.texts("field", field.iter());
            keys.word("publish", *when);
            Item::Value(inline(keys).into())
        }
        Effect::Literals(cases) => {
            let mut table = Table::new();
            for case in cases {
                let actions: Vec<Toml> = case.actions.iter().map(action).collect();
                let actions = match actions.as_slice() {
                    [only] => only.clone(),
                    _ => Toml::Array(actions.into_iter().collect::<Array>()),
                };
                table.insert(&case.literal, Item::Value(actions));
            }
            Item::Table(table)
        }
    }
}

fn action(action: &Action) -> Toml {
    let mut keys = Keys::new();
    match action {
        Action::Call(call) => self::call(call, &mut keys),
        Action::Publish { port, value } => {
            keys.text("publish", port);
            keys.put("value", argument(value));
        }
    }
    inline(keys).into()
}

fn call(call: &Call, keys: &mut Keys) {
    keys.text("call", &format!("{}.{}", call.reference, call.operation));
    if call.with != Argument::Default {
        keys.put("with", argument(&call.with));
    }
    keys.texts("keep", call.keep.iter());
    keys.texts("ok", call.ok.iter());
    keys.texts("failed", call.failed.iter());
    keys.texts("timeout", call.timeout.iter());
    keys.texts("unavailable", call.unavailable.iter());
    keys.texts("event", call.event.iter());
    keys.texts("reply", call.reply.iter());
}

fn argument(argument: &Argument) -> Toml {
    match argument {
        Argument::Default => InlineTable::new().into(),
        Argument::Kept { name, path: None } => format!("@{name}").into(),
        Argument::Kept {
            name,
            path: Some(path),
        } => format!("@{name}.{path}").into(),
        Argument::Record(fields) => {
            let fields = fields.iter();
            let fields = fields.map(|(name, field)| (name.clone(), self::argument(field)));
            Toml::InlineTable(fields.collect())
        }
        // a text that begins with `@` is no kept reply
        Argument::Value(Constant {
            datum: Datum::Text(text),
            secret: false,
        }) if text.starts_with('@') => format!("@{text}").into(),
        Argument::Value(plain) => constant(plain),
    }
}

/// A constant, secrets left out.
fn constant(constant: &Constant) -> Toml {
    let shown = || Value::of_datum(&constant.datum);
    match (constant.secret, shown()) {
        (false, Some(shown)) => value(&shown),
        (true, _) | (_, None) => REDACTED.into(),
    }
}
