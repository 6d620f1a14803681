//! Reads and resolves the values of the model other than tables.

use std::net::SocketAddr;

use asmotion_component::{
    Lock, OnDeadline, OnException, OnStale, Overrun, Scheduler, Sharing, ThreadUse,
};
use asmotion_coordinator::{PublishWhen, Receive};
use asmotion_datum::{Codec, Word};
use serde_json::{Value as Json, json};
use toml_edit::Value as Toml;

use super::component::{
    Busy, Condition, Direction, Durability, MessagePath, ProxyMode, RosReliability,
};
use super::deploy::{RecordReaders, RestartPolicy};
use super::end_text;
use super::endpoint::{Address, BridgeKind, Tls};
use super::implementation::BuiltinComponent;
use super::setting::{Amount, PropertyType, Scalar};
use super::topic::Outage;
use super::wiring::{Cancel, ConnectionType, Delivery, End, Terminal, Transport};
use crate::address::Endpoint;
use crate::at::At;
use crate::codes::c015::InvalidSetting;
use crate::codes::c016::SettingOutOfRange;
use crate::codes::c064::InvalidAddress;
use crate::end;
use crate::finding::Findings;
use crate::nearest::nearest_name;
use crate::range::Range;
use crate::table::derived::{Branch, Node, Reader};
use crate::table::{Key, Resolve, Resolver, Value, Written};
use crate::template::{Piece, Template};
use crate::value::SettingValue;

/// Words of a closed list.
macro_rules! words {
    ($($kind:ident)*) => {
        $(impl Value for $kind {
            fn schema(_: &Key) -> Json {
                words::<$kind>()
            }

            fn read(reader: &mut Reader<'_>, key: &At<String>, spec: &Key, node: &Node) -> Option<Self> {
                reader.word(key, spec, node)
            }
        }

        impl Resolve for $kind {
            type Resolved = Self;

            fn resolve(&self, _: &Key, _: &mut Resolver<'_>) -> Option<Self> {
                Some(*self)
            }
        }

        impl Written for $kind {
            fn toml(&self) -> Option<Toml> {
                Some(self.word().into())
            }
        })*
    };
}

words! {
    BridgeKind BuiltinComponent Busy Cancel Codec Delivery Direction Durability ConnectionType Lock OnDeadline OnException OnStale Outage Overrun
    ProxyMode PublishWhen Receive RecordReaders RestartPolicy RosReliability Scheduler Sharing ThreadUse Tls Transport
}

/// Documents the words, below the documentation of their key.
fn words<W: Word>() -> Json {
    let meanings = W::WORDS.iter();
    let meanings = meanings.map(|(word, _, doc)| format!("- `{word}`: {doc}"));
    let meanings: Vec<String> = meanings.collect();
    json!({ "enum": W::words(), "$comment": meanings.join("\n") })
}

/// Values written as strings.
macro_rules! texts {
    ($($kind:ty: |$reader:ident, $text:ident| $read:expr;)*) => {
        $(impl Value for $kind {
            fn schema(_: &Key) -> Json {
                json!({ "type": "string" })
            }

            fn read(
                $reader: &mut Reader<'_>,
                key: &At<String>,
                spec: &Key,
                node: &Node,
            ) -> Option<Self> {
                let $text = $reader.text(key, node, spec.example)?;
                $read
            }
        })*
    };
}

texts! {
    End: |reader, text| end_text::end(reader, &text);
    Terminal: |reader, text| end_text::terminal(reader, &text);
    MessagePath: |reader, text| end_text::path(reader, &text);
    Condition: |reader, text| Some(end_text::condition(reader, text));
}

impl Value for Template {
    fn schema(_: &Key) -> Json {
        json!({ "type": "string" })
    }

    fn read(reader: &mut Reader<'_>, key: &At<String>, spec: &Key, node: &Node) -> Option<Self> {
        reader.template(key, node, spec.example)
    }
}

impl Value for Address {
    fn schema(key: &Key) -> Json {
        Template::schema(key)
    }

    fn read(reader: &mut Reader<'_>, key: &At<String>, spec: &Key, node: &Node) -> Option<Self> {
        reader.template(key, node, spec.example).map(Self)
    }
}

/// Reads an integer or a substitution.
impl Value for Amount {
    fn schema(key: &Key) -> Json {
        json!({ "anyOf": [u64::schema(key), { "type": "string", "pattern": "\\$\\{" }] })
    }

