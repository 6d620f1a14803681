//! Topic patterns, as in AMQP's topic exchanges: `*` matches one word, `#` any number of words.

use std::fmt;

/// A pattern for topics. Words are separated by dots: `rover1.#`, `*.estop`.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Pattern(String);

impl Pattern {
    /// Creates a pattern. Every text is valid; a topic's name matches only itself.
    pub fn new(text: impl Into<String>) -> Self {
        Self(text.into())
    }

    /// The pattern that matches all topics.
    pub fn all() -> Self {
        Self::new("#")
    }

    /// Returns whether a topic matches.
    pub fn matches(&self, topic: &str) -> bool {
        let pattern: Vec<_> = self.0.split('.').collect();
        let words: Vec<_> = topic.split('.').collect();
        matches(&pattern, &words)
    }

    /// Returns the pattern as written.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

fn matches(pattern: &[&str], words: &[&str]) -> bool {
    match (pattern, words) {
        ([], []) => true,
        (["#", rest @ ..], _) => (0..=words.len()).any(|taken| matches(rest, &words[taken..])),
        (["*", rest @ ..], [_, words @ ..]) => matches(rest, words),
        ([word, rest @ ..], [other, words @ ..]) => word == other && matches(rest, words),
        ([], [_, ..]) | ([_, ..], []) => false,
    }
}

impl fmt::Display for Pattern {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_star_is_one_word_and_a_hash_any_number() {
        for (pattern, topic, expected) in [
            ("odom", "odom", true),
            ("odom", "odometry", false),
            ("rover1.*", "rover1.odom", true),
            ("rover1.*", "rover1", false),
            ("rover1.*", "rover1.left.scan", false),
            ("*.estop", "rover1.estop", true),
            ("rover1.#", "rover1", true),
            ("rover1.#", "rover1.left.scan", true),
            ("#", "", true),
            ("#", "any.thing", true),
            ("#.scan", "rover1.left.scan", true),
            ("#.left.#", "rover1.left.scan", true),
            ("#.left.#", "rover1.right.scan", false),
            ("*.*", "rover1", false),
        ] {
            assert_eq!(
                Pattern::new(pattern).matches(topic),
                expected,
                "{pattern} on {topic}"
            );
        }
    }
}
