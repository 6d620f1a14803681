//! Loads a file and its imports, imported files first.

use crate::codes::a010::ImportNotFound;
use crate::codes::a011::ImportCycle;
use crate::codes::a012::ImportsTooDeep;
use crate::codes::a013::UnreadableFile;
use asmotion_diagnostics::{FileId, Finding, Loader, Report, Severity, Sources, Span};
use asmotion_syntax::{Parsed, ast};
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
    /// Imports with syntax errors, which the tree lacks.
    pub broken_imports: Vec<BrokenImport>,
    /// Place of the first syntax error if it hides which names the file declares and exports: nothing can be said about a name
    /// that the files importing it do not find.
    pub unreadable: Option<Span>,
}

/// An import with a syntax error.
#[derive(Debug)]
pub struct BrokenImport {
    /// The path in backticks, or words in its place.
    pub shown: Arc<str>,
    /// The place that the syntax error labels.
    pub at: Span,
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
        let prepared = library.then(|| asmotion_syntax::parse_library(file, &text));
        let parsed = prepared
            .flatten()
            .unwrap_or_else(|| asmotion_syntax::parse(file, &text));
        let (broken_imports, unreadable) = lost_parts(&parsed, &text);
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
            broken_imports,
            unreadable,
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

/// Returns the imports that the parser could not read, and the place of the first error if it hides what the file declares: its
/// heading or its export clause could not be read. A misspelt `export` is no export clause to the parser.
fn lost_parts(parsed: &Parsed, text: &str) -> (Vec<BrokenImport>, Option<Span>) {
    let errors = parsed.report.diagnostics.iter();
    let errors = errors.filter(|finding| finding.severity == Severity::Error);
    let places = errors.filter_map(|finding| finding.primary.as_ref().map(|label| label.span));
    let places: Vec<Span> = places.collect();
    let unread = parsed.file.unread.iter().filter_map(|span| {
        let words = text.get(span.start as usize..span.end as usize)?;
        let at = places.iter().find(|place| place.start >= span.start)?;
        Some((words, *at))
    });
    let (mut imports, mut unreadable) = (Vec::new(), None);
    for (words, at) in unread {
        let mut words = words.split_whitespace();
        match words.next() {
            Some("import") => {
                let path = words
                    .next()
                    .and_then(|it| it.trim_matches('"').split('(').next());
                let shown = path.map_or_else(|| "this import".to_owned(), |it| format!("`{it}`"));
                let shown = shown.into();
                imports.push(BrokenImport { shown, at });
            }
            Some("export") => unreadable = unreadable.or(Some(at)),
            Some(_) | None => {}
        }
    }
    let export = parsed.file.export.as_ref();
    let has_export = export.is_some_and(|it| it.names.as_ref().is_none_or(|it| !it.is_empty()));
    if !has_export {
        // the error is the missing clause, or hides it
        let mut in_header = places
            .iter()
            .filter(|it| it.start as usize <= header_end(text));
        unreadable = unreadable.or(in_header.next().copied());
    }
    if parsed.file.name.is_none() {
        unreadable = places.first().copied();
    }
    (imports, unreadable)
}

/// The offset of the first heading, after the name, the imports and the export clause of a file.
fn header_end(text: &str) -> usize {
    let mut offset = 0;
    for line in text.split_inclusive('\n') {
        let start = line.trim_start();
        if ["signature", "definitions"]
            .iter()
            .any(|it| start.starts_with(it))
        {
            return offset + line.len() - start.len();
        }
        offset += line.len();
    }
    offset
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_library_is_read_as_by_the_grammar() {
        for library in asmotion_stdlib::libraries() {
            let (file, name) = (FileId(7), library.name);
            let read = asmotion_syntax::parse_library(file, library.text).expect(name);
            let parsed = asmotion_syntax::parse(file, library.text);
            assert_eq!(parsed.report, Report::new(), "{name}");
            let (read, parsed) = (format!("{read:#?}"), format!("{parsed:#?}"));
            let mut lines = read.lines().zip(parsed.lines()).enumerate();
            let first = lines.find(|(_, (read, parsed))| read != parsed);
            assert_eq!(first, None, "{name}");
            assert_eq!(read.len(), parsed.len(), "{name}");
        }
    }

    #[test]
    fn texts_of_another_form_are_left_to_the_grammar() {
        let read = |text: &str| asmotion_syntax::parse_library(FileId(0), text).is_some();
        let signature = "module M export * signature: static f: Prod(D, D) -> D definitions:";
        assert!(read(signature));
        for (part, other) in [
            ("module", "asm"),
            ("*", "f"),
            ("static", "dynamic out"),
            ("static f", "//@Backref\nstatic f"),
            ("Prod(D, D)", "Prod(D; D)"),
            ("Prod(D, D)", "Seq(D, D)"),
            ("definitions:", ""),
            ("definitions:", "definitions: function f = "),
        ] {
            assert!(!read(&signature.replace(part, other)), "{other}");
        }
    }
}
