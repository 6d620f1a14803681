//! Names of nodes, topics, services and parameters. Source: the ROS wiki, "Names".

use std::fmt;

/// A global name: `/robot/odom`.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct RosName(std::sync::Arc<str>);

/// A text is not a name.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is not a name of ROS: letters, digits, `_` and `/`, and first a letter, `/` or `~`")]
pub struct RosNameError(String);

impl RosName {
    /// The name of a node, whose namespace is `/` unless the name says otherwise.
    ///
    /// # Errors
    /// The text is not a name, or is a private one.
    pub fn node(text: &str) -> Result<Self, RosNameError> {
        if text.starts_with('~') {
            return Err(RosNameError(text.to_owned()));
        }
        Self::global(text, &format!("/{}", text.trim_start_matches('/')))
    }

    /// A name as this node means it: `/global`, `relative` to the namespace of the node, or `~private` to the node.
    ///
    /// # Errors
    /// The text is not a name.
    pub fn resolve(&self, text: &str) -> Result<Self, RosNameError> {
        let whole = if let Some(private) = text.strip_prefix('~') {
            format!("{self}/{}", private.trim_start_matches('/'))
        } else if text.starts_with('/') {
            text.to_owned()
        } else {
            let (namespace, _) = self.0.rsplit_once('/').unwrap_or_default();
            format!("{namespace}/{text}")
        };
        Self::global(text, &whole)
    }

    fn global(text: &str, whole: &str) -> Result<Self, RosNameError> {
        let wrong = || RosNameError(text.chars().take(200).collect());
        let trimmed = whole.strip_suffix('/').unwrap_or(whole);
        let words = trimmed.strip_prefix('/').ok_or_else(wrong)?.split('/');
        let is_word = |word: &str| {
            let is_sign = |sign: char| sign.is_ascii_alphanumeric() || sign == '_';
            !word.is_empty() && word.chars().all(is_sign)
        };
        let first = text.trim_start_matches(['/', '~']).chars().next();
        let begins = first.is_some_and(|sign| sign.is_ascii_alphabetic() || sign == '_');
        if !begins || !words.clone().all(is_word) || trimmed.len() > 255 {
            return Err(wrong());
        }
        Ok(Self(trimmed.into()))
    }

    /// The name.
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// The name, shared.
    pub fn shared(&self) -> std::sync::Arc<str> {
        std::sync::Arc::clone(&self.0)
    }
}

impl fmt::Display for RosName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_resolved_as_roscpp_does() {
        let node = RosName::node("robot/driver").unwrap();
        assert_eq!(node.as_str(), "/robot/driver");
        for (text, whole) in [
            ("odom", "/robot/odom"),
            ("/odom", "/odom"),
            ("~speed", "/robot/driver/speed"),
            ("arm/joint_1/", "/robot/arm/joint_1"),
        ] {
            assert_eq!(node.resolve(text).unwrap().as_str(), whole);
        }
        for text in ["", "/", "~", "a//b", "1a", "a b", "é", "/a/~b"] {
            assert!(node.resolve(text).is_err(), "{text}");
        }
        assert!(RosName::node("~a").is_err());
        assert_eq!(
            RosName::node("a").unwrap().resolve("b").unwrap().as_str(),
            "/b"
        );
    }
}
