//! What the tests share: files, a build with a few components, specifications, and rendering.
#![allow(dead_code, reason = "every test binary uses a part of it")]

pub mod catalogue;
pub mod files;
pub mod render;
pub mod specification;

use asmotion_assembly::{Context, Opened, VariableSource};

pub use catalogue::SmallBuild;
pub use files::Files;

/// A few variables, and a secret.
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

/// Opens a composite of a folder with everything the tests have.
pub fn open(folder: &str, file: &str) -> Opened {
    let files = Files::new(folder);
    asmotion_assembly::open(file, &context(&files))
}

/// Everything the tests have.
pub fn context(files: &Files) -> Context<'_> {
    Context {
        loader: files,
        environment: &Variables,
        catalogue: &SmallBuild,
        specifications: files,
        settings: &[],
    }
}
