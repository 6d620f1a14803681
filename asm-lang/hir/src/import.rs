//! Imports: the names of a file that are visible in another.

use crate::codes::a015::NotExported;
use crate::codes::w003::ImportsNothing;
use crate::declare::SignatureTables;
use crate::hidden::{HiddenName, HidingClause, ImportClause, NameKind};
use crate::load::SourceUnit;
use crate::lost::{FailedImport, LostImport};
use crate::model::Rule;
use crate::scope::Scope;
use asmotion_diagnostics::{Finding, Span};
use asmotion_syntax::ast;
use asmotion_value::{Atom, RuleId};
use std::collections::BTreeSet;
use std::sync::Arc;

/// The names that a unit exports, according to its `export` clause.
enum Exports<'a> {
    Nothing,
    All,
    These(BTreeSet<&'a str>),
}

impl Exports<'_> {
    /// A file whose export clause could not be read exports everything: what is wrong with it has been reported.
    fn of(unit: &SourceUnit) -> Exports<'_> {
        let names = unit.tree.export.as_ref();
        let names = names.map(|export| export.names.as_ref());
        let is_unreadable = unit.unreadable.is_some();
        match names {
            None if is_unreadable => Exports::All,
            None => Exports::Nothing,
            Some(None) => Exports::All,
            Some(Some(names)) if names.is_empty() && is_unreadable => Exports::All,
            Some(Some(names)) if names.is_empty() => Exports::Nothing,
            Some(Some(names)) => Exports::These(names.iter().map(|name| &*name.text).collect()),
        }
    }

    fn has(&self, name: &str) -> bool {
        match self {
            Self::Nothing => false,
            Self::All => true,
            Self::These(names) => names.contains(name),
        }
    }
}

impl SignatureTables {
    /// Imports domains, and checks that the names listed by each import exist and are exported.
    pub fn imports(&mut self, units: &[SourceUnit], index: usize) {
        let unit = &units[index];
        for &(import, from) in &unit.imports {
            let import = &unit.tree.imports[import];
            let exports = Exports::of(&units[from]);
            if matches!(exports, Exports::Nothing) && units[from].tree.module {
                let module = import.path.text.clone();
                self.report.push(
                    ImportsNothing {
                        module,
                        at: import.path.span,
                    }
                    .diagnostic(),
                );
            }
            let other = self.scopes[from].clone();
            self.scopes[index].import(
                &other,
                |name| exports.has(name) && is_listed(import, name),
                |_| false,
            );
        }
    }

    pub fn imported_literals(&mut self, units: &[SourceUnit], index: usize) {
        for &(import, from) in &units[index].imports {
            let import = &units[index].tree.imports[import];
            let exports = Exports::of(&units[from]);
            let other = self.scopes[from].clone();
            let (domains, atoms) = (&self.domains, &self.atoms);
            let domain_of = |atom: Atom| &*domains[atoms[atom.0 as usize].domain.0 as usize].name;
            let is_imported =
                |atom| exports.has(domain_of(atom)) && is_listed(import, domain_of(atom));
            self.scopes[index].import(&other, |_| false, is_imported);
        }
    }

    pub fn imported_functions(&mut self, units: &[SourceUnit], index: usize) {
        self.imported_names(units, index, |into, from| {
            into.functions = from.functions.clone()
        });
    }

    pub fn imported_rules(&mut self, units: &[SourceUnit], index: usize) {
        // the main rule of an imported file is not visible
        let mains: Vec<Span> = units
            .iter()
            .filter_map(|unit| Some(unit.tree.main.as_ref()?.name.span))
            .collect();
        let imported = |rules: &[Rule], id: &RuleId| !mains.contains(&rules[id.0 as usize].span);
        let rules = std::mem::take(&mut self.rules);
        self.imported_names(units, index, |into, from| {
            into.rules = from.rules.clone();
            into.rules
                .values_mut()
                .for_each(|known| known.retain(|id| imported(&rules, id)));
            into.rules.retain(|_, known| !known.is_empty());
        });
        self.rules = rules;
        let unit = &units[index];
        for &(import, from) in &unit.imports {
            let import = &unit.tree.imports[import];
            let exports = Exports::of(&units[from]);
            for name in import.names.iter().flatten() {
                let other = &self.scopes[from];
                let known = other.domains.contains_key(&name.text)
                    || other.functions.contains_key(&name.text)
                    || (other.rules.contains_key(&name.text)
                        || declares_rule(&units[from].tree, &name.text));
                if !known || !exports.has(&name.text) {
                    let error = NotExported {
                        module: import.path.text.clone(),
                        name: name.text.clone(),
                        at: name.span,
                        hidden: self.hidden_anywhere(index, &name.text),
                    };
                    self.report.push(error.diagnostic());
                }
            }
        }
    }

