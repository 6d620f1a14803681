//! Patterns that select the ports and topics of a recording.

/// Patterns of ports and topics, and which of them have selected anything.
#[derive(Debug)]
pub(crate) struct PortPatterns(Vec<PortPattern>);

/// A pattern of ports; `*` matches any characters.
#[derive(Debug)]
struct PortPattern {
    pattern: String,
    is_matched: bool,
}

impl PortPatterns {
    /// Selects the ports and topics that match one of the patterns; without patterns, all of them.
    pub fn new(patterns: &[String]) -> Self {
        let pattern_of = |pattern: &str| PortPattern {
            pattern: pattern.to_owned(),
            is_matched: false,
        };
        Self(match patterns {
            [] => vec![pattern_of("*")],
            some => some.iter().map(|it| pattern_of(it)).collect(),
        })
    }

    /// Returns whether one of the names matches a pattern.
    pub fn select(&mut self, names: &[&str]) -> bool {
        let mut is_wanted = false;
        for wanted in &mut self.0 {
            let is_match = names.iter().any(|name| matches(&wanted.pattern, name));
            wanted.is_matched |= is_match;
            is_wanted |= is_match;
        }
        is_wanted
    }

    /// The patterns that have selected nothing.
    pub fn unmatched(&self) -> impl Iterator<Item = &str> {
        let unmatched = self.0.iter().filter(|wanted| !wanted.is_matched);
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
    use super::matches;

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
}
