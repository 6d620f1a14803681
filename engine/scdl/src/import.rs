//! SCDL → composite files: what SCDL leaves open is found out, or assumed and said.

use crate::codes::x006::UnknownScdlName;
use std::collections::BTreeMap;

use asmotion_assembly::Catalogue;
use asmotion_diagnostics::{Finding, Report, Sources};

use crate::model::{ScdlComposite, ScdlImplementation};
use crate::{finish, name, read, resolve, toml};

/// What was imported.
pub struct Imported {
    /// The names of composite files and their texts; the first is that of the file itself, the others are
    /// those that it nests.
    pub files: Vec<(String, String)>,
    /// The texts that were read; the findings point into them.
    pub sources: Sources,
    /// What was found, by place.
    pub report: Report,
}

/// Makes a composite file of the first of these files, and of those among the others that it nests.
/// Files have a path and a text.
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
    finish::settle(&mut visit.done, &visit.order, &mut visit.report);
    let mut files = visit.files();
    files.reverse();
    Imported {
        files,
        sources,
        report: visit.report.finish(),
    }
}

struct ImportVisit<'v> {
    /// Composites by name, with what was found in them; each is taken once.
    known: BTreeMap<String, (ScdlComposite, Report)>,
    catalogue: &'v dyn Catalogue,
    report: Report,
    /// Composites that are resolved.
    done: BTreeMap<String, ScdlComposite>,
    /// Their names, nested ones before those that nest them.
    order: Vec<String>,
}

impl ImportVisit<'_> {
    /// The nested ones first, since they say what can be wired to them.
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

    /// Composite files, nested ones first.
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

    /// A composite that is read for the first time.
    fn take(&mut self, name: &str) -> Option<ScdlComposite> {
        let (composite, report) = self.known.remove(name)?;
        self.report.extend(report);
        Some(composite)
    }

    /// Puts what is included in its place.
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
