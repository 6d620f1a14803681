//! Ends: finding `Component.port` among what components declare.

use super::BuildError;
use crate::declaration::{Declaration, PortDeclaration};
use crate::property::suggestion_among;

/// One end of a connection or wire.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct End {
    /// `component.port`.
    pub name: String,
    /// The component's place in the system.
    pub unit: usize,
    /// The port's, service's or reference's place in the component.
    pub index: usize,
}

/// A table of a component's named things, and the one to look in when the name is not there.
pub(crate) struct Table<'a> {
    what: &'static str,
    names: Vec<&'a str>,
    /// What else the name may be, by mistake.
    instead: (&'static str, Vec<&'a str>),
}

pub(crate) fn inputs(declaration: &Declaration) -> Table<'_> {
    Table {
        what: "input",
        names: ports(&declaration.inputs),
        instead: ("output", ports(&declaration.outputs)),
    }
}

pub(crate) fn outputs(declaration: &Declaration) -> Table<'_> {
    Table {
        what: "output",
        names: ports(&declaration.outputs),
        instead: ("input", ports(&declaration.inputs)),
    }
}

fn ports(ports: &[PortDeclaration]) -> Vec<&str> {
    ports.iter().map(|port| &*port.name).collect()
}

pub(crate) fn services(declaration: &Declaration) -> Table<'_> {
    let (services, references) = services_and_references(declaration);
    Table {
        what: "service",
        names: services,
        instead: ("reference", references),
    }
}

pub(crate) fn references(declaration: &Declaration) -> Table<'_> {
    let (services, references) = services_and_references(declaration);
    Table {
        what: "reference",
        names: references,
        instead: ("service", services),
    }
}

fn services_and_references(declaration: &Declaration) -> (Vec<&str>, Vec<&str>) {
    let services = declaration.services.iter().map(|service| &*service.name);
    let references = (declaration.references.iter()).map(|reference| &*reference.name);
    (services.collect(), references.collect())
}

/// Finds `component.port`. Components may have dots in their names, ports have none.
pub(crate) fn find<'a>(
    components: impl Iterator<Item = (&'a str, &'a Declaration)> + Clone,
    path: &str,
    table: fn(&Declaration) -> Table<'_>,
) -> Result<End, BuildError> {
    let (component, port) = path.rsplit_once('.').unwrap_or((path, ""));
    let found = (components.clone().enumerate()).find(|(_, (name, _))| *name == component);
    let Some((unit, (_, declaration))) = found else {
        return Err(BuildError::Unknown {
            what: "component",
            name: component.to_owned(),
            nearest: suggestion_among(component, components.map(|(name, _)| name)),
        });
    };
    let Table {
        what,
        names,
        instead: (is, others),
    } = table(declaration);
    if let Some(index) = names.iter().position(|name| *name == port) {
        let name = path.to_owned();
        return Ok(End { name, unit, index });
    }
    if others.contains(&port) {
        return Err(BuildError::Direction {
            end: path.to_owned(),
            is,
            wanted: what,
        });
    }
    let nearest = suggestion_among(port, names.iter().copied());
    Err(BuildError::Unknown {
        what,
        name: path.to_owned(),
        nearest: nearest.map(|port| format!("{component}.{port}")),
    })
}
