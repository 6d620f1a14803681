//! Reads the YAML file of a ROS map.

#![expect(
    clippy::wildcard_enum_match_arm,
    reason = "the events of YAML belong to the parser's crate"
)]

use std::borrow::Cow;

use saphyr_parser::{Event, Marker, Parser, Span, StrInput};

use crate::error::{MapError, MapFault, Where};
use crate::format::MapSource;

/// The contents of the YAML file.
#[derive(Debug, PartialEq)]
pub struct MapDescription {
    /// Name of the image, relative to the YAML file.
    pub image: String,
    /// Length of a pixel, m.
    pub resolution: f64,
    /// Pose of the image's lower left corner: x and y in m, yaw in rad.
    pub origin: [f64; 3],
    /// Whether light pixels are the occupied ones.
    pub negate: bool,
    /// Pixels that are more probably occupied than this are occupied.
    pub occupied_thresh: f64,
    /// Pixels that are less probably occupied than this are free.
    pub free_thresh: f64,
    /// The meaning of the probability between the thresholds.
    pub mode: ThresholdMode,
}

/// The meaning of pixels between the thresholds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ThresholdMode {
    /// Occupied, free, and unknown between the thresholds.
    Trinary,
    /// The probability between the thresholds; transparent pixels are unknown.
    Scale,
    /// The pixel's value is the cell's.
    Raw,
}

/// The YAML parser's events, each with its place.
type Events<'t> = Parser<'t, StrInput<'t>>;

/// A fault and its place.
type Fault = (Where, MapFault);

/// The value of a key.
enum Node<'t> {
    Scalar(Cow<'t, str>),
    /// A sequence of scalars.
    Scalars(Vec<Cow<'t, str>>),
    /// A kind of value that no key of a map has.
    Other(&'static str),
}

/// A key of the file with its value.
struct Entry<'t> {
    key: Cow<'t, str>,
    at: Where,
    value: Node<'t>,
}

/// Reads the file. Ignores keys that it does not know, as map_server does.
///
/// # Errors
/// The text is not YAML, a key is missing or repeated, or a value is not allowed.
pub fn read(source: &MapSource<'_>) -> Result<MapDescription, MapError> {
    let text = source.text()?;
    let described = entries(&text).and_then(|entries| describe(&entries));
    described.map_err(|(at, fault)| source.error_at(at, fault))
}

fn describe(entries: &[Entry<'_>]) -> Result<MapDescription, Fault> {
    let mode = match optional(entries, "mode") {
        Some(entry) => entry.mode()?,
        None => ThresholdMode::Trinary,
    };
    let occupied = required(entries, "occupied_thresh")?;
    let occupied_thresh = occupied.number()?;
    if !(0.0..=1.0).contains(&occupied_thresh) {
        return Err(occupied.not_allowed("from 0 to 1"));
    }
    let free = required(entries, "free_thresh")?;
    let free_thresh = free.number()?;
    if !(0.0..=occupied_thresh).contains(&free_thresh) {
        return Err(free.not_allowed("from 0 to `occupied_thresh`"));
    }
    Ok(MapDescription {
        image: required(entries, "image")?.name()?,
        resolution: required(entries, "resolution")?.number()?,
        origin: required(entries, "origin")?.pose()?,
        negate: required(entries, "negate")?.flag()?,
        occupied_thresh,
        free_thresh,
        mode,
    })
}

fn optional<'e, 't>(entries: &'e [Entry<'t>], key: &str) -> Option<&'e Entry<'t>> {
    entries.iter().find(|entry| entry.key == key)
}

fn required<'e, 't>(entries: &'e [Entry<'t>], key: &str) -> Result<&'e Entry<'t>, Fault> {
    let missing = || syntax(Where::File, format!("the key `{key}` is missing"));
    optional(entries, key).ok_or_else(missing)
}

impl Entry<'_> {
    fn not_allowed(&self, expected: &'static str) -> Fault {
        let found = match &self.value {
            Node::Scalar(text) if text.is_empty() => "empty".to_owned(),
            Node::Scalar(text) => text.to_string(),
            Node::Scalars(elements) => format!("[{}]", elements.join(", ")),
            Node::Other(kind) => (*kind).to_owned(),
        };
        let key = self.key.to_string();
        let fault = MapFault::Value {
            key,
            found,
            expected,
        };
        (self.at.clone(), fault)
    }

    fn scalar(&self) -> Option<&str> {
        match &self.value {
            Node::Scalar(text) => Some(text),
            Node::Scalars(_) | Node::Other(_) => None,
        }
    }

    fn number(&self) -> Result<f64, Fault> {
        let number = self.scalar().and_then(finite);
        number.ok_or_else(|| self.not_allowed("a number"))
    }

    fn name(&self) -> Result<String, Fault> {
        let name = self.scalar().filter(|name| !name.is_empty());
        let name = name.map(str::to_owned);
        name.ok_or_else(|| self.not_allowed("the name of a file"))
    }

    fn pose(&self) -> Result<[f64; 3], Fault> {
        let Node::Scalars(elements) = &self.value else {
            return Err(self.not_allowed("x, y (m) and yaw (rad)"));
        };
        let numbers: Option<Vec<f64>> = elements.iter().map(|element| finite(element)).collect();
        let pose = numbers.and_then(|numbers| numbers.try_into().ok());
        pose.ok_or_else(|| self.not_allowed("x, y (m) and yaw (rad)"))
    }

    /// A Boolean of YAML 1.1, which yaml-cpp reads, or a number, which map_server of ROS 1 reads.
    fn flag(&self) -> Result<bool, Fault> {
        let flag = self
            .scalar()
            .and_then(|text| match &*text.to_ascii_lowercase() {
                "true" | "yes" | "on" | "y" => Some(true),
                "false" | "no" | "off" | "n" => Some(false),
                number => number.parse::<i64>().ok().map(|number| number != 0),
            });
        flag.ok_or_else(|| self.not_allowed("0, 1, false or true"))
    }

    fn mode(&self) -> Result<ThresholdMode, Fault> {
        match self.scalar() {
            Some("trinary") => Ok(ThresholdMode::Trinary),
            Some("scale") => Ok(ThresholdMode::Scale),
            Some("raw") => Ok(ThresholdMode::Raw),
            Some(_) | None => Err(self.not_allowed("`trinary`, `scale` or `raw`")),
        }
    }
}

