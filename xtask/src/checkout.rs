//! The Rust sources of one revision, parsed.

use crate::test_code::TestLines;
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

/// Folders that hold no source of ours.
const SKIPPED: &[&str] = &["target", "node_modules"];

/// Files that a program writes.
const GENERATED: &[&str] = &["asm-lang/syntax/src/grammar.rs"];

/// Folders whose code is compiled for tests or benchmarks only.
const TEST_FOLDERS: &[&str] = &["tests", "benches", "examples", "fuzz"];

/// The sources could not be read.
#[derive(Debug, thiserror::Error)]
pub enum CheckoutError {
    /// A file or folder cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// Which one.
        path: PathBuf,
        /// The operating system's reason.
        source: std::io::Error,
    },
    /// A file is not Rust.
    #[error("{}: {source}", path.display())]
    Parse {
        /// The file.
        path: PathBuf,
        /// The parser's reason.
        source: syn::Error,
    },
    /// `git` or `tar` failed.
    #[error("{command}: {message}")]
    Command {
        /// The command line.
        command: String,
        /// Its error output.
        message: String,
    },
}

/// A parsed source file.
pub struct SourceFile {
    /// Relative to the root of the repository, with `/`.
    pub path: String,
    /// The whole text.
    pub text: String,
    /// Its syntax tree; spans have line numbers.
    pub tree: syn::File,
    /// Lines compiled for tests only.
    pub tests: TestLines,
    /// Lines inside a string literal of several lines: code, whatever they look like.
    pub literal: Vec<std::ops::RangeInclusive<usize>>,
}

impl SourceFile {
    /// Whether a line, counted from 1, is compiled for tests only.
    pub fn is_test(&self, line: usize) -> bool {
        self.tests.contains(line)
    }

    /// The folder at the top of the repository: `engine`, `src`.
    pub fn wing(&self) -> &str {
        self.path.split('/').next().unwrap_or_default()
    }
}

/// A package of the repository.
#[derive(Debug)]
pub struct CrateDir {
    /// The package's name.
    pub name: String,
    /// Its folder relative to the root; empty for the root package.
    pub folder: String,
}

/// The sources of one revision.
pub struct Checkout {
    /// Where the files are.
    pub root: PathBuf,
    /// Sorted by path.
    pub files: Vec<SourceFile>,
    /// Sorted by folder.
    pub crates: Vec<CrateDir>,
    /// Removes the extracted files when the checkout is dropped.
    _extracted: Option<TempDir>,
}

impl Checkout {
    /// Reads the working tree whose root is given.
    ///
    /// # Errors
    /// A file cannot be read or is not Rust.
    pub fn working_tree(root: &Path) -> Result<Self, CheckoutError> {
        Self::read(root.to_owned(), None)
    }

    /// Extracts a revision of the repository into a temporary folder and reads it.
    ///
    /// # Errors
    /// The revision is unknown, or as [`Checkout::working_tree`].
    pub fn revision(root: &Path, revision: &str) -> Result<Self, CheckoutError> {
        let folder = TempDir::new().map_err(|source| CheckoutError::Read {
            path: std::env::temp_dir(),
            source,
        })?;
        let archive = folder.path().join("sources.tar");
        let (archive_text, folder_text) =
            (archive.to_string_lossy(), folder.path().to_string_lossy());
        run(
            "git",
            &["archive", "--output", &archive_text, revision],
            root,
        )?;
        run("tar", &["-xf", &archive_text, "-C", &folder_text], root)?;
        Self::read(folder.path().to_owned(), Some(folder))
    }

    fn read(root: PathBuf, extracted: Option<TempDir>) -> Result<Self, CheckoutError> {
        let mut paths = Vec::new();
        walk(&root, &mut paths)?;
        let mut files = Vec::new();
        let mut crates = Vec::new();
        for path in paths {
            let relative = path.strip_prefix(&root).unwrap_or(&path);
            let relative = relative.to_string_lossy().replace('\\', "/");
            if relative.ends_with(".rs") && GENERATED.contains(&&*relative) {
                continue;
            } else if relative.ends_with(".rs") {
                files.push(source_file(&path, relative)?);
            } else if relative.ends_with("Cargo.toml") {
                crates.extend(crate_dir(&path, &relative)?);
            }
        }
        files.sort_by(|a, b| a.path.cmp(&b.path));
        crates.sort_by(|a, b| a.folder.cmp(&b.folder));
        mark_test_modules(&mut files);
        Ok(Self {
            root,
            files,
            crates,
            _extracted: extracted,
        })
    }

