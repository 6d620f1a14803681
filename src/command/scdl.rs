//! `asmotion scdl`: converts composites from and to the XML of the Service Component Architecture.

use std::io;
use std::path::{Path, PathBuf};

use asmotion_composite::NoPrograms;
use asmotion_lang::Loader;
use clap::{Args, Subcommand};

use crate::build::Build;
use crate::exit::Exit;
use crate::files::{DiskLoader, reason};
use crate::terminal::TerminalOutput;

/// Converts composites from and to the XML of the Service Component Architecture (SCDL).
#[derive(Args)]
pub struct Scdl {
    #[command(subcommand)]
    what: ScdlCommand,
}

#[derive(Subcommand)]
enum ScdlCommand {
    /// Converts an SCDL file into composite files
    Import(ScdlImport),
    /// Converts a composite into SCDL
    Export(ScdlExport),
}

#[derive(Args)]
struct ScdlImport {
    /// SCDL file; nested composites are looked up in the same folder
    file: String,

    /// Folder for the composite files, created if it is missing [default: prints the first one]
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
}

#[derive(Args)]
struct ScdlExport {
    /// Composite file
    composite: String,

    /// SCDL file to write [default: standard output]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

impl Scdl {
    pub fn run(self, build: &Build, terminal: &mut TerminalOutput) -> Exit {
        match self.what {
            ScdlCommand::Import(import) => import.run(build, terminal),
            ScdlCommand::Export(export) => export.run(build, terminal),
        }
    }
}

impl ScdlImport {
    fn run(self, build: &Build, terminal: &mut TerminalOutput) -> Exit {
        let files = match read(&self.file) {
            Ok(files) => files,
            Err((path, reason)) => {
                terminal.error(format_args!("cannot read `{path}`: {reason}"));
                return Exit::Usage;
            }
        };
        let imported = asmotion_scdl::import(&files, build.catalogue());
        terminal.report(&imported.report, &imported.sources);
        match &self.output {
            None => {
                if let Some((_, text)) = imported.files.first() {
                    terminal.result(text.trim_end());
                }
            }
            Some(folder) => {
                if let Err(error) = std::fs::create_dir_all(folder) {
                    let (folder, reason) = (folder.display(), reason(&error));
                    terminal.error(format_args!("cannot create `{folder}`: {reason}"));
                    return Exit::Usage;
                }
                for (name, text) in &imported.files {
                    if let Err(exit) = write(&folder.join(name), text, terminal) {
                        return exit;
                    }
                }
            }
        }
        if imported.report.has_errors() {
            Exit::Findings
        } else {
            Exit::Ok
        }
    }
}

/// Reads a file and the SCDL files in its folder; returns their paths and texts.
fn read(file: &str) -> Result<Vec<(String, String)>, (String, String)> {
    let read = |path: &str| match DiskLoader.read(path) {
        Ok(text) => Ok((path.to_owned(), text.to_string())),
        Err(error) => Err((error.path, error.reason)),
    };
    let mut files = vec![read(file)?];
    let folder = Path::new(file).parent().unwrap_or(Path::new(""));
    let folder = if folder.as_os_str().is_empty() {
        Path::new(".")
    } else {
        folder
    };
    let entries = std::fs::read_dir(folder).and_then(Iterator::collect::<io::Result<Vec<_>>>);
    let entries = entries.map_err(|error| (folder.display().to_string(), reason(&error)))?;
    let mut paths: Vec<PathBuf> = entries.into_iter().map(|entry| entry.path()).collect();
    paths.sort();
    for path in paths {
        let is_scdl = path.extension().is_some_and(|ending| ending == "composite");
        if is_scdl && path.file_name() != Path::new(file).file_name() {
            files.push(read(&path.display().to_string())?);
        }
    }
    Ok(files)
}

fn write(path: &Path, text: &str, terminal: &mut TerminalOutput) -> Result<(), Exit> {
    match std::fs::write(path, text) {
        Ok(()) => {
            terminal.status("Wrote", path.display());
            Ok(())
        }
        Err(error) => {
            let path = path.display();
            terminal.error(format_args!("cannot write `{path}`: {}", reason(&error)));
            Err(Exit::Usage)
        }
    }
}

impl ScdlExport {
    fn run(self, build: &Build, terminal: &mut TerminalOutput) -> Exit {
        let opened = build.open_with(&self.composite, &[], &DiskLoader, &NoPrograms);
        terminal.report(&opened.report, &opened.sources);
        let composite = opened.composite.filter(|_| !opened.report.has_errors());
        let Some(composite) = composite else {
            return Exit::refused(&self.composite);
        };
        let exported = match asmotion_scdl::export(&composite) {
            Ok(exported) => exported,
            Err(error) => {
                terminal.error(format_args!("cannot write SCDL: {error}"));
                return Exit::Usage;
            }
        };
        terminal.report(&exported.report, &opened.sources);
        match &self.output {
            None => terminal.result(exported.text.trim_end()),
            Some(path) => {
                if let Err(exit) = write(path, &exported.text, terminal) {
                    return exit;
                }
            }
        }
        Exit::Ok
    }
}
