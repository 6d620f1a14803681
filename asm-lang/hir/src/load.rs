//! Loads a file and its imports, imported files first.

use crate::codes::a010::ImportNotFound;
use crate::codes::a011::ImportCycle;
use crate::codes::a012::ImportsTooDeep;
use crate::codes::a013::UnreadableFile;
use asmotion_diagnostics::{FileId, Finding, Loader, Report, Sources, Span};
use asmotion_syntax::ast;
use std::sync::Arc;

/// Limit for the depth of nested imports.
const MAX_IMPORT_DEPTH: usize = 64;

/// One source file of a specification.
#[derive(Debug)]
pub struct SourceUnit {
    /// Canonical path, from [`Loader::resolve`].
    pub path: String,
    /// Id of the text in the [`Sources`].
    pub file: FileId,
    /// The parsed file; partial if it has syntax errors.
    pub tree: ast::File,
    /// `true` for an embedded standard library.
    pub library: bool,
    /// Resolved imports: pairs of an index into the imports of the tree and the index of the
    /// imported unit. An import that could not be loaded has no pair.
    pub imports: Vec<(usize, usize)>,
}

/// The files of a specification. Imported files stand before those that import them, and the main
/// file is last.
#[derive(Debug, Default)]
pub struct LoadedFiles {
    /// The files, in order of dependency.
    pub units: Vec<SourceUnit>,
    /// Syntax errors, and imports that could not be resolved.
    pub report: Report,
}

/// Reads the file at `path` and all its imports. The standard libraries are embedded: an import
/// whose last path component is the name of one gets the embedded text, whatever its path.
pub fn load(path: &str, loader: &dyn Loader, sources: &mut Sources) -> LoadedFiles {
    let mut loading = FileLoading {
        loader,
        sources,
        loaded: LoadedFiles::default(),
        open: Vec::new(),
    };
    let text = match loader.resolve("", path) {
        Some(found) => loader.read(&found).map(|text| (found, text)),
        None => loader.read(path).map(|text| (path.to_owned(), text)),
    };
    match text {
        Ok((found, text)) => {
            loading.unit(&found, text, false);
        }
        Err(error) => loading
            .loaded
            .report
            .push(UnreadableFile { error, at: None }.diagnostic()),
    }
    loading.loaded
}

struct FileLoading<'a> {
    loader: &'a dyn Loader,
    sources: &'a mut Sources,
    loaded: LoadedFiles,
    /// Stack of the files whose imports are being read, each with the span of the import that led
    /// to it (`None` for the main file).
    open: Vec<(String, Option<Span>)>,
}

impl FileLoading<'_> {
    fn unit(&mut self, path: &str, text: Arc<str>, library: bool) -> usize {
        let file = self.sources.add(path, text.clone());
        let parsed = asmotion_syntax::parse(file, &text);
        self.loaded.report.extend(parsed.report);
        self.open.push((path.to_owned(), None));
        let mut imports = Vec::new();
        for (index, import) in parsed.file.imports.iter().enumerate() {
            if let Some(unit) = self.import(path, import) {
                imports.push((index, unit));
            }
        }
        self.open.pop();
        self.loaded.units.push(SourceUnit {
            path: path.to_owned(),
            file,
            tree: parsed.file,
            library,
            imports,
        });
        self.loaded.units.len() - 1
    }

    fn library(&mut self, library: &asmotion_stdlib::StandardLibrary) -> usize {
        let path = format!("<{}>", library.name);
        self.find_unit(&path)
            .unwrap_or_else(|| self.unit(&path, Arc::from(library.text), true))
    }

    fn import(&mut self, from: &str, import: &ast::Import) -> Option<usize> {
        let at = import.path.span;
        if let Some(frame) = self.open.last_mut() {
            frame.1 = Some(at);
        }
        let last = import
            .path
            .text
            .rsplit(['/', '\\'])
            .next()
            .unwrap_or(&import.path.text);
        if let Some(library) = asmotion_stdlib::library(last) {
            return Some(self.library(library));
        }
        let Some(path) = self.loader.resolve(from, &import.path.text) else {
            if let Some(library) = asmotion_stdlib::library_spelt_like(last) {
                return Some(self.library(library));
            }
            let error = ImportNotFound {
                path: import.path.text.to_string(),
                at,
            };
            self.loaded.report.push(error.diagnostic());
            return None;
        };
        if let Some(start) = self.open.iter().position(|(open, _)| *open == path) {
            let chain = self.open[start..]
                .iter()
                .map(|(path, at)| (path.clone(), *at))
                .collect();
            self.loaded
                .report
                .push(ImportCycle { path, at, chain }.diagnostic());
            return None;
        }
        if let Some(unit) = self.find_unit(&path) {
            return Some(unit);
        }
        if self.open.len() >= MAX_IMPORT_DEPTH {
            self.loaded.report.push(
                ImportsTooDeep {
                    at,
                    limit: MAX_IMPORT_DEPTH,
                }
                .diagnostic(),
            );
            return None;
        }
        match self.loader.read(&path) {
            Ok(text) => Some(self.unit(&path, text, false)),
            Err(error) => {
                self.loaded.report.push(
                    UnreadableFile {
                        error,
                        at: Some(at),
                    }
                    .diagnostic(),
                );
                None
            }
        }
    }

    fn find_unit(&self, path: &str) -> Option<usize> {
        self.loaded.units.iter().position(|unit| unit.path == path)
    }
}
