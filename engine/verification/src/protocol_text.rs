//! The protocol of a component: where it comes from, and what it can name.

use crate::protocol::ComponentNames;
use asmotion_diagnostics::{LoadError, Loader};
use asmotion_lang::MemoryFiles;
use asmotion_plan::{Component, Implementation};
use std::sync::Arc;

/// The protocol of a component.
pub(crate) enum ProtocolText {
    /// Path of a file, from the key `protocol`.
    File(String),
    /// The protocol that comes with a component of the catalogue: a name for it, and its text.
    Embedded(String, String),
}

/// Reads the files of a protocol.
pub(crate) enum ProtocolFiles<'a> {
    Loaded(&'a dyn Loader),
    Embedded(MemoryFiles),
}

/// The names that a protocol can use.
pub(crate) fn names_of(component: &Component) -> ComponentNames {
    let ports = |ports: &[asmotion_plan::Port]| ports.iter().map(|it| it.name.clone()).collect();
    let services = |all: &[asmotion_plan::Service]| all.iter().map(|it| it.name.clone()).collect();
    ComponentNames {
        inputs: ports(&component.inputs),
        outputs: ports(&component.outputs),
        services: services(&component.services),
        references: services(&component.references),
    }
}

/// Returns the path of a component's specification.
pub(crate) fn specification_of(component: &Component) -> Option<&str> {
    match &component.implementation {
        Implementation::Asm { file, .. } => Some(file),
        Implementation::Rust(_)
        | Implementation::Builtin { .. }
        | Implementation::Process { .. }
        | Implementation::Ros { .. }
        | Implementation::Orocos { .. } => None,
    }
}

/// Returns the protocol of a component; the key `protocol` precedes that of the catalogue.
pub(crate) fn protocol_of(
    component: &Component,
    catalogue: &dyn Fn(&str) -> Option<String>,
) -> Option<ProtocolText> {
    if let Some(path) = &component.special.protocol {
        return Some(ProtocolText::File(path.clone()));
    }
    let Implementation::Rust(name) = &component.implementation else {
        return None;
    };
    let text = catalogue(name)?;
    Some(ProtocolText::Embedded(format!("{name}/protocol.asm"), text))
}

impl ProtocolText {
    /// Returns `true` for the protocol that comes with a component of the catalogue.
    pub fn is_of_catalogue(&self) -> bool {
        match self {
            Self::File(_) => false,
            Self::Embedded(..) => true,
        }
    }

    /// Returns the path of the protocol, and a loader for it.
    pub fn files<'a>(&self, loader: &'a dyn Loader) -> (String, ProtocolFiles<'a>) {
        match self {
            Self::File(path) => (path.clone(), ProtocolFiles::Loaded(loader)),
            Self::Embedded(path, text) => {
                let mut files = MemoryFiles::new();
                files.add(path, text.clone());
                (path.clone(), ProtocolFiles::Embedded(files))
            }
        }
    }
}

impl Loader for ProtocolFiles<'_> {
    fn read(&self, path: &str) -> Result<Arc<str>, LoadError> {
        match self {
            Self::Loaded(loader) => loader.read(path),
            Self::Embedded(files) => files.read(path),
        }
    }

    fn resolve(&self, from: &str, import: &str) -> Option<String> {
        match self {
            Self::Loaded(loader) => loader.resolve(from, import),
            Self::Embedded(files) => files.resolve(from, import),
        }
    }
}
