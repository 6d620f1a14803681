//! Access of composites to environment variables and secret files.

use asmotion_composite::VariableSource;

/// Environment variables and secret files of the process.
#[derive(Clone, Copy, Debug, Default)]
pub struct ProcessEnvironment;

impl VariableSource for ProcessEnvironment {
    fn variable(&self, name: &str) -> Option<String> {
        std::env::var(name).ok()
    }

    fn secret(&self, path: &str) -> Result<String, String> {
        let text = std::fs::read_to_string(path).map_err(|error| error.to_string())?;
        Ok(text.trim_end_matches(['\r', '\n']).to_owned())
    }
}
