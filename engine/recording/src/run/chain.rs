//! The hash chain of a coordinator's steps.
//!
//! All hashes are the first 128 bits of SHA-256 over texts, so they are the same in every process, on every machine, and in a
//! replay. The hash of a state is the sum of the hashes of the locations that differ from the initial state: a step changes as
//! many summands as it has updates, whatever the size of the state.

use std::collections::BTreeMap;
use std::fmt;

use asmotion_coordinator::{MachineOrigin, RecordedCycle};
use serde::Deserialize;
use sha2::{Digest, Sha256};

/// The beginning of the last member of a chained record. It is the hash of the text before it.
const HASH: &str = ",\"hash\":\"";

/// The first 128 bits of a SHA-256.
#[derive(Clone, Copy, Default, PartialEq, Eq)]
struct ShortHash(u128);

impl ShortHash {
    fn of(parts: &[&str]) -> Self {
        let mut hasher = Sha256::new();
        for part in parts {
            hasher.update(part);
        }
        let digest = hasher.finalize();
        let mut first = [0; 16];
        first.copy_from_slice(&digest[..16]);
        Self(u128::from_be_bytes(first))
    }

    fn add(&mut self, other: Self) {
        self.0 = self.0.wrapping_add(other.0);
    }

    fn subtract(&mut self, other: Self) {
        self.0 = self.0.wrapping_sub(other.0);
    }
}

impl fmt::Display for ShortHash {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(to, "{:032x}", self.0)
    }
}

/// Returns the hash of a source text, which names its attachment.
pub(super) fn text_hash(text: &str) -> String {
    ShortHash::of(&[text]).to_string()
}

/// The hash of a location with a value; nothing for undef, the value of all locations that a state does not mention.
fn location_hash(location: &str, value: &str) -> ShortHash {
    match value {
        "undef" => ShortHash(0),
        value => ShortHash::of(&[location, " = ", value]),
    }
}

/// The hashes of a step.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
pub struct StepHashes {
    /// Of all inputs of the step.
    pub frame_hash: String,
    /// Of the state after the step, as far as it differs from the initial state.
    pub state_hash: String,
    /// Hash of the record before; zeros for the first one.
    pub previous: String,
    /// Hash of this record, which includes `previous`.
    pub hash: String,
}

/// Hashes the steps of a coordinator, one after the other.
#[derive(Clone, Debug, Default)]
pub struct StepChain {
    /// Hash of each input.
    inputs: BTreeMap<String, ShortHash>,
    frame: ShortHash,
    state: ShortHash,
    previous: ShortHash,
}

impl fmt::Debug for ShortHash {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, to)
    }
}

impl StepChain {
    /// Adds a record. Returns it with its hashes, as JSON on one line.
    ///
    /// # Errors
    /// The record has no form as JSON.
    pub fn link(&mut self, cycle: &RecordedCycle) -> serde_json::Result<String> {
        self.begin(cycle);
        for (location, value) in &cycle.frame {
            let hash = location_hash(location, value);
            self.frame.add(hash);
            if let Some(before) = self.inputs.insert(location.clone(), hash) {
                self.frame.subtract(before);
            }
        }
        for update in &cycle.updates {
            let location = &update.location;
            self.state.subtract(location_hash(location, &update.before));
            self.state.add(location_hash(location, &update.after));
        }
        for element in &cycle.extended {
            self.state.add(ShortHash::of(&["element ", element]));
        }
        let mut text = serde_json::to_string(cycle)?;
        // a record has members, so the brace is not the only character
        text.pop();
        let (frame, state, previous) = (self.frame, self.state, self.previous);
        text.push_str(&format!(
            ",\"frame_hash\":\"{frame}\",\"state_hash\":\"{state}\",\"previous\":\"{previous}\""
        ));
        self.previous = ShortHash::of(&[&text]);
        text.push_str(&format!("{HASH}{}\"}}", self.previous));
        Ok(text)
    }

    /// Hash of the last record.
    pub fn last(&self) -> String {
        self.previous.to_string()
    }

    /// Continues after a record with this hash, which was not linked.
    pub fn resume(&mut self, hash: &str) {
        // a text that is no hash has no successor
        self.previous = ShortHash(u128::from_str_radix(hash, 16).unwrap_or_default());
    }

    /// A new machine gets all inputs again; its state is that of its predecessor, or an initial one.
    fn begin(&mut self, cycle: &RecordedCycle) {
        let Some(begin) = cycle.begins.last() else {
            return;
        };
        self.inputs.clear();
        self.frame = ShortHash::default();
        match begin.from {
            MachineOrigin::Initial | MachineOrigin::Frozen => self.state = ShortHash::default(),
            MachineOrigin::Predecessor { .. } => {}
        }
    }
}

