//! Words: enum values as written in files, for example `lock = "lock_free"`.

/// A value from a closed list of words. `#[derive(Word)]` of `asmotion-derive` implements it for enums.
pub trait Word: Copy + PartialEq + 'static {
    /// All words with their values and descriptions, in order of declaration.
    const WORDS: &'static [(&'static str, Self, &'static str)];

    /// The value that a word stands for.
    fn of_word(word: &str) -> Option<Self> {
        let mut known = Self::WORDS.iter();
        known.find(|(it, _, _)| *it == word).map(|(_, it, _)| *it)
    }

    /// The word for this value.
    fn word(self) -> &'static str {
        let mut known = Self::WORDS.iter();
        known
            .find(|(_, it, _)| *it == self)
            .map_or("", |(word, _, _)| word)
    }

    /// All words, in order of declaration.
    fn words() -> Vec<&'static str> {
        Self::WORDS.iter().map(|(word, _, _)| *word).collect()
    }
}
