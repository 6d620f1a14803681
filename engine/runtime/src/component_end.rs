//! Resolves `Component.port` names against the declarations of the components.

use asmotion_component::declaration::{Declaration, PortDeclaration};
use asmotion_component::suggestion_among;

use crate::build_error::BuildError;

/// One end of a connection or wire: a port, service or reference of a component.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ComponentEnd {
    // the numbers are compared first, which tells most ends apart
    /// Position of the component in the system.
    pub(crate) unit: usize,
    /// Position of the port, service or reference in the component's declaration.
    pub(crate) index: usize,
    /// Full name, `component.port`.
    pub(crate) name: String,
}

impl ComponentEnd {
    /// Full name, `component.port`.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Position of the component in the system.
    pub fn component(&self) -> usize {
        self.unit
    }
}

/// A component's names of one kind, and those of the kind most easily confused with it, for the error message.
pub(crate) struct EndTable<'a> {
    kind: &'static str,
    names: Vec<&'a str>,
    /// The kind and names that a wrong name may belong to.
    opposite: (&'static str, Vec<&'a str>),
}

pub(crate) fn inputs(declaration: &Declaration) -> EndTable<'_> {
    EndTable {
        kind: "input",
        names: ports(&declaration.inputs),
        opposite: ("output", ports(&declaration.outputs)),
    }
}

pub(crate) fn outputs(declaration: &Declaration) -> EndTable<'_> {
    EndTable {
        kind: "output",
        names: ports(&declaration.outputs),
        opposite: ("input", ports(&declaration.inputs)),
    }
}

fn ports(ports: &[PortDeclaration]) -> Vec<&str> {
    ports.iter().map(|port| &*port.name).collect()
}

pub(crate) fn services(declaration: &Declaration) -> EndTable<'_> {
    let (services, references) = services_and_references(declaration);
    EndTable {
        kind: "service",
        names: services,
        opposite: ("reference", references),
    }
}

pub(crate) fn references(declaration: &Declaration) -> EndTable<'_> {
    let (services, references) = services_and_references(declaration);
    EndTable {
        kind: "reference",
        names: references,
        opposite: ("service", services),
    }
}

fn services_and_references(declaration: &Declaration) -> (Vec<&str>, Vec<&str>) {
    let services = declaration.services.iter().map(|service| &*service.name);
    let references = declaration
        .references
        .iter()
        .map(|reference| &*reference.name);
    (services.collect(), references.collect())
}

/// Finds `component.port`. A component's name may contain dots, a port's may not. A component without a name is none.
pub(crate) fn find<'a>(
    components: impl Iterator<Item = (&'a str, &'a Declaration)> + Clone,
    path: &str,
    table: fn(&Declaration) -> EndTable<'_>,
) -> Result<ComponentEnd, BuildError> {
    let (component, _) = split(path);
    let found = components
        .clone()
        .enumerate()
        .find(|(_, (name, _))| !name.is_empty() && *name == component);
    let Some((unit, (_, declaration))) = found else {
        return Err(BuildError::Unknown {
            kind: "component",
            name: component.to_owned(),
            nearest: suggestion_among(
                component,
                components.map(|(name, _)| name).filter(|it| !it.is_empty()),
            ),
        });
    };
    find_in((unit, declaration), path, table)
}

/// Splits `component.port` into both names.
pub(crate) fn split(path: &str) -> (&str, &str) {
    path.rsplit_once('.').unwrap_or((path, ""))
}

/// Finds `component.port` in this component, given with its position.
pub(crate) fn find_in(
    (unit, declaration): (usize, &Declaration),
    path: &str,
    table: fn(&Declaration) -> EndTable<'_>,
) -> Result<ComponentEnd, BuildError> {
    let (component, port) = split(path);
    let EndTable {
        kind: what,
        names,
        opposite: (is, others),
    } = table(declaration);
    if let Some(index) = names.iter().position(|name| *name == port) {
        let name = path.to_owned();
        return Ok(ComponentEnd { name, unit, index });
    }
    if others.contains(&port) {
        return Err(BuildError::Direction {
            end: path.to_owned(),
            actual: is,
            expected: what,
        });
    }
    let nearest = suggestion_among(port, names.iter().copied());
    Err(BuildError::Unknown {
        kind: what,
        name: path.to_owned(),
        nearest: nearest.map(|port| format!("{component}.{port}")),
    })
}
