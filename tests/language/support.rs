//! Programs of the language: their files, and what is said of them.

use asmotion_lang::diagnostics::FileId;
use asmotion_lang::simulate::Script;
use asmotion_lang::{
    Diagnostic, FirstChoice, MemoryFiles, OpenFailure, Report, Sources, Specification, Style,
    render, render_all,
};
use std::path::{Path, PathBuf};

/// The `.asm` files of a folder, sorted: stem and text.
pub fn programs(folder: &Path) -> Vec<(String, String)> {
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    files.sort();
    let programs = files
        .into_iter()
        .filter(|file| file.extension().is_some_and(|end| end == "asm"));
    programs
        .map(|file| {
            let stem = file.file_stem().unwrap().to_string_lossy().into_owned();
            (stem, std::fs::read_to_string(file).unwrap())
        })
        .collect()
}

/// Opens a specification. A line `//--- name.asm` in the text begins another file.
pub fn open(name: &str, text: &str) -> Result<Specification, OpenFailure> {
    let mut files = MemoryFiles::new();
    let mut parts = text.split("//--- ");
    let main = format!("{name}.asm");
    files.add(&main, parts.next().unwrap());
    for part in parts {
        let (path, text) = part.split_once('\n').unwrap();
        files.add(path, text);
    }
    asmotion_lang::open(&main, &files)
}

/// Opens a specification without errors.
pub fn opened(name: &str, text: &str) -> Specification {
    open(name, text).unwrap_or_else(|failure| panic!("{name}.asm:\n{failure}"))
}

/// The codes found with their lines, and the rendered text.
pub fn said(name: &str, text: &str) -> (Vec<(usize, &'static str)>, String) {
    match open(name, text) {
        Err(failure) => (
            lines(&failure.report, &failure.sources),
            failure.to_string(),
        ),
        Ok(specification) => {
            let mut found = lines(&specification.report, &specification.sources);
            let mut rendered =
                render_all(&specification.report, &specification.sources, Style::Plain);
            if let Ok(machine) = specification.machine() {
                let doubts = specification.doubts(&machine);
                found.extend(lines(&doubts, &specification.sources));
                rendered.push_str(&render_all(&doubts, &specification.sources, Style::Plain));
            }
            if let Some(fault) = run(&specification) {
                found.push(line(&fault, &specification.sources));
                rendered.push_str(&render(&fault, &specification.sources, Style::Plain));
            }
            (found, rendered)
        }
    }
}

/// Runs a program for at most ten steps. Returns the fault that stopped it, if any.
fn run(specification: &Specification) -> Option<Diagnostic> {
    let mut machine = match specification.machine() {
        Ok(machine) => machine,
        Err(fault) => return Some(specification.explain(&fault)),
    };
    let mut silence = Script::read(FileId::default(), "", &specification.program).unwrap();
    for _ in 0..10 {
        if let Err(fault) = machine.step(&mut silence, &mut FirstChoice, 0).map(|_| ()) {
            return Some(specification.explain_in(&fault, &machine));
        }
    }
    None
}

fn lines(report: &Report, sources: &Sources) -> Vec<(usize, &'static str)> {
    report
        .diagnostics
        .iter()
        .map(|finding| line(finding, sources))
        .collect()
}

fn line(finding: &Diagnostic, sources: &Sources) -> (usize, &'static str) {
    let at = finding.primary.as_ref().map_or(1, |label| {
        sources.position(label.span.file, label.span.start).0
    });
    (at, finding.code.name)
}
