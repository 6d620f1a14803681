//! The story of a system of many components: entries beyond a number in each second are only counted.

use asmotion_component::Time;
use asmotion_plan::Plan;

use crate::style::FAINT;

/// Number of components from which on the story is limited.
const MANY: usize = 50;

/// Number of entries of a second that are reported, besides warnings.
const EACH_SECOND: usize = 20;

/// Limits the entries of a story.
#[derive(Debug, Default)]
pub(super) struct StoryLimit {
    /// The system has many components.
    is_limited: bool,
    /// The second of the last entry.
    second: i64,
    /// Number of entries in this second that were reported.
    reported: usize,
    /// Number of entries that were only counted since the last report of their number.
    hidden: usize,
}

impl StoryLimit {
    pub(super) fn of(plan: &Plan) -> Self {
        Self {
            is_limited: plan.components.len() >= MANY,
            ..Self::default()
        }
    }

    /// Returns whether an entry is reported; otherwise it is counted. Warnings always are.
    pub(super) fn admits(&mut self, is_warning: bool) -> bool {
        if !self.is_limited || is_warning {
            return true;
        }
        if self.reported < EACH_SECOND {
            self.reported += 1;
            return true;
        }
        self.hidden += 1;
        false
    }

    /// Lets time pass. Returns the number of entries of the second before that were only counted, as a line.
    pub(super) fn pass(&mut self, at: Time) -> Option<String> {
        let second = at.nanos() / 1_000_000_000;
        if second == self.second {
            return None;
        }
        (self.second, self.reported) = (second, 0);
        self.rest()
    }

    /// Returns the number of entries that were only counted, as a line.
    pub(super) fn rest(&mut self) -> Option<String> {
        let hidden = std::mem::take(&mut self.hidden);
        (hidden > 0).then(|| counted(hidden))
    }

    /// Leaves the first lines, with the number of the others.
    pub(super) fn shorten(&self, lines: &mut Vec<String>) {
        if self.is_limited && lines.len() > EACH_SECOND {
            let others = counted(lines.len() - EACH_SECOND);
            lines.truncate(EACH_SECOND);
            lines.push(others);
        }
    }
}

fn counted(entries: usize) -> String {
    let entries = match entries {
        1 => "1 entry".to_owned(),
        _ => format!("{entries} entries"),
    };
    format!(
        "{FAINT}and {entries} more of this system of many components; `--trace FILE` writes all steps{FAINT:#}"
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn entries_of_a_second_are_counted_and_warnings_remain() {
        let mut limit = StoryLimit {
            is_limited: true,
            ..StoryLimit::default()
        };
        let at = |millis| Time::ZERO + Duration::from_millis(millis);
        assert_eq!(limit.pass(at(100)), None);
        let reported = (0..100).filter(|_| limit.admits(false)).count();
        assert_eq!(reported, EACH_SECOND);
        assert!(limit.admits(true), "a warning");
        assert_eq!(limit.pass(at(900)), None);
        let line = limit.pass(at(1000)).unwrap();
        assert!(line.contains("and 80 entries"), "{line}");
        assert!(limit.admits(false), "another second");
        assert_eq!(limit.rest(), None);
    }
}
