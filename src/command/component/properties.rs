//! The properties of a live component, to a file and from it.

use crate::exit::Exit;
use crate::files::{Disk, reason};
use crate::terminal::{Terminal, count};
use asmotion_assembly::declaration::Declaration;
use asmotion_assembly::property_file::{self, Read};
use asmotion_lang::Loader;
use asmotion_remote::Remote;
use asmotion_scdl::Cpf;
use clap::Subcommand;
use std::error::Error;

/// What is done with a file of properties.
#[derive(Subcommand)]
pub(super) enum Properties {
    /// Writes the properties of a component to a file
    Save {
        /// Its name
        name: String,

        /// The file, TOML
        file: String,
    },
    /// Sets the properties of a file, all or none, from the component's next cycle on
    Load {
        /// Its name
        name: String,

        /// The file, as `save` writes it, or of RTT (`.cpf`)
        file: String,
    },
    /// Shows where the properties of a file and those of a component differ
    Diff {
        /// Its name
        name: String,

        /// The file, as `save` writes it
        file: String,
    },
}

impl Properties {
    /// Does it.
    pub(super) fn run(
        self,
        remote: &Remote,
        terminal: &mut Terminal,
    ) -> Result<Exit, Box<dyn Error>> {
        match self {
            Self::Save { name, file } => save(&remote.component(&name)?, &file),
            Self::Load { name, file } => load(&remote.component(&name)?, &file, terminal),
            Self::Diff { name, file } => diff(&remote.component(&name)?, &file, terminal),
        }
    }
}

/// Writes them to a file, each behind what it is for.
fn save(component: &asmotion_remote::Component, file: &str) -> Result<Exit, Box<dyn Error>> {
    let text = property_file::write(&component.declaration()?, &component.properties()?);
    let written = std::fs::write(file, text);
    written.map_err(|error| format!("cannot write `{file}`: {}", reason(&error)))?;
    Ok(Exit::Ok)
}

/// Sets those of a file, all or none; what it does not have stays.
fn load(
    component: &asmotion_remote::Component,
    file: &str,
    terminal: &mut Terminal,
) -> Result<Exit, Box<dyn Error>> {
    let Some(read) = read(component, file, terminal)? else {
        return Ok(Exit::Findings);
    };
    component.set_all(read.properties)?;
    if !read.missing.is_empty() {
        let kept = read.missing.join(", ");
        terminal.status("Kept", format_args!("{kept}: not in `{file}`"));
    }
    Ok(Exit::Ok)
}

/// Shows where a file and the component differ.
fn diff(
    component: &asmotion_remote::Component,
    file: &str,
    terminal: &mut Terminal,
) -> Result<Exit, Box<dyn Error>> {
    let Some(read) = read(component, file, terminal)? else {
        return Ok(Exit::Findings);
    };
    let running = component.properties()?;
    let differences = property_file::difference(&read.properties, &running);
    for (name, in_file, there) in &differences {
        terminal.result(format_args!("{name}: {in_file} in the file, {there} there"));
    }
    for name in &read.missing {
        terminal.result(format_args!("{name}: not in the file"));
    }
    Ok(match differences.is_empty() && read.missing.is_empty() {
        true => Exit::Ok,
        false => Exit::Findings,
    })
}

/// The properties of a CPF file, checked likewise.
fn of_rtt(cpf: Cpf, component: &str, declared: &Declaration) -> Read {
    let mut read = property_file::of_tree(&cpf.properties, component, declared);
    read.report.extend(cpf.report);
    Read {
        sources: cpf.sources,
        ..read
    }
}

/// The file, checked against what the component declares; nothing where an error is in it, which is told.
fn read(
    component: &asmotion_remote::Component,
    file: &str,
    terminal: &mut Terminal,
) -> Result<Option<Read>, Box<dyn Error>> {
    let text = Disk.read(file);
    let text = text.map_err(|error| format!("cannot read `{file}`: {}", error.reason))?;
    let (name, declared) = (component.name(), component.declaration()?);
    let read = match file.ends_with(".cpf") || file.ends_with(".xml") {
        true => of_rtt(asmotion_scdl::cpf(file, &text), name, &declared),
        false => property_file::read(file, &text, name, &declared),
    };
    terminal.report(&read.report, &read.sources);
    if read.report.has_errors() {
        terminal.error(count(&read.report).unwrap_or_default());
        return Ok(None);
    }
    Ok(Some(read))
}
