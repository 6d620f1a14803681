//! Names for topics of a bus among the relays that bridges announce to each other.
//!
//! A bridge that takes messages from a topic of ROS to a topic of a bus relays them, as does one that brings them back. Both
//! announce it as a relay to and from a name that stands for the topic of the bus, so that a circle that leaves ROS for a broker is
//! noticed as any other. No topic of ROS has this name.

use std::fmt::Write as _;

/// Beginning of the names.
const PREFIX: &str = "/_asmotion_bus/b";
/// Longest name; a longer one is abbreviated, and is not displayed as that of the topic.
const LONGEST: usize = 96;

/// The name for a topic of a bus. `place` identifies the broker, and what separates topics on it; `topic` is the topic with the
/// robot's name. Other words give other names.
pub fn bus_topic(place: &str, topic: &str) -> String {
    let mut name = format!("{PREFIX}{:08x}", hash(place) >> 32);
    for word in topic.split('.') {
        name.push_str("/t");
        for byte in word.bytes() {
            if byte.is_ascii_alphanumeric() && byte != b'x' {
                name.push(char::from(byte));
            } else {
                // writing to a string does not fail
                let _ = write!(name, "x{byte:02x}");
            }
        }
    }
    if name.len() > LONGEST {
        name = format!("{PREFIX}{:08x}/h{:016x}", hash(place) >> 32, hash(topic));
    }
    name
}

/// A text with topics of a bus as a person knows them, in place of names in backquotes.
pub(crate) fn readable(text: &str) -> String {
    let mut parts = text.split('`');
    let mut shown = parts.next().unwrap_or_default().to_owned();
    // between two backquotes, and after them
    while let Some(quoted) = parts.next() {
        match topic(quoted) {
            Some(topic) => shown.push_str(&format!("the topic `{topic}` of the broker")),
            None => shown.push_str(&format!("`{quoted}`")),
        }
        shown.push_str(parts.next().unwrap_or_default());
    }
    shown
}

/// The topic that a name stands for.
fn topic(name: &str) -> Option<String> {
    let (_, words) = name.strip_prefix(PREFIX)?.split_once('/')?;
    let words = words.split('/').map(|it| decoded(it.strip_prefix('t')?));
    let words: Option<Vec<String>> = words.collect();
    Some(words?.join("."))
}

fn decoded(word: &str) -> Option<String> {
    let mut bytes = Vec::new();
    let mut parts = word.split('x');
    bytes.extend(parts.next()?.bytes());
    for part in parts {
        bytes.push(u8::from_str_radix(part.get(..2)?, 16).ok()?);
        bytes.extend(part.get(2..)?.bytes());
    }
    String::from_utf8(bytes).ok()
}

/// The hash FNV-1a, which is the same in all processes.
fn hash(text: &str) -> u64 {
    let start = 0xcbf2_9ce4_8422_2325;
    text.bytes().fold(start, |hash: u64, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_topic_is_displayed_as_it_was_named() {
        for named in ["depot.map", "ex_2.a-b.ä", "x.xx", "2"] {
            let name = bus_topic("host:5672/ robots", named);
            assert!(
                name.split('/').skip(1).all(|it| !it.contains("__")),
                "{name}"
            );
            assert_eq!(topic(&name).as_deref(), Some(named), "{name}");
            let text = format!("`/a` relays `{name}` to `/b` and more");
            let shown = format!("`/a` relays the topic `{named}` of the broker to `/b` and more");
            assert_eq!(readable(&text), shown);
        }
        let name = bus_topic("host:5672", "depot.map");
        assert_eq!(name, "/_asmotion_bus/b251610a7/tdepot/tmap");
        assert_ne!(bus_topic("one", "map"), bus_topic("other", "map"));
        assert!(bus_topic("one", &"long".repeat(100)).len() <= LONGEST);
        for text in ["", "plain", "an open ` quote", "`/a`", "``"] {
            assert_eq!(readable(text).replace('`', ""), text.replace('`', ""));
        }
    }
}
