//! All resolutions of the choices of a step, one after the other.

use asmotion_lang::Chooser;

/// A sequence of choices: index and number of candidates. The last one changes first.
#[derive(Debug, Default)]
pub(super) struct ChoiceSequence {
    taken: Vec<(usize, usize)>,
    at: usize,
}

impl ChoiceSequence {
    /// Continues with the next sequence; returns `false` after the last one.
    pub fn advance(&mut self) -> bool {
        self.taken.truncate(self.at);
        self.at = 0;
        while let Some((index, count)) = self.taken.last_mut() {
            if *index + 1 < *count {
                *index += 1;
                return true;
            }
            self.taken.pop();
        }
        false
    }
}

impl Chooser for ChoiceSequence {
    fn choose(&mut self, count: usize) -> usize {
        let at = self.at;
        self.at += 1;
        if let Some((index, _)) = self.taken.get(at) {
            return *index;
        }
        self.taken.push((0, count));
        0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sequence_of_choices_is_taken_once() {
        let mut choices = ChoiceSequence::default();
        let mut seen = Vec::new();
        loop {
            // the second choice exists only after the first candidate
            let first = choices.choose(2);
            let second = (first == 0).then(|| choices.choose(3));
            seen.push((first, second));
            if !choices.advance() {
                break;
            }
        }
        assert_eq!(seen, [(0, Some(0)), (0, Some(1)), (0, Some(2)), (1, None)]);
    }
}
