//! Evaluation of SPDX licence expressions against a list of accepted licences.

use std::collections::BTreeSet;

/// Returns `true` if a licence expression is satisfied by the accepted licences. Supports `OR`,
/// `AND`, `WITH`, parentheses, and `/`, the older form of `OR`.
///
/// An expression that cannot be parsed is rejected.
pub fn accepts(allowed: &BTreeSet<String>, expression: &str) -> bool {
    let spaced = expression
        .replace('/', " OR ")
        .replace('(', " ( ")
        .replace(')', " ) ");
    let words: Vec<&str> = spaced.split_whitespace().collect();
    let mut reader = LicenceReader {
        words: &words,
        allowed,
    };
    let accepted = reader.any();
    accepted == Some(true) && reader.words.is_empty()
}

struct LicenceReader<'a> {
    words: &'a [&'a str],
    allowed: &'a BTreeSet<String>,
}

impl LicenceReader<'_> {
    fn take(&mut self, word: &str) -> bool {
        match self.words.split_first() {
            Some((first, rest)) if *first == word => {
                self.words = rest;
                true
            }
            _ => false,
        }
    }

    fn any(&mut self) -> Option<bool> {
        let mut accepted = self.all()?;
        while self.take("OR") {
            accepted |= self.all()?;
        }
        Some(accepted)
    }

    fn all(&mut self) -> Option<bool> {
        let mut accepted = self.one()?;
        while self.take("AND") {
            accepted &= self.one()?;
        }
        Some(accepted)
    }

    fn one(&mut self) -> Option<bool> {
        if self.take("(") {
            let inner = self.any()?;
            return self.take(")").then_some(inner);
        }
        let (licence, rest) = self.words.split_first()?;
        self.words = rest;
        let mut name = (*licence).to_owned();
        if self.take("WITH") {
            let (exception, rest) = self.words.split_first()?;
            self.words = rest;
            name = format!("{name} WITH {exception}");
        }
        Some(self.allowed.contains(&name))
    }
}

#[cfg(test)]
mod tests {
    use super::accepts;
    use std::collections::BTreeSet;

    #[test]
    fn expressions_are_evaluated() {
        let allowed: BTreeSet<String> = ["MIT", "ISC", "Apache-2.0 WITH LLVM-exception"]
            .map(str::to_owned)
            .into();
        for good in [
            "MIT",
            "GPL-3.0 OR MIT",
            "Apache-2.0/MIT",
            "(GPL-3.0 OR MIT) AND ISC",
            "Apache-2.0 WITH LLVM-exception",
        ] {
            assert!(accepts(&allowed, good), "{good}");
        }
        for rejected in [
            "",
            "GPL-3.0",
            "MIT AND GPL-3.0",
            "(MIT",
            "MIT OR",
            "Apache-2.0",
            "MIT ISC",
        ] {
            assert!(!accepts(&allowed, rejected), "{rejected}");
        }
    }
}
