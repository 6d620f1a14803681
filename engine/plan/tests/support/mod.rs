//! What the tests share: files, a build with a few components, specifications, and rendering.
#![allow(dead_code, reason = "every test binary uses a part of it")]

pub mod catalogue;
pub mod files;
pub mod render;
pub mod specification;
pub mod variables;

use asmotion_composite::Context;
use asmotion_plan::Opened;

pub use catalogue::SmallBuild;
pub use files::Files;
pub use variables::Variables;

/// Opens a composite of a folder with everything the tests have.
pub fn open(folder: &str, file: &str) -> Opened {
    let files = Files::new(folder);
    asmotion_plan::open(file, &context(&files))
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
