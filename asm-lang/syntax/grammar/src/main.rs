//! Generates the parser of `asmotion-syntax` from its grammar: `cargo run -p asmotion-grammar`.
#![expect(
    clippy::disallowed_methods,
    reason = "a developer tool; only the language itself must not access files"
)]
//!
//! The generated parser is part of the repository, so that building asmotion does not need LALRPOP.
//! A test keeps the two in agreement. This is a crate of its own because it must also run while the
//! old parser does not compile.

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};

fn main() -> Result<(), Box<dyn Error>> {
    fs::write(source("grammar.rs"), generate(&source("grammar.lalrpop"))?)?;
    Ok(())
}

/// Returns the path of a source file of `asmotion-syntax`.
fn source(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../src");
    folder.join(name)
}

/// Runs LALRPOP on a grammar and returns the parser.
fn generate(grammar: &Path) -> Result<String, Box<dyn Error>> {
    let folder = tempfile::tempdir()?;
    fs::copy(grammar, folder.path().join("grammar.lalrpop"))?;
    lalrpop::Configuration::new()
        .set_in_dir(folder.path())
        .set_out_dir(folder.path())
        .emit_comments(false)
        .emit_whitespace(false)
        .log_quiet()
        .process()?;
    Ok(fs::read_to_string(folder.path().join("grammar.rs"))?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_parser_is_that_of_the_grammar() {
        let expected = generate(&source("grammar.lalrpop")).unwrap();
        let found = fs::read_to_string(source("grammar.rs")).unwrap();
        assert!(
            found == expected,
            "the parser is out of date: regenerate it with `cargo run -p asmotion-grammar`"
        );
    }
}