    fn imported_names(
        &mut self,
        units: &[SourceUnit],
        index: usize,
        part: impl Fn(&mut Scope, &Scope),
    ) {
        for &(import, from) in &units[index].imports {
            let import = &units[index].tree.imports[import];
            let exports = Exports::of(&units[from]);
            let mut other = Scope::default();
            part(&mut other, &self.scopes[from]);
            self.scopes[index].import(
                &other,
                |name| exports.has(name) && is_listed(import, name),
                |_| false,
            );
        }
    }

    /// Records the loaded imports of a unit, which explain unknown names.
    pub fn record_imports(&mut self, units: &[SourceUnit], index: usize) {
        let unit = &units[index];
        let clauses = unit.imports.iter().map(|&(import, from)| {
            let main = units[from].tree.main.as_ref();
            ImportClause {
                from,
                file: units[from].file,
                import: unit.tree.imports[import].clone(),
                export: units[from].tree.export.clone(),
                main: main.map(|rule| rule.name.span),
            }
        });
        self.import_clauses.push(clauses.collect());
    }

    /// Records the imports whose names the unit lacks because a file could not be loaded: its own,
    /// and those of the units that it imports.
    pub fn record_failed_imports(&mut self, units: &[SourceUnit], index: usize) {
        let unit = &units[index];
        let listed = |import: &ast::Import| import.names.as_deref().map(texts);
        let mut lost = Vec::new();
        for (at, import) in unit.tree.imports.iter().enumerate() {
            if unit.imports.iter().any(|(loaded, _)| *loaded == at) {
                continue;
            }
            let shown = format!("`{}`", import.path.text).into();
            lost.push(self.add_failed_import(shown, import.path.span, listed(import)));
        }
        for broken in &unit.broken_imports {
            lost.push(self.add_failed_import(Arc::clone(&broken.shown), broken.at, None));
        }
        for &(import, from) in &unit.imports {
            if let Some(at) = units[from].unreadable {
                let import = &unit.tree.imports[import];
                let shown = format!("`{}`", import.path.text).into();
                lost.push(self.add_failed_import(shown, at, listed(import)));
            }
        }
        for &(import, from) in &unit.imports {
            let Some(export) = &units[from].tree.export else {
                continue;
            };
            let through = self.lost_imports[from].iter().filter_map(|lost| {
                let exported = lost.through(export.names.as_deref().map(texts))?;
                exported.through(listed(&unit.tree.imports[import]))
            });
            lost.extend(through);
        }
        self.lost_imports.push(lost);
    }

    /// Adds an import whose names are unknown: all of them, or those that it lists.
    fn add_failed_import(
        &mut self,
        shown: Arc<str>,
        at: Span,
        listed: Option<BTreeSet<Arc<str>>>,
    ) -> LostImport {
        self.failed_imports.push(FailedImport {
            shown,
            at,
            names: BTreeSet::new(),
        });
        LostImport {
            failed: self.failed_imports.len() - 1,
            names: listed,
        }
    }

    /// Returns `true` if an unknown name may come from an import that could not be loaded. The
    /// finding about that import counts the name.
    pub fn is_lost(&mut self, unit: usize, name: &Arc<str>, kind: NameKind) -> bool {
        let lost = self.lost_imports.get(unit);
        let literal = kind == NameKind::Constant;
        let source = lost.and_then(|lost| {
            let sources = lost.iter().filter(|lost| lost.may_declare(name, literal));
            // an import that lists names is the likelier one
            sources.min_by_key(|lost| lost.names.is_none())
        });
        let failed = source.and_then(|lost| self.failed_imports.get_mut(lost.failed));
        failed.is_some_and(|failed| {
            failed.names.insert(name.clone());
            true
        })
    }

