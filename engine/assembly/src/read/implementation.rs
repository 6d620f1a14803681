//! `implementation`: exactly one of `rust`, `asm`, `composite`, `builtin`, `process`, `ros`, `orocos`.

use source::Span;

use super::error::ReadError;
use super::keys::Keys;
use crate::choice::Choice;
use crate::finding::Findings;
use crate::model::{Builtin, Implementation};
use crate::tree::Node;

pub(crate) fn implementation(mut keys: Keys<'_, '_, '_>) -> Option<Implementation> {
    let kinds = [
        "rust",
        "asm",
        "composite",
        "builtin",
        "process",
        "ros",
        "orocos",
    ];
    let mut found: Vec<(&'static str, Span, &Node)> = Vec::new();
    for key in kinds {
        if let Some((span, node)) = keys.entry(key) {
            found.push((key, span, node));
        }
    }
    let mut found = found.into_iter();
    let Some((kind, first_at, node)) = found.next() else {
        keys.need("rust", "\"nav::MapServer\"");
        return None;
    };
    for (second, at, _) in found {
        keys.reader.report.found(ReadError::Excluded {
            first: kind.to_owned(),
            first_at,
            second: second.to_owned(),
            at,
            reason: "a component is made of one thing",
        });
    }
    let name = keys.reader.text(kind, node, "\"nav::MapServer\"");
    Some(match kind {
        "rust" => Implementation::Rust(name?),
        "asm" => {
            let main = keys.text("main", "\"r_Main\"");
            Implementation::Asm { file: name?, main }
        }
        "composite" => Implementation::Composite(name?),
        "builtin" => {
            let target = keys.text("target", "\"youBotDriver\"");
            let bridge = keys.text("bridge", "\"ros\"");
            let port = keys.whole("port", 0..=65_535);
            let name = name?;
            let kind = Builtin::WORDS.iter().find(|(word, _)| *word == name.value);
            Implementation::Builtin {
                kind: kind.map(|(_, kind)| *kind),
                name,
                target,
                bridge,
                port,
            }
        }
        "process" => {
            let arguments = keys.texts("arguments", "[\"--verbose\"]");
            Implementation::Process {
                command: name?,
                arguments,
            }
        }
        "ros" => {
            let executable = keys.text("executable", "\"talker\"");
            Implementation::Ros {
                package: name?,
                executable,
            }
        }
        _ => {
            let name_service = keys.text("name_service", "\"corbaloc::127.0.0.1:2809\"");
            Implementation::Orocos {
                component: name?,
                name_service,
            }
        }
    })
}