/// Returns whether the hash of a record is that of its text.
pub(super) fn is_intact(text: &str) -> bool {
    let Some((hashed, hash)) = text.rsplit_once(HASH) else {
        return false;
    };
    hash.strip_suffix("\"}") == Some(&*ShortHash::of(&[hashed]).to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use asmotion_coordinator::{MachineBegin, UpdateRecord};

    fn cycle(number: u64, frame: &[(&str, &str)], updates: &[(&str, &str, &str)]) -> RecordedCycle {
        let text = |it: &&str| (*it).to_owned();
        RecordedCycle {
            number,
            frame: frame.iter().map(|(a, b)| (text(a), text(b))).collect(),
            updates: updates
                .iter()
                .map(|(location, before, after)| UpdateRecord {
                    location: text(location),
                    before: text(before),
                    after: text(after),
                    place: String::new(),
                })
                .collect(),
            ..RecordedCycle::default()
        }
    }

    fn hashes(text: &str) -> StepHashes {
        serde_json::from_str(text).expect("hashes")
    }

    #[test]
    fn states_and_inputs_that_are_equal_have_equal_hashes_whatever_led_to_them() {
        let mut chain = StepChain::default();
        let mut link = |number, frame: &[_], updates: &[_]| {
            hashes(&chain.link(&cycle(number, frame, updates)).expect("JSON"))
        };
        let one = link(1, &[("go", "true")], &[("n", "0", "1"), ("m", "0", "2")]);
        let two = link(2, &[("go", "false")], &[("n", "1", "0")]);
        let three = link(3, &[("go", "true")], &[("n", "0", "1")]);
        assert_ne!(one.state_hash, two.state_hash);
        assert_ne!(one.frame_hash, two.frame_hash);
        assert_eq!(
            (one.state_hash, one.frame_hash),
            (three.state_hash.clone(), three.frame_hash)
        );
        assert_eq!((&two.previous, &three.previous), (&one.hash, &two.hash));
        // undef is the value of all locations that a state does not mention
        let four = link(4, &[], &[("new", "undef", "7")]);
        let five = link(5, &[], &[("new", "7", "undef")]);
        assert_ne!(four.state_hash, three.state_hash);
        assert_eq!(five.state_hash, three.state_hash);
    }

    /// The figures are part of the format: recordings of other versions and machines have them.
    #[test]
    fn hashes_do_not_depend_on_the_process() {
        let mut chain = StepChain::default();
        let text = chain.link(&cycle(1, &[("go", "true")], &[("n", "0", "1")]));
        let text = text.expect("JSON");
        let hashes = hashes(&text);
        // sha256("go = true"), and sha256("n = 1") - sha256("n = 0"), computed by another program
        assert_eq!(hashes.frame_hash, "505d6cda495b20dde4280d97544670b6");
        assert_eq!(hashes.state_hash, "e5c9b48dfc6e613ccf1c34b9775fe3a2");
        assert_eq!(hashes.previous, "0".repeat(32));
        assert_eq!(hashes.hash, chain.last());
    }

    #[test]
    fn an_edited_record_is_noticed() {
        let mut chain = StepChain::default();
        let text = chain.link(&cycle(1, &[("go", "true")], &[])).expect("JSON");
        assert!(is_intact(&text));
        assert!(!is_intact(&text.replace("true", "false")));
        assert!(!is_intact(&text.replace(HASH, ",\"hush\":\"")));
    }

    #[test]
    fn a_new_machine_begins_with_the_hash_of_no_difference() {
        let mut chain = StepChain::default();
        let begin = |from| RecordedCycle {
            begins: vec![MachineBegin {
                from,
                ..MachineBegin::default()
            }],
            ..cycle(1, &[("go", "true")], &[])
        };
        chain
            .link(&cycle(1, &[("go", "false")], &[("n", "0", "1")]))
            .expect("JSON");
        let frame = BTreeMap::new();
        let kept = begin(MachineOrigin::Predecessor { time_ns: 0, frame });
        let kept = hashes(&chain.link(&kept).expect("JSON"));
        let first = hashes(&chain.link(&begin(MachineOrigin::Initial)).expect("JSON"));
        assert_ne!(kept.state_hash, first.state_hash);
        assert_eq!(first.state_hash, "0".repeat(32));
        assert_eq!(kept.frame_hash, first.frame_hash);
    }
}
