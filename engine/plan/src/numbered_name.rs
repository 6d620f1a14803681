//! Names that differ only in a number, as those of the instances of one element of a composite do.

/// Number of such names from which they are shown as one.
pub const MANY_NUMBERED: usize = 4;

/// A name with a number in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NumberedName<'n> {
    /// The part before its first number.
    pub before: &'n str,
    digits: &'n str,
    /// The part after it.
    pub after: &'n str,
}

impl<'n> NumberedName<'n> {
    /// The parts of a name; `None` if it has no number.
    pub fn of(name: &'n str) -> Option<Self> {
        let begin = name.find(|it: char| it.is_ascii_digit())?;
        let (before, rest) = name.split_at(begin);
        let end = rest.find(|it: char| !it.is_ascii_digit());
        let (digits, after) = rest.split_at(end.unwrap_or(rest.len()));
        Some(Self {
            before,
            digits,
            after,
        })
    }

    /// Its first number; `None` if it has more than 64 bits.
    pub fn number(self) -> Option<u64> {
        self.digits.parse().ok()
    }

    /// The name that stands for those with the numbers from one to another, such as `rover1…20/goal`.
    pub fn of_range(self, (least, greatest): (u64, u64)) -> String {
        let Self { before, after, .. } = self;
        format!("{before}{least}…{greatest}{after}")
    }
}

#[cfg(test)]
mod tests {
    use super::NumberedName;

    #[test]
    fn a_name_is_divided_at_its_first_number() {
        let parts = |name| NumberedName::of(name).map(|it| (it.before, it.number(), it.after));
        assert_eq!(parts("rover12/goal3"), Some(("rover", Some(12), "/goal3")));
        assert_eq!(parts("7"), Some(("", Some(7), "")));
        assert_eq!(parts("rover"), None);
        let large = "n123456789012345678901";
        assert_eq!(parts(large), Some(("n", None, "")));
        let range = NumberedName::of("rover1/goal").map(|it| it.of_range((1, 20)));
        assert_eq!(range.as_deref(), Some("rover1…20/goal"));
    }
}
