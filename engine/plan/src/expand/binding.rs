//! Serialises the bindings of an ASM component.

use toml_edit::{Array, InlineTable, Item, Table, Value as Toml};

use asmotion_composite::table::{Lines, constant};
use asmotion_coordinator::{Action, Argument, Binding, Call, Constant, Effect, Monitored, Source};
use asmotion_datum::Datum;

pub(super) fn bind(binding: &Binding) -> Table {
    let mut monitored = Table::new();
    for it in &binding.monitored {
        monitored.insert(&it.function, Item::Value(inline(self::monitored(it))));
    }
    let mut out = Table::new();
    // functions with actions per literal come last, since each is a table of its own
    let (plain, literals): (Vec<_>, Vec<_>) = binding
        .out
        .iter()
        .partition(|it| matches!(it.effect, Effect::Publish { .. }));
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

fn monitored(monitored: &Monitored) -> Lines {
    let mut keys = Lines::new();
    match &monitored.from {
        Source::Port(port) => keys.put("topic", port),
        Source::Request { service, operation } => {
            keys.put("service", &format!("{service}.{operation}"));
        }
    }
    keys.put("receive", &monitored.receive);
    keys.put("field", &monitored.field);
    keys.put("map", &monitored.map);
    keys.put("is", &monitored.is);
    keys.put("none", &monitored.none);
    keys.put("stale_ms", &monitored.stale_ms);
    keys.put("on_stale", &monitored.on_stale);
    keys
}

fn effect(effect: &Effect) -> Item {
    match effect {
        Effect::Publish { port, field, when } => {
            let mut keys = Lines::new();
            keys.put("topic", port);
            keys.put("field", field);
            keys.put("publish", when);
            Item::Value(inline(keys))
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
    let mut keys = Lines::new();
    match action {
        Action::Call(call) => self::call(call, &mut keys),
        Action::Publish { port, value } => {
            keys.put("publish", port);
            keys.put_some("value", Some(argument(value)));
        }
    }
    inline(keys)
}

fn call(call: &Call, keys: &mut Lines) {
    keys.put("call", &format!("{}.{}", call.reference, call.operation));
    if call.with != Argument::Default {
        keys.put_some("with", Some(argument(&call.with)));
    }
    keys.put("keep", &call.keep);
    keys.put("ok", &call.ok);
    keys.put("failed", &call.failed);
    keys.put("timeout", &call.timeout);
    keys.put("unavailable", &call.unavailable);
    keys.put("event", &call.event);
    keys.put("reply", &call.reply);
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
        // escape a leading `@`, which denotes a kept reply
        Argument::Value(Constant {
            datum: Datum::Text(text),
            secret: false,
        }) if text.starts_with('@') => format!("@{text}").into(),
        Argument::Value(plain) => constant(plain),
    }
}

fn inline(keys: Lines) -> Toml {
    keys.inline().unwrap_or_else(|| InlineTable::new().into())
}
