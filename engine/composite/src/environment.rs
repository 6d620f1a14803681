//! Environment variables and secrets come in through a parameter: this crate reads none itself.

/// Where `${NAME}` comes from.
pub trait VariableSource {
    /// The value of an environment variable.
    fn variable(&self, name: &str) -> Option<String>;

    /// The text of the file that a variable `${…_FILE}` names: secrets stand in files so that they
    /// do not stand in lists of processes.
    ///
    /// # Errors
    /// Why it cannot be read, for people.
    fn secret(&self, path: &str) -> Result<String, String>;
}

/// No variable is set.
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

/// Whether the value of a variable must never be shown.
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
