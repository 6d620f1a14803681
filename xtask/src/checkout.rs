//! The parsed Rust sources of a revision.

use crate::test_code::TestLines;
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

/// Folders without sources of this repository.
const SKIPPED: &[&str] = &["target", "node_modules"];

/// Generated source files.
const GENERATED: &[&str] = &["asm-lang/syntax/src/grammar.rs"];

/// Folders whose code is compiled only for tests or benchmarks.
const TEST_FOLDERS: &[&str] = &["tests", "benches", "examples", "fuzz"];

/// The failure to read the sources.
#[derive(Debug, thiserror::Error)]
pub enum CheckoutError {
    /// A file or folder cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// Path of the file or folder.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// A file is not valid Rust.
    #[error("{}: {source}", path.display())]
    Parse {
        /// Path of the file.
        path: PathBuf,
        /// Error of the parser.
        source: syn::Error,
    },
    /// `git` or `tar` failed.
    #[error("{command}: {message}")]
    Command {
        /// The command line.
        command: String,
        /// Output of the command on standard error.
        message: String,
    },
}

/// A parsed source file.
pub struct SourceFile {
    /// Path relative to the root of the repository, with `/`.
    pub path: String,
    /// The text of the file.
    pub text: String,
    /// Its syntax tree; spans have line numbers.
    pub tree: syn::File,
    /// Lines that are compiled only for tests.
    pub tests: TestLines,
    /// Lines inside a string literal of several lines, which are code even if they look like
    /// comments.
    pub literal: Vec<std::ops::RangeInclusive<usize>>,
}

impl SourceFile {
    /// Returns `true` if a line, counted from 1, is compiled only for tests.
    pub fn is_test(&self, line: usize) -> bool {
        self.tests.contains(line)
    }

    /// Returns the top-level folder: `engine`, `src`.
    pub fn wing(&self) -> &str {
        self.path.split('/').next().unwrap_or_default()
    }
}

/// A package of the repository.
#[derive(Debug)]
pub struct CrateDir {
    /// Name of the package.
    pub name: String,
    /// Folder relative to the root; empty for the root package.
    pub folder: String,
}

/// The sources of a revision.
pub struct Checkout {
    /// Folder that contains the files.
    pub root: PathBuf,
    /// The source files, sorted by path.
    pub files: Vec<SourceFile>,
    /// The packages, sorted by folder.
    pub crates: Vec<CrateDir>,
    /// Deletes the extracted files when the checkout is dropped; `None` for the working tree.
    _extracted: Option<TempDir>,
}

impl Checkout {
    /// Reads the working tree at `root`.
    ///
    /// # Errors
    /// A file cannot be read or is not valid Rust.
    pub fn working_tree(root: &Path) -> Result<Self, CheckoutError> {
        Self::read(root.to_owned(), None)
    }

    /// Extracts a revision of the repository into a temporary folder and reads it.
    ///
    /// # Errors
    /// The revision is unknown, a file cannot be read, or a file is not valid Rust.
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

    /// Returns the crate of a path: the one with the longest enclosing folder.
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

/// Runs a command and returns its standard output.
///
/// # Errors
/// The command cannot be started or fails.
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
    let tests = if whole {
        TestLines::Whole
    } else {
        TestLines::of(&tree)
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

/// Marks the files of `#[cfg(test)] mod name;`, and those below them, as test code.
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

/// Returns the folder of a file's submodules, with a trailing `/`.
pub fn child_folder(path: &str) -> String {
    let (folder, name) = path.rsplit_once('/').unwrap_or(("", path));
    match name {
        "lib.rs" | "main.rs" | "mod.rs" => format!("{folder}/"),
        _ => format!("{}/", path.trim_end_matches(".rs")),
    }
}
