//! Addresses that may contain a password.

use crate::value::REDACTED;

/// An address that may contain a password; `Debug` and `Display` mask the password.
#[derive(Clone, PartialEq, Eq)]
pub struct Endpoint {
    full: String,
    shown: String,
}

impl Endpoint {
    /// Creates an endpoint from the full address and its displayed form, whose password is masked.
    pub fn new(full: impl Into<String>, shown: impl Into<String>) -> Self {
        let shown = mask(&shown.into());
        Self {
            full: full.into(),
            shown,
        }
    }

    /// Returns the address including the password. Must not be logged.
    pub fn reveal(&self) -> &str {
        &self.full
    }

    /// Returns the address with the password masked.
    pub fn shown(&self) -> &str {
        &self.shown
    }
}

/// Masks the password in `scheme://user:password@host`.
pub(crate) fn mask(url: &str) -> String {
    match password(url) {
        Some(range) => format!("{}{REDACTED}{}", &url[..range.start], &url[range.end..]),
        None => url.to_owned(),
    }
}

/// Byte range of the password in an address.
pub fn password(url: &str) -> Option<std::ops::Range<usize>> {
    let start = url.find("://")? + 3;
    // up to the last `@`, since an unescaped `/` may occur in the password
    let at = start + url[start..].rfind('@')?;
    let colon = start + url[start..at].find(':')?;
    Some(colon + 1..at)
}

impl std::fmt::Debug for Endpoint {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.shown)
    }
}

#[cfg(test)]
mod tests {
    use super::Endpoint;

    #[test]
    fn it_never_shows_a_password() {
        let endpoint = Endpoint::new(
            "amqp://guest:geheim@host:5672/%2f",
            "amqp://guest:geheim@host:5672/%2f",
        );
        assert_eq!(format!("{endpoint:?}"), "amqp://guest:***@host:5672/%2f");
        assert_eq!(endpoint.reveal(), "amqp://guest:geheim@host:5672/%2f");
    }

    #[test]
    fn it_shows_an_address_without_a_password_as_it_is() {
        assert_eq!(
            Endpoint::new("http://a:80/x", "http://a:80/x").shown(),
            "http://a:80/x"
        );
    }
}
