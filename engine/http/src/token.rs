//! The token of a client.

use std::fmt;

use hyper::header::HeaderValue;

/// A secret that clients present as `Authorization: Bearer TOKEN` (RFC 6750). Never shown.
#[derive(Clone, PartialEq, Eq)]
pub struct BearerToken(String);

impl BearerToken {
    /// Wraps a token.
    pub fn new(token: impl Into<String>) -> Self {
        Self(token.into())
    }

    /// The value of the header `Authorization`; `None` if a header cannot contain the token.
    pub fn credentials(&self) -> Option<HeaderValue> {
        let mut value = HeaderValue::try_from(format!("Bearer {}", self.0)).ok()?;
        value.set_sensitive(true);
        Some(value)
    }

    /// Returns whether the credentials of a request contain this token. The time this takes depends on the length only.
    pub fn is_in(&self, credentials: &str) -> bool {
        let Some((scheme, token)) = credentials.split_once(' ') else {
            return false;
        };
        let (expected, actual) = (self.0.as_bytes(), token.trim().as_bytes());
        let pairs = expected.iter().zip(actual);
        let difference = pairs.fold(0, |difference, (left, right)| difference | (left ^ right));
        // an empty secret is a mistake, and gives access to nobody
        let is_equal = expected.len() == actual.len() && difference == 0 && !expected.is_empty();
        scheme.eq_ignore_ascii_case("Bearer") && is_equal
    }
}

impl fmt::Debug for BearerToken {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("***")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_token_is_compared_as_a_whole_and_never_shown() {
        let token = BearerToken::new("secret");
        assert!(token.is_in("Bearer secret") && token.is_in("bearer  secret"));
        for wrong in [
            "",
            "secret",
            "Bearer",
            "Bearer ",
            "Bearer secre",
            "Bearer secrets",
            "Basic secret",
        ] {
            assert!(!token.is_in(wrong), "{wrong}");
        }
        assert!(!BearerToken::new("").is_in("Bearer "));
        assert_eq!(format!("{token:?}"), "***");
    }
}