    fn read(reader: &mut Reader<'_>, key: &At<String>, spec: &Key, node: &Node) -> Option<Self> {
        if let Branch::Text(text) = &node.value
            && text.contains("${")
        {
            reader.template(key, node, "50").map(Self::Template)
        } else {
            u64::read(reader, key, spec, node).map(Self::Number)
        }
    }
}

/// `f64`, `string[]`.
impl Value for PropertyType {
    fn schema(_: &Key) -> Json {
        let one = Scalar::words().into_iter().map(str::to_owned);
        let many = Scalar::words().into_iter().map(|word| format!("{word}[]"));
        json!({ "enum": one.chain(many).collect::<Vec<_>>() })
    }

    fn read(reader: &mut Reader<'_>, key: &At<String>, spec: &Key, node: &Node) -> Option<Self> {
        let word = reader.text(key, node, spec.example)?;
        let (scalar, list) = match word.strip_suffix("[]") {
            Some(scalar) => (scalar, true),
            None => (word.as_str(), false),
        };
        let found = Scalar::of_word(scalar);
        if found.is_none() {
            let nearest = nearest_name(scalar, Scalar::words());
            reader.unknown_word(key, &word, Scalar::words(), nearest);
        }
        found.map(|scalar| Self { scalar, list })
    }
}

/// Values identified by a string.
macro_rules! plain {
    ($($kind:ty => $resolved:ty: |$it:ident| $value:expr;)*) => {
        $(impl Resolve for $kind {
            type Resolved = $resolved;

            fn resolve(&self, _: &Key, _: &mut Resolver<'_>) -> Option<$resolved> {
                let $it = self;
                Some($value)
            }
        })*
    };
}

plain! {
    MessagePath => String: |it| it.to_string();
    Condition => String: |it| it.text.value.clone();
    End => end::End: |it| end::End {
        component: it.component.value.clone(),
        name: it.name.value.clone(),
    };
}

impl Resolve for Template {
    type Resolved = Endpoint;

    fn resolve(&self, _: &Key, to: &mut Resolver<'_>) -> Option<Endpoint> {
        let filled = to.scope.fill(self, to.notes)?;
        Some(Endpoint::new(filled.text, filled.shown))
    }
}

/// Reports an invalid address with the name of the element that `Resolver::owner` holds.
impl Resolve for Address {
    type Resolved = SocketAddr;

    fn resolve(&self, _: &Key, to: &mut Resolver<'_>) -> Option<SocketAddr> {
        let filled = to.scope.fill(&self.0, to.notes)?;
        let address = filled.text.parse().ok();
        if address.is_none() {
            to.notes.found(InvalidAddress {
                name: to.owner.clone(),
                text: filled.shown,
                at: to.at,
            });
        }
        address
    }
}

impl Resolve for Amount {
    type Resolved = u64;

    fn resolve(&self, key: &Key, to: &mut Resolver<'_>) -> Option<u64> {
        let name = key.name;
        let template = match self {
            Self::Number(number) => return Some(*number),
            Self::Template(template) => template,
        };
        let value = match template.pieces.as_slice() {
            [Piece::Property { name, span }] => to.scope.property(name, *span, to.notes)?.clone(),
            _ => SettingValue::Text(to.scope.fill(template, to.notes)?.text),
        };
        let number = match &value {
            SettingValue::Integer(number) => Some(*number),
            SettingValue::Real(number) if number.fract() == 0.0 => Some(*number as i64),
            SettingValue::Text(text) => text.trim().parse().ok(),
            SettingValue::Real(_)
            | SettingValue::Boolean(_)
            | SettingValue::Secret(_)
            | SettingValue::List(_)
            | SettingValue::Record(_) => None,
        };
        let at = Some(to.at);
        let Some(number) = number else {
            to.notes.found(InvalidSetting::WrongType {
                name: name.to_owned(),
                wanted: "an integer".to_owned(),
                found: value.describe(),
                at,
                declared: None,
            });
            return None;
        };
        if !(key.least..=key.greatest).contains(&(number as f64)) {
            let (min, max) = (Some(key.least), Some(key.greatest));
            let unit = String::new();
            to.notes.found(SettingOutOfRange {
                name: name.to_owned(),
                value: number.to_string(),
                range: Range { min, max, unit },
                at,
                declared: None,
            });
            return None;
        }
        u64::try_from(number).ok()
    }
}