/// A number in decimal notation, as YAML writes it; `.inf` and `.nan` are none.
fn finite(text: &str) -> Option<f64> {
    let decimal = text.bytes().all(|byte| b"+-.eE0123456789".contains(&byte));
    let number: Option<f64> = decimal.then(|| text.parse().ok()).flatten();
    number.filter(|number| number.is_finite())
}

fn syntax(at: Where, what: String) -> Fault {
    (at, MapFault::Syntax { what })
}

fn place(marker: &Marker) -> Where {
    Where::Line {
        line: marker.line() as u64,
        column: marker.col() as u64 + 1,
    }
}

/// The keys and values of the first document.
fn entries(text: &str) -> Result<Vec<Entry<'_>>, Fault> {
    let mut events = Parser::new_from_str(text);
    let (mut event, mut span) = next(&mut events)?;
    while matches!(event, Event::StreamStart | Event::DocumentStart(_)) {
        (event, span) = next(&mut events)?;
    }
    if !matches!(event, Event::MappingStart(..)) {
        let what = "expected keys with values, as in `image: map.png`".to_owned();
        return Err(syntax(place(&span.start), what));
    }
    let mut entries: Vec<Entry<'_>> = Vec::new();
    loop {
        let (event, span) = next(&mut events)?;
        let at = place(&span.start);
        match event {
            Event::MappingEnd | Event::StreamEnd => return Ok(entries),
            Event::Scalar(key, ..) => {
                let value = node(&mut events)?;
                if optional(&entries, &key).is_some() {
                    return Err(syntax(at, format!("the key `{key}` is repeated")));
                }
                entries.push(Entry { key, at, value });
            }
            // a key that is not a scalar, or an anchor's alias
            other => {
                skip(other, &mut events)?;
                node(&mut events)?;
            }
        }
    }
}

fn next<'t>(events: &mut Events<'t>) -> Result<(Event<'t>, Span), Fault> {
    match events.next() {
        Some(Ok(event)) => Ok(event),
        Some(Err(error)) => Err(syntax(place(error.marker()), error.info().to_owned())),
        None => Ok((Event::StreamEnd, Span::empty(Marker::new(0, 1, 0)))),
    }
}

/// Reads the value of a key.
fn node<'t>(events: &mut Events<'t>) -> Result<Node<'t>, Fault> {
    match next(events)?.0 {
        Event::Scalar(text, ..) => Ok(Node::Scalar(text)),
        Event::SequenceStart(..) => sequence(events),
        mapping @ Event::MappingStart(..) => {
            skip(mapping, events)?;
            Ok(Node::Other("a mapping"))
        }
        _ => Ok(Node::Other("an alias")),
    }
}

fn sequence<'t>(events: &mut Events<'t>) -> Result<Node<'t>, Fault> {
    let mut elements = Vec::new();
    let mut nested = false;
    loop {
        match next(events)?.0 {
            Event::SequenceEnd | Event::StreamEnd if nested => {
                return Ok(Node::Other("a nested list"));
            }
            Event::SequenceEnd | Event::StreamEnd => return Ok(Node::Scalars(elements)),
            Event::Scalar(text, ..) => elements.push(text),
            other => {
                nested = true;
                skip(other, events)?;
            }
        }
    }
}

/// Skips the rest of a node that begins with an event.
fn skip<'t>(begin: Event<'t>, events: &mut Events<'t>) -> Result<(), Fault> {
    let mut event = begin;
    let mut depth = 0_usize;
    loop {
        match event {
            Event::MappingStart(..) | Event::SequenceStart(..) => depth += 1,
            Event::MappingEnd | Event::SequenceEnd => depth = depth.saturating_sub(1),
            Event::StreamEnd => return Ok(()),
            _ => {}
        }
        if depth == 0 {
            return Ok(());
        }
        event = next(events)?.0;
    }
}
