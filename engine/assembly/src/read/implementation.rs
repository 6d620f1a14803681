//! `implementation`: exactly one of `rust`, `asm`, `composite`, `builtin`, `process`, `ros`, `orocos`.

use super::keys::Keys;
use crate::model::{Builtin, Implementation};
use asmotion_datum::Word;

const KINDS: &[&str] = &[
    "rust",
    "asm",
    "composite",
    "builtin",
    "process",
    "ros",
    "orocos",
];

pub(crate) fn implementation(mut keys: Keys<'_, '_, '_>) -> Option<Implementation> {
    let reason = "a component is made of one thing";
    let (kind, name) = keys.one_of(KINDS, "\"nav::MapServer\"", reason)?;
    Some(match kind {
        "rust" => Implementation::Rust(name),
        "asm" => {
            let main = keys.text("main", "\"r_Main\"");
            Implementation::Asm { file: name, main }
        }
        "composite" => Implementation::Composite(name),
        "builtin" => {
            let target = keys.text("target", "\"youBotDriver\"");
            let bridge = keys.text("bridge", "\"ros\"");
            let port = keys.whole("port", 0..=65_535);
            Implementation::Builtin {
                kind: Builtin::of_word(&name.value),
                name,
                target,
                bridge,
                port,
            }
        }
        "process" => {
            let arguments = keys.texts("arguments", "[\"--verbose\"]");
            Implementation::Process {
                command: name,
                arguments,
            }
        }
        "ros" => {
            let executable = keys.text("executable", "\"talker\"");
            Implementation::Ros {
                package: name,
                executable,
            }
        }
        _ => {
            let name_service = keys.text("name_service", "\"corbaloc::127.0.0.1:2809\"");
            Implementation::Orocos {
                component: name,
                name_service,
            }
        }
    })
}