    /// The crate that a path belongs to: the one with the longest folder above it.
    pub fn crate_of(&self, path: &str) -> Option<&CrateDir> {
        let above = self.crates.iter().filter(|it| {
            it.folder.is_empty()
                || path
                    .strip_prefix(&it.folder)
                    .is_some_and(|rest| rest.starts_with('/'))
        });
        above.max_by_key(|it| it.folder.len())
    }
}

/// Runs a command and returns what it printed.
///
/// # Errors
/// It does not start, or ends with an error.
pub fn run(program: &str, arguments: &[&str], folder: &Path) -> Result<String, CheckoutError> {
    let failed = |message: String| CheckoutError::Command {
        command: format!("{program} {}", arguments.join(" ")),
        message,
    };
    let output = Command::new(program)
        .args(arguments)
        .current_dir(folder)
        .output()
        .map_err(|error| failed(error.to_string()))?;
    if !output.status.success() {
        return Err(failed(
            String::from_utf8_lossy(&output.stderr).trim().to_owned(),
        ));
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

fn walk(folder: &Path, found: &mut Vec<PathBuf>) -> Result<(), CheckoutError> {
    let unreadable = |source| CheckoutError::Read {
        path: folder.to_owned(),
        source,
    };
    for entry in std::fs::read_dir(folder).map_err(unreadable)? {
        let entry = entry.map_err(unreadable)?;
        let name = entry.file_name();
        let name = name.to_string_lossy();
        if name.starts_with('.') || SKIPPED.contains(&&*name) {
            continue;
        }
        let path = entry.path();
        if entry.file_type().map_err(unreadable)?.is_dir() {
            walk(&path, found)?;
        } else if name.ends_with(".rs") || name == "Cargo.toml" {
            found.push(path);
        }
    }
    Ok(())
}

fn text_of(path: &Path) -> Result<String, CheckoutError> {
    std::fs::read_to_string(path).map_err(|source| CheckoutError::Read {
        path: path.to_owned(),
        source,
    })
}

fn source_file(path: &Path, relative: String) -> Result<SourceFile, CheckoutError> {
    let text = text_of(path)?;
    let failed = |source| CheckoutError::Parse {
        path: path.to_owned(),
        source,
    };
    let tokens: proc_macro2::TokenStream = text
        .parse()
        .map_err(|error| failed(syn::Error::from(error)))?;
    let literal = crate::test_code::long_literals(tokens.clone());
    let tree: syn::File = syn::parse2(tokens).map_err(failed)?;
    let whole = relative
        .split('/')
        .any(|folder| TEST_FOLDERS.contains(&folder));
    let tests = match whole {
        true => TestLines::Whole,
        false => TestLines::of(&tree),
    };
    Ok(SourceFile {
        path: relative,
        text,
        tree,
        tests,
        literal,
    })
}

fn crate_dir(path: &Path, relative: &str) -> Result<Option<CrateDir>, CheckoutError> {
    let text = text_of(path)?;
    let name = toml::from_str::<toml::Table>(&text)
        .ok()
        .and_then(|manifest| {
            let package = manifest.get("package")?.as_table()?;
            Some(package.get("name")?.as_str()?.to_owned())
        });
    let folder = relative
        .trim_end_matches("Cargo.toml")
        .trim_end_matches('/');
    Ok(name.map(|name| CrateDir {
        name,
        folder: folder.to_owned(),
    }))
}

/// Files of `#[cfg(test)] mod name;` are test code, and so are the files below them.
fn mark_test_modules(files: &mut [SourceFile]) {
    let mut stems = Vec::new();
    for file in files.iter() {
        for item in &file.tree.items {
            if let syn::Item::Mod(module) = item
                && module.content.is_none()
                && crate::test_code::is_cfg_test(&module.attrs)
            {
                stems.push(format!("{}{}", child_folder(&file.path), module.ident));
            }
        }
    }
    for file in files {
        let inside = |stem: &String| {
            file.path
                .strip_prefix(stem.as_str())
                .is_some_and(|rest| rest == ".rs" || rest.starts_with('/'))
        };
        if stems.iter().any(inside) {
            file.tests = TestLines::Whole;
        }
    }
}

/// The folder with the submodules of a file, with a `/` at its end.
pub fn child_folder(path: &str) -> String {
    let (folder, name) = path.rsplit_once('/').unwrap_or(("", path));
    match name {
        "lib.rs" | "main.rs" | "mod.rs" => format!("{folder}/"),
        _ => format!("{}/", path.trim_end_matches(".rs")),
    }
}
