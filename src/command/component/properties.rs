//! Saves, loads and compares the properties of a live component.

use crate::exit::Exit;
use crate::feature::LeftOut;
use crate::files::{DiskLoader, reason};
use crate::terminal::{TerminalOutput, count};
use asmotion_component::declaration::Declaration;
use asmotion_composite::property_file::{self, PropertyFile};
use asmotion_lang::Loader;
use asmotion_remote::Remote;
use clap::Subcommand;
use std::error::Error;

/// Subcommands for property files.
#[derive(Subcommand)]
pub(super) enum PropertiesCommand {
    /// Writes the properties of a component to a file
    Save {
        /// Name of the component
        name: String,

        /// TOML file to write
        file: String,
    },
    /// Sets the properties of a file before the component's next cycle: all of them or none
    Load {
        /// Name of the component
        name: String,

        /// TOML file written by `save`, or an RTT file (`.cpf`)
        file: String,
    },
    /// Shows the differences between a property file and a component
    Diff {
        /// Name of the component
        name: String,

        /// TOML file written by `save`
        file: String,
    },
}

impl PropertiesCommand {
    pub(super) fn run(
        self,
        remote: &Remote,
        terminal: &mut TerminalOutput,
    ) -> Result<Exit, Box<dyn Error>> {
        match self {
            Self::Save { name, file } => save(&remote.component(&name)?, &file),
            Self::Load { name, file } => load(&remote.component(&name)?, &file, terminal),
            Self::Diff { name, file } => diff(&remote.component(&name)?, &file, terminal),
        }
    }
}

/// Writes the properties to a file, each with its description as a comment.
fn save(component: &asmotion_remote::RemoteComponent, file: &str) -> Result<Exit, Box<dyn Error>> {
    let text = property_file::write(&component.declaration()?, &component.properties()?);
    let written = std::fs::write(file, text);
    written.map_err(|error| format!("cannot write `{file}`: {}", reason(&error)))?;
    Ok(Exit::Ok)
}

/// Sets all properties of the file, or none; other properties keep their values.
fn load(
    component: &asmotion_remote::RemoteComponent,
    file: &str,
    terminal: &mut TerminalOutput,
) -> Result<Exit, Box<dyn Error>> {
    let Some(read) = read(component, file, terminal)? else {
        return Ok(Exit::Findings);
    };
    component.set_all(read.properties)?;
    if !read.missing.is_empty() {
        let unchanged = read.missing.join(", ");
        terminal.status("Kept", format_args!("{unchanged}: not in `{file}`"));
    }
    Ok(Exit::Ok)
}

/// Prints the differences between file and component.
fn diff(
    component: &asmotion_remote::RemoteComponent,
    file: &str,
    terminal: &mut TerminalOutput,
) -> Result<Exit, Box<dyn Error>> {
    let Some(read) = read(component, file, terminal)? else {
        return Ok(Exit::Findings);
    };
    let running = component.properties()?;
    let differences = property_file::difference(&read.properties, &running);
    for (name, in_file, there) in &differences {
        terminal.result(format_args!(
            "{name}: {in_file} in the file, {there} in the component"
        ));
    }
    for name in &read.missing {
        terminal.result(format_args!("{name}: not in the file"));
    }
    Ok(if differences.is_empty() && read.missing.is_empty() {
        Exit::Ok
    } else {
        Exit::Findings
    })
}

/// Reads and checks the properties of a CPF file.
#[cfg(feature = "scdl")]
fn of_rtt(
    file: &str,
    text: &str,
    component: &str,
    declared: &Declaration,
) -> Result<PropertyFile, LeftOut> {
    let cpf = asmotion_scdl::cpf(file, text);
    let mut read = property_file::of_tree(&cpf.properties, component, declared);
    read.report.extend(cpf.report);
    Ok(PropertyFile {
        sources: cpf.sources,
        ..read
    })
}

/// Fails: CPF files are read by the reader of SCDL.
#[cfg(not(feature = "scdl"))]
fn of_rtt(_: &str, _: &str, _: &str, _: &Declaration) -> Result<PropertyFile, LeftOut> {
    Err(LeftOut::new::<crate::feature::Scdl>())
}

/// Reads the file and checks it against the declaration; prints errors and returns `None` if there are any.
fn read(
    component: &asmotion_remote::RemoteComponent,
    file: &str,
    terminal: &mut TerminalOutput,
) -> Result<Option<PropertyFile>, Box<dyn Error>> {
    let text = DiskLoader.read(file);
    let text = text.map_err(|error| format!("cannot read `{file}`: {}", error.reason))?;
    let (name, declared) = (component.name(), component.declaration()?);
    let read = if file.ends_with(".cpf") || file.ends_with(".xml") {
        of_rtt(file, &text, name, &declared)?
    } else {
        property_file::read(file, &text, name, &declared)
    };
    terminal.report(&read.report, &read.sources);
    if read.report.has_errors() {
        terminal.error(count(&read.report).unwrap_or_default());
        return Ok(None);
    }
    Ok(Some(read))
}
