//! Access to environment variables and secret files, supplied by the caller; this crate reads neither itself.

/// Source of the values of `${NAME}`.
pub trait VariableSource {
    /// Returns the value of an environment variable; `None` if it is not set.
    fn variable(&self, name: &str) -> Option<String>;

    /// Returns the content of the file named by a `${…_FILE}` variable. Keeping secrets in files hides them from
    /// process listings.
    ///
    /// # Errors
    ///
    /// A human-readable reason if the file cannot be read.
    fn secret(&self, path: &str) -> Result<String, String>;
}

/// An environment without any variable.
#[derive(Clone, Copy, Debug, Default)]
pub struct EmptyEnvironment;

impl VariableSource for EmptyEnvironment {
    fn variable(&self, _: &str) -> Option<String> {
        None
    }

    fn secret(&self, _: &str) -> Result<String, String> {
        Err("secrets are not available here".to_owned())
    }
}

/// Returns whether the value of a variable is treated as a secret, judged by its name.
pub(crate) fn is_secret(variable: &str) -> bool {
    [
        "_FILE",
        "PASSWORD",
        "PASSWD",
        "SECRET",
        "TOKEN",
        "_KEY",
        "CREDENTIAL",
    ]
    .iter()
    .any(|word| variable.contains(word))
}
