//! Patterns that select the ports and topics of a recording.

/// Patterns of ports and topics, and which of them have selected anything.
#[derive(Debug)]
pub(crate) struct PortPatterns {
    /// Select everything if there are none.
    patterns: Vec<PortPattern>,
}

/// A pattern of ports; `*` matches any characters.
#[derive(Debug)]
struct PortPattern {
    pattern: String,
    is_matched: bool,
}

impl PortPatterns {
    /// Selects the ports and topics that match one of the patterns; without patterns, all of them.
    pub fn new(patterns: &[String]) -> Self {
        let pattern_of = |pattern: &String| PortPattern {
            pattern: pattern.clone(),
            is_matched: false,
        };
        Self {
            patterns: patterns.iter().map(pattern_of).collect(),
        }
    }

    /// Returns whether one of the names matches a pattern.
    pub fn select(&mut self, names: &[&str]) -> bool {
        let mut is_wanted = self.patterns.is_empty();
        for wanted in &mut self.patterns {
            let is_match = names.iter().any(|name| matches(&wanted.pattern, name));
            wanted.is_matched |= is_match;
            is_wanted |= is_match;
        }
        is_wanted
    }

    /// The patterns that have selected nothing. `*` asks for nothing in particular.
    pub fn unmatched(&self) -> impl Iterator<Item = &str> {
        let unmatched = self
            .patterns
            .iter()
            .filter(|it| !it.is_matched && it.pattern != "*");
        unmatched.map(|wanted| wanted.pattern.as_str())
    }
}

/// Matches a name against a pattern in which `*` matches any characters.
fn matches(pattern: &str, name: &str) -> bool {
    let Some((begin, rest)) = pattern.split_once('*') else {
        return pattern == name;
    };
    let Some(name) = name.strip_prefix(begin) else {
        return false;
    };
    let ends = name.char_indices().map(|(at, _)| at).chain([name.len()]);
    ends.into_iter().any(|at| matches(rest, &name[at..]))
}

#[cfg(test)]
mod tests {
    use super::{PortPatterns, matches};

    #[test]
    fn a_star_is_any_run_of_characters() {
        for (pattern, fits) in [
            ("Driver.status", true),
            ("Driver.*", true),
            ("*.status", true),
            ("D*r.s*s", true),
            ("*", true),
            ("**", true),
            ("Driver", false),
            ("*.statu", false),
            ("", false),
        ] {
            assert_eq!(matches(pattern, "Driver.status"), fits, "{pattern}");
        }
    }

    #[test]
    fn without_patterns_everything_is_selected_and_none_is_in_vain() {
        let mut patterns = PortPatterns::new(&[]);
        assert_eq!(patterns.unmatched().count(), 0);
        assert!(patterns.select(&["Driver.status"]));
        let named = ["*", "*.scan", "Driver.*"].map(str::to_owned);
        let mut patterns = PortPatterns::new(&named);
        assert_eq!(patterns.unmatched().count(), 2);
        assert!(patterns.select(&["Driver.status"]));
        assert_eq!(patterns.unmatched().collect::<Vec<_>>(), ["*.scan"]);
    }
}
