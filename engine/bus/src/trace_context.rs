//! Traces: the causal relation between messages (W3C Trace Context).
//!
//! Ids are derived from the message's identity, never random: equal runs have equal ids.

use std::fmt;
use std::str::FromStr;

/// Position of a message in a trace. Its text form is that of the header `traceparent`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TraceContext {
    /// Trace id, shared by all messages of the trace. Not zero.
    pub id: u128,
    /// Span id of this message. Not zero.
    pub span: u64,
}

impl fmt::Display for TraceContext {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "00-{:032x}-{:016x}-01", self.id, self.span)
    }
}

/// The text is not a W3C `traceparent`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("not a W3C `traceparent`")]
pub struct InvalidTraceparent;

impl FromStr for TraceContext {
    type Err = InvalidTraceparent;

    /// Accepts additional parts at the end, which later versions may have.
    fn from_str(text: &str) -> Result<Self, InvalidTraceparent> {
        read(text).ok_or(InvalidTraceparent)
    }
}

fn read(text: &str) -> Option<TraceContext> {
    let mut parts = text.split('-');
    let mut hex = |length: usize| {
        let lower = |byte: u8| byte.is_ascii_digit() || (b'a'..=b'f').contains(&byte);
        let part = parts.next()?;
        (part.len() == length && part.bytes().all(lower)).then_some(part)
    };
    let version = hex(2)?;
    let id = u128::from_str_radix(hex(32)?, 16).ok()?;
    let span = u64::from_str_radix(hex(16)?, 16).ok()?;
    hex(2)?;
    let more = parts.next().is_some();
    let known = version != "ff" && (version != "00" || !more);
    (known && id != 0 && span != 0).then_some(TraceContext { id, span })
}

/// Generates the span ids of one sender's messages.
#[derive(Debug, Clone, Copy)]
pub struct SpanGenerator {
    seed: u64,
}

impl SpanGenerator {
    /// Creates the generator of one sender, from its name, the number of its process's run, and the topic or address
    /// it sends to.
    pub fn new(source: &str, incarnation: u64, to: &str) -> Self {
        let seed = [source.as_bytes(), &incarnation.to_le_bytes(), to.as_bytes()]
            .into_iter()
            .fold(0xcbf2_9ce4_8422_2325, |hash, part| {
                // FNV-1a over each part and its length, so that adjacent parts do not run together
                let bytes = part.iter().fold(hash, |hash: u64, byte| {
                    (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3)
                });
                mixed(bytes ^ part.len() as u64)
            });
        Self { seed }
    }

    /// The trace context of the message with this number: in the trace of its cause, or at the beginning of a new one.
    pub fn of(self, number: u64, cause: Option<TraceContext>) -> TraceContext {
        let span = mixed(self.seed ^ mixed(number)).max(1);
        let first = || (u128::from(mixed(span)) << 64) | u128::from(span);
        TraceContext {
            id: cause.map_or_else(first, |cause| cause.id),
            span,
        }
    }
}

/// The finalizer of SplitMix64: every bit of the result depends on every bit of the value.
fn mixed(value: u64) -> u64 {
    let value = value.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let value = (value ^ (value >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let value = (value ^ (value >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    value ^ (value >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    const EXAMPLE: &str = "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01";

    #[test]
    fn it_is_read_and_written_as_w3c_has_it() {
        let trace: TraceContext = EXAMPLE.parse().unwrap();
        assert_eq!(trace.span, 0x00f0_67aa_0ba9_02b7);
        assert_eq!(trace.to_string(), EXAMPLE);
        let later = format!("cc{}-what-comes", &EXAMPLE[2..]);
        assert_eq!(later.parse(), Ok(trace));
        let nothing = format!("00-{:032x}-00f067aa0ba902b7-01", 0);
        let wrong = ["", "00", &EXAMPLE[1..], &EXAMPLE.to_uppercase(), &nothing];
        for wrong in wrong.into_iter().chain([&*format!("{EXAMPLE}-more")]) {
            assert_eq!(
                wrong.parse::<TraceContext>(),
                Err(InvalidTraceparent),
                "{wrong}"
            );
        }
    }

    #[test]
    fn its_ids_follow_from_the_message_and_its_cause() {
        let spans = SpanGenerator::new("Planner", 7, "path");
        let first = spans.of(1, None);
        assert_eq!(first, SpanGenerator::new("Planner", 7, "path").of(1, None));
        let others = [
            spans.of(2, None),
            SpanGenerator::new("Planner", 8, "path").of(1, None),
            SpanGenerator::new("Planne", 7, "rpath").of(1, None),
        ];
        for other in others {
            assert!(other.id != first.id && other.span != first.span);
        }
        let next = SpanGenerator::new("Follower", 7, "twist").of(1, Some(first));
        assert_eq!(next.id, first.id);
        assert_ne!(next.span, first.span);
    }
}