    /// Returns the declaration of an unknown name in a module that the unit imports.
    pub fn hidden(&self, unit: usize, name: &str, kind: NameKind) -> Option<HiddenName> {
        let clauses = self.import_clauses.get(unit)?;
        clauses.iter().find_map(|clause| {
            let (lacking, declared) = self.declared_in(clause, name, kind)?;
            let lists = |names: &[ast::NameText]| names.iter().any(|known| known.text == lacking);
            let (exports, imports) = (clause.export.as_ref(), clause.import.names.as_ref());
            let hidden_by = match exports.map(|export| export.names.as_deref()) {
                None => HidingClause::Export(None),
                Some(Some(names)) if !lists(names) => HidingClause::Export(end(names)),
                Some(_) => HidingClause::Import(end(imports.filter(|names| !lists(names))?)),
            };
            Some(HiddenName {
                module: clause.import.path.text.clone(),
                literal: *lacking != *name,
                lacking,
                declared,
                hidden_by,
            })
        })
    }

    /// As [`SignatureTables::hidden`], for a name of any kind.
    pub fn hidden_anywhere(&self, unit: usize, name: &str) -> Option<HiddenName> {
        let kinds = [NameKind::Function, NameKind::Rule, NameKind::Domain];
        let mut found = kinds.into_iter();
        found.find_map(|kind| self.hidden(unit, name, kind))
    }

    /// Returns the name that clauses must contain to make a name of the imported unit visible, and
    /// the span of its declaration.
    fn declared_in(
        &self,
        clause: &ImportClause,
        name: &str,
        kind: NameKind,
    ) -> Option<(Arc<str>, Span)> {
        let scope = self.scopes.get(clause.from)?;
        let domain = |name: &str| {
            let (name, id) = scope.domains.get_key_value(name)?;
            Some((name.clone(), self.domains[id.0 as usize].span))
        };
        let (name, declared) = match kind {
            NameKind::Function => {
                let (name, ids) = scope.functions.get_key_value(name)?;
                let spans = ids.iter().map(|id| self.functions[id.0 as usize].span);
                (
                    name.clone(),
                    spans.clone().find(|at| at.file == clause.file)?,
                )
            }
            NameKind::Rule => {
                let (name, ids) = scope.rules.get_key_value(name)?;
                let mut spans = ids.iter().map(|id| self.rules[id.0 as usize].span);
                let declared =
                    spans.find(|at| at.file == clause.file && Some(*at) != clause.main)?;
                (name.clone(), declared)
            }
            NameKind::Domain => domain(name)?,
            NameKind::Constant => {
                let atom = scope.literals.get(name).and_then(|atoms| atoms.first());
                match atom.map(|atom| &self.atoms[atom.0 as usize]) {
                    Some(atom) => {
                        let domain = &self.domains[atom.domain.0 as usize];
                        (domain.name.clone(), atom.span)
                    }
                    None => domain(name)?,
                }
            }
        };
        (declared.file == clause.file).then_some((name, declared))
    }
}

fn texts(names: &[ast::NameText]) -> BTreeSet<Arc<str>> {
    names.iter().map(|name| name.text.clone()).collect()
}

/// Returns `true` if the import lists this name or lists none.
fn is_listed(import: &ast::Import, name: &str) -> bool {
    import
        .names
        .as_ref()
        .is_none_or(|names| names.iter().any(|asked| &*asked.text == name))
}

fn declares_rule(tree: &ast::File, name: &str) -> bool {
    tree.rules.iter().any(|rule| &*rule.name.text == name)
}

/// Returns the empty span behind the last of several names.
fn end(names: &[ast::NameText]) -> Option<Span> {
    let span = names.last()?.span;
    Some(Span {
        start: span.end,
        ..span
    })
}
