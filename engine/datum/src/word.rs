//! Words that files use for a few things, as in `lock = "lock_free"`.

/// A word out of a closed list. `#[derive(Word)]` of `asmotion-derive` makes it of an enum.
pub trait Word: Copy + PartialEq + 'static {
    /// How each is written, what it stands for, and what it means.
    const WORDS: &'static [(&'static str, Self, &'static str)];

    /// What a word stands for.
    fn of_word(word: &str) -> Option<Self> {
        let mut known = Self::WORDS.iter();
        known.find(|(it, _, _)| *it == word).map(|(_, it, _)| *it)
    }

    /// How it is written.
    fn word(self) -> &'static str {
        let mut known = Self::WORDS.iter();
        known
            .find(|(_, it, _)| *it == self)
            .map_or("", |(word, _, _)| word)
    }

    /// Every word, in the order of declaration.
    fn words() -> Vec<&'static str> {
        Self::WORDS.iter().map(|(word, _, _)| *word).collect()
    }
}
