//! Imports SCDL as composite files: values that SCDL leaves open are derived, or assumed and reported.

use crate::codes::x006::UnknownScdlName;
use std::collections::BTreeMap;

use asmotion_composite::Catalogue;
use asmotion_diagnostics::{Finding, Report, Sources};

use crate::model::{ScdlComposite, ScdlImplementation};
use crate::{finish, name, read, resolve, toml};

/// The result of an import.
pub struct Imported {
    /// Names and texts of the composite files: first the main one, then those that it nests.
    pub files: Vec<(String, String)>,
    /// The texts that were read, which findings refer to.
    pub sources: Sources,
    /// The findings, ordered by place.
    pub report: Report,
}

/// Converts the first of these SCDL files to a composite file, together with those of the others that it nests. Each
/// file is given by its path and text.
pub fn import(files: &[(String, String)], catalogue: &dyn Catalogue) -> Imported {
    let mut sources = Sources::new();
    let mut report = Report::new();
    let mut known = BTreeMap::new();
    let mut main = None;
    for (index, (path, text)) in files.iter().enumerate() {
        let mut found = Report::new();
        let file = sources.add(path, text.as_str());
        let composite = read::composite(file, text, &mut found);
        if index == 0 {
            report.extend(std::mem::take(&mut found));
            main = composite;
        } else if let Some(composite) = composite {
            known.insert(composite.name.value.clone(), (composite, found));
        }
    }
    let mut visit = ImportVisit {
        known,
        catalogue,
        report,
        done: BTreeMap::new(),
        order: Vec::new(),
    };
    if let Some(main) = main {
        visit.composite(main);
    }
    finish::complete_all(&mut visit.done, &visit.order, &mut visit.report);
    let mut files = visit.files();
    files.reverse();
    Imported {
        files,
        sources,
        report: visit.report.finish(),
    }
}

struct ImportVisit<'v> {
    /// Composites that were read and not yet visited, by name, with their findings.
    known: BTreeMap<String, (ScdlComposite, Report)>,
    catalogue: &'v dyn Catalogue,
    report: Report,
    /// Resolved composites, by name.
    done: BTreeMap<String, ScdlComposite>,
    /// Names of the resolved composites, nested ones before those that nest them.
    order: Vec<String>,
}

impl ImportVisit<'_> {
    /// Resolves a composite after those that it nests, because they declare the services that can be wired.
    fn composite(&mut self, mut composite: ScdlComposite) {
        self.include(&mut composite);
        for component in &composite.components {
            if let Some(ScdlImplementation::Composite(name)) = &component.implementation
                && let Some(nested) = self.take(&name.value)
            {
                self.composite(nested);
            }
        }
        resolve::resolve(&mut composite, &self.done, self.catalogue, &mut self.report);
        let name = composite.name.value.clone();
        self.order.push(name.clone());
        self.done.insert(name, composite);
    }

    /// The composite files, nested ones first.
    fn files(&mut self) -> Vec<(String, String)> {
        let mut files = Vec::new();
        for name in &self.order {
            if let Some(composite) = self.done.get(name) {
                let text = toml::document(composite, &self.done, self.catalogue, &mut self.report);
                files.push((name::file(name), text));
            }
        }
        files
    }

    /// Takes a composite that has not been visited yet.
    fn take(&mut self, name: &str) -> Option<ScdlComposite> {
        let (composite, report) = self.known.remove(name)?;
        self.report.extend(report);
        Some(composite)
    }

    /// Replaces includes by the contents of the included composites.
    fn include(&mut self, composite: &mut ScdlComposite) {
        let mut open = std::mem::take(&mut composite.includes);
        while let Some(name) = open.pop() {
            let Some(included) = self.take(&name.value) else {
                let (name, at) = (name.value, name.span);
                let finding = UnknownScdlName {
                    what: "composite",
                    name,
                    nearest: None,
                    at,
                };
                self.report.push(finding.diagnostic());
                continue;
            };
            open.extend(included.includes);
            composite.properties.extend(included.properties);
            composite.components.extend(included.components);
            composite.services.extend(included.services);
            composite.references.extend(included.references);
            composite.wires.extend(included.wires);
            composite.notes.extend(included.notes);
        }
    }
}
