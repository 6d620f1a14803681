//! Environment variables of the tests.

use asmotion_composite::VariableSource;

/// An environment with a few variables and a secret.
pub struct Variables;

impl VariableSource for Variables {
    fn variable(&self, name: &str) -> Option<String> {
        match name {
            "ROBOT_USER" => Some("robot".to_owned()),
            "ROBOT_PASSWORD_FILE" => Some("/run/secrets/robot".to_owned()),
            "ROBOT_MISSING_FILE" => Some("/run/secrets/missing".to_owned()),
            "ROBOT_PERIOD" => Some("40".to_owned()),
            _ => None,
        }
    }

    fn secret(&self, path: &str) -> Result<String, String> {
        match path {
            "/run/secrets/robot" => Ok("geheim\n".to_owned()),
            _ => Err("no such file".to_owned()),
        }
    }
}
