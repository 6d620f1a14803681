//! Imports: the names of a file that are visible in another.

use crate::codes::a015::NotExported;
use crate::codes::w003::ImportsNothing;
use crate::declare::SignatureTables;
use crate::load::SourceUnit;
use crate::model::Rule;
use crate::scope::Scope;
use asmotion_diagnostics::{Finding, Span};
use asmotion_syntax::ast;
use asmotion_value::{Atom, RuleId};
use std::collections::BTreeSet;

/// The names that a unit exports, according to its `export` clause.
enum Exports<'a> {
    Nothing,
    All,
    These(BTreeSet<&'a str>),
}

impl Exports<'_> {
    fn of(tree: &ast::File) -> Exports<'_> {
        let names = tree.export.as_ref().map(|export| export.names.as_ref());
        match names {
            None => Exports::Nothing,
            Some(None) => Exports::All,
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
            let exports = Exports::of(&units[from].tree);
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
            let exports = Exports::of(&units[from].tree);
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
            let exports = Exports::of(&units[from].tree);
            for name in import.names.iter().flatten() {
                let other = &self.scopes[from];
                let known = other.domains.contains_key(&name.text)
                    || other.functions.contains_key(&name.text)
                    || (other.rules.contains_key(&name.text)
                        || declares_rule(&units[from].tree, &name.text));
                if !known || !exports.has(&name.text) {
                    let module = import.path.text.clone();
                    let error = NotExported {
                        module,
                        name: name.text.clone(),
                        at: name.span,
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
            let exports = Exports::of(&units[from].tree);
            let mut other = Scope::default();
            part(&mut other, &self.scopes[from]);
            self.scopes[index].import(
                &other,
                |name| exports.has(name) && is_listed(import, name),
                |_| false,
            );
        }
    }
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
