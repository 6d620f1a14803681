//! Compares the values of converters of ros-bridges with the enumerations of the specifications that read or write them.

use asmotion_bridge::FieldConverter;
use asmotion_diagnostics::{Report, Span};

use super::binding::{chosen_field, literal, location};
use super::endpoints::PortDirection;
use super::scene::{CheckedComponent, CheckedComposite};
use crate::at::At;
use crate::codes::c188::UnconvertedLiteral;
use crate::finding::Findings;
use crate::model::binding::{Effect, Source};
use crate::model::{Direction, Implementation, MapEntry, MessagePath, RosEntry};
use crate::pattern::out_key;
use crate::signature::{Codomain, FunctionInfo};
use crate::table::NamedValue;

/// A converter of an enumeration on a topic of the composite.
struct Words<'c> {
    entry: &'c RosEntry,
    topic: String,
    /// Path of the field.
    path: String,
    words: Vec<String>,
    written: &'c At<String>,
}

pub(super) fn check(scene: &CheckedComposite<'_>, report: &mut Report) {
    let words = words(scene);
    if words.is_empty() {
        return;
    }
    for part in &scene.parts {
        for (topic, path, function, direction) in bound(scene, part) {
            let same = words.iter().filter(|it| {
                it.topic == topic && it.path == path && it.entry.direction.value == direction
            });
            for words in same {
                compare(words, function, direction, report);
            }
        }
    }
}

fn words<'c>(scene: &'c CheckedComposite<'_>) -> Vec<Words<'c>> {
    let mut all = Vec::new();
    for part in &scene.parts {
        for entry in &part.component.special.map {
            let MapEntry::Ros(entry) = entry else {
                continue;
            };
            let direction = match entry.direction.value {
                Direction::ToRos => PortDirection::In,
                Direction::FromRos => PortDirection::Out,
            };
            let port = part.face.port(&entry.from.value, direction);
            let Some(topic) = port.and_then(|(_, port)| port.topic.clone()) else {
                continue;
            };
            for NamedValue { name, value } in &entry.convert {
                // a wrong one has been reported
                let converter = FieldConverter::parse(name, value).ok();
                let found = converter.as_ref().and_then(FieldConverter::words);
                if let Some((path, words)) = found {
                    all.push(Words {
                        entry,
                        topic: topic.clone(),
                        path,
                        words: words.into_iter().map(str::to_owned).collect(),
                        written: value,
                    });
                }
            }
        }
    }
    all
}

/// The topics and fields that a specification reads and writes, with their functions and the direction of a bridge that has them.
fn bound<'f>(
    scene: &CheckedComposite<'f>,
    part: &CheckedComponent<'_>,
) -> Vec<(String, String, &'f FunctionInfo, Direction)> {
    let Some(Implementation::Asm { file, .. }) = &part.component.implementation else {
        return Vec::new();
    };
    let Some(signature) = scene.family.specification(scene.member, file) else {
        return Vec::new();
    };
    // what is wrong with the bindings has been reported
    let mut scratch = Report::new();
    let place = |port: &At<String>, path: Option<&MessagePath>, direction| {
        let (_, port) = part.face.port(port, direction)?;
        let kind = port.kind.as_ref();
        let schema = kind.and_then(|kind| scene.types.schema(&kind.text));
        let chosen = schema.and_then(|schema| chosen_field(&schema, &[]));
        let path = path.map(ToString::to_string).or(chosen)?;
        Some((port.topic.clone()?, path))
    };
    let mut all = Vec::new();
    for monitored in &part.bind.monitored {
        let Source::Port(port) = &monitored.from else {
            continue;
        };
        let path = monitored.field.as_ref().or(monitored.map.as_ref());
        let key = &monitored.key;
        let function = location(signature, &monitored.location, key, &mut scratch);
        let place = place(port, path, PortDirection::In);
        if let (Some(function), Some((topic, path))) = (function, place) {
            all.push((topic, path, function, Direction::FromRos));
        }
    }
    for out in &part.bind.out {
        let Effect::Publish(published) = &out.effect else {
            continue;
        };
        let function = location(signature, &out.location, out_key(out), &mut scratch);
        let place = place(
            &published.port,
            published.field.as_ref(),
            PortDirection::Out,
        );
        if let (Some(function), Some((topic, path))) = (function, place) {
            all.push((topic, path, function, Direction::ToRos));
        }
    }
    all
}

/// The place of a word in a converter; the whole converter if its text is written with escapes.
fn place(written: &At<String>, word: &str) -> Span {
    let (text, span) = (&written.value, written.span);
    let mut start = 0;
    for pair in text.split(',') {
        let here = pair.split('=').next().unwrap_or(pair);
        if here.trim() == word && span.range().len() == text.len() {
            let blanks = here.len() - here.trim_start().len();
            let start = span.range().start + start + blanks;
            return Span::new(span.file, start, start + word.len());
        }
        start += pair.len() + 1;
    }
    span
}

fn compare(words: &Words<'_>, function: &FunctionInfo, direction: Direction, report: &mut Report) {
    let Codomain::Enum { literals, .. } = &function.codomain else {
        return;
    };
    for word in &words.words {
        let written = At::new(word.clone(), place(words.written, word));
        literal(function, &written, report);
    }
    let missing = literals.iter().filter(|it| !words.words.contains(it));
    let missing: Vec<String> = missing.cloned().collect();
    // what comes from ROS can lack a value of the specification
    if direction == Direction::ToRos && !missing.is_empty() {
        report.found(UnconvertedLiteral {
            function: function.name.clone(),
            literals: missing,
            at: words.written.span,
            declared: function.declared,
        });
    }
}
