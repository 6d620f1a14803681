//! Helpers shared by the tests.
#![allow(dead_code, reason = "not every test uses all of it")]

use asmotion_composite::{Context, Tables};
use asmotion_diagnostics::{Report, Sources};
use asmotion_lang::{MemoryFiles, Style};
use asmotion_plan::Opened;
use asmotion_scdl::Imported;

/// Reads a file of `tests/scdl`.
pub fn text(file: &str) -> String {
    std::fs::read_to_string(format!("tests/scdl/{file}")).expect("a file")
}

/// Imports a file of `tests/scdl`, together with others.
pub fn import(files: &[&str]) -> Imported {
    let files: Vec<_> = files
        .iter()
        .map(|file| ((*file).to_owned(), text(file)))
        .collect();
    asmotion_scdl::import(&files, &Tables::EMPTY)
}

/// The findings as rendered text.
pub fn rendered(report: &Report, sources: &Sources) -> String {
    let findings = report.diagnostics.iter();
    let findings = findings.map(|it| asmotion_lang::render(it, sources, Style::Plain));
    findings.collect::<Vec<_>>().join("\n\n")
}

/// Opens the first of these composite files.
pub fn open(files: &[(String, String)]) -> Opened {
    let mut loader = MemoryFiles::new();
    for (name, text) in files {
        loader.add(name, text.as_str());
    }
    let first = files.first().map_or("", |(name, _)| name);
    asmotion_plan::open(first, &Context::files(&loader))
}
