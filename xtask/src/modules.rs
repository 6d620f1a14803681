//! Dependencies between the files of a crate; re-exports are followed to the definition.
//!
//! Paths between modules are resolved as by the compiler: `crate`, `self` and `super`, child
//! modules, items, imports and globs. Types of expressions are not inferred, so a method call
//! creates no arrow; its type must be named elsewhere anyway.

use crate::checkout::{Checkout, SourceFile, child_folder};
use crate::graph::Arrow;
use crate::test_code::{attributes, is_cfg_test};
use proc_macro2::{TokenStream, TokenTree};
use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use syn::spanned::Spanned;
use syn::visit::{self, Visit};

/// The files of a crate and the arrows between them, without test code.
#[derive(Debug)]
pub struct CrateModules {
    /// Name of the package.
    pub name: String,
    /// Path of the crate's root file, `lib.rs` or `main.rs`.
    pub root: String,
    /// The crate's files, including the root.
    pub files: BTreeSet<String>,
    /// First-level module of each file except the root.
    pub rooms: BTreeMap<String, String>,
    /// Arrows from a file that names an item to the file that defines it, with the paths as written.
    pub uses: BTreeMap<Arrow, BTreeSet<String>>,
    /// Items that are named through the crate's root.
    pub hub_uses: Vec<HubUse>,
}

/// A path that names an item, but no module, through the root of the crate.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HubUse {
    /// Path of the file.
    pub path: String,
    /// Line of the path in the code, from 1.
    pub line: usize,
    /// The path as written: `crate::Time`.
    pub name: String,
}

impl CrateModules {
    /// Returns the arrows between files.
    pub fn arrows(&self) -> BTreeSet<Arrow> {
        self.uses.keys().cloned().collect()
    }

    /// Returns the arrows between first-level modules of the crate.
    pub fn room_arrows(&self) -> BTreeSet<Arrow> {
        let pairs = self.uses.keys().filter_map(|(from, to)| {
            let (from, to) = (self.rooms.get(from)?, self.rooms.get(to)?);
            (from != to).then(|| (from.clone(), to.clone()))
        });
        pairs.collect()
    }

    /// Returns the names of the first-level modules.
    pub fn room_names(&self) -> BTreeSet<String> {
        self.rooms.values().cloned().collect()
    }
}

/// Returns the modules of every crate, one entry for each library and each `main.rs`.
pub fn of(checkout: &Checkout) -> Vec<CrateModules> {
    let by_path: BTreeMap<&str, &SourceFile> = checkout
        .files
        .iter()
        .map(|file| (file.path.as_str(), file))
        .collect();
    let mut found = Vec::new();
    for package in &checkout.crates {
        for root in ["src/lib.rs", "src/main.rs"] {
            let root = match package.folder.as_str() {
                "" => root.to_owned(),
                folder => format!("{folder}/{root}"),
            };
            if by_path.contains_key(root.as_str()) {
                found.push(Resolver::new(&by_path, &root).finish(package.name.clone(), root));
            }
        }
    }
    found
}

#[derive(Debug)]
struct ModuleScope {
    parent: Option<usize>,
    file: String,
    /// Child modules in known files.
    children: BTreeMap<String, usize>,
    /// Names of all child modules, including generated files.
    modules: BTreeSet<String>,
    items: BTreeSet<String>,
    imports: Vec<Import>,
    /// Paths in code with their lines.
    paths: Vec<(Vec<String>, usize)>,
}

#[derive(Clone, Debug)]
struct Import {
    /// Name brought into scope; empty for `*`.
    name: String,
    path: Vec<String>,
    line: usize,
}

/// The target of a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Target {
    Module(usize),
    /// An item defined in this module.
    Item(usize),
}

struct Resolver {
    scopes: Vec<ModuleScope>,
    macros: BTreeSet<String>,
    /// Results of earlier look-ups. `None` during a look-up, which ends circular imports.
    known: RefCell<BTreeMap<(usize, String), Option<Target>>>,
}

impl Resolver {
    fn new(files: &BTreeMap<&str, &SourceFile>, root: &str) -> Self {
        let mut resolver = Self {
            scopes: Vec::new(),
            macros: BTreeSet::new(),
            known: RefCell::default(),
        };
        if let Some(file) = files.get(root) {
            resolver.add(files, &file.tree.items, None, root, &child_folder(root));
        }
        resolver
    }

    /// Adds a module and its submodules.
    fn add(
        &mut self,
        files: &BTreeMap<&str, &SourceFile>,
        items: &[syn::Item],
        parent: Option<usize>,
        file: &str,
        folder: &str,
    ) -> usize {
        let this = self.scopes.len();
        self.scopes.push(ModuleScope {
            parent,
            file: file.to_owned(),
            children: BTreeMap::new(),
            modules: BTreeSet::new(),
            items: BTreeSet::new(),
            imports: Vec::new(),
            paths: Vec::new(),
        });
        for item in items.iter().filter(|item| !is_cfg_test(attributes(item))) {
            if let syn::Item::Mod(module) = item {
                self.add_child(files, module, this, file, folder);
            } else if let syn::Item::Use(import) = item {
                let mut found = Vec::new();
                flatten(&import.tree, &mut Vec::new(), &mut found);
                self.scopes[this].imports.extend(found);
            } else {
                self.add_item(item, this);
            }
        }
        this
    }

    fn add_child(
        &mut self,
        files: &BTreeMap<&str, &SourceFile>,
        module: &syn::ItemMod,
        parent: usize,
        file: &str,
        folder: &str,
    ) {
        let name = module.ident.to_string();
        let name = name.trim_start_matches("r#");
        self.scopes[parent].modules.insert(name.to_owned());
        let below = format!("{folder}{name}/");
        let child = match &module.content {
            Some((_, items)) => Some(self.add(files, items, Some(parent), file, &below)),
            None => {
                let places = match path_attribute(&module.attrs) {
                    Some(path) => vec![format!(
                        "{}/{path}",
                        file.rsplit_once('/').map_or("", |(folder, _)| folder)
                    )],
                    None => vec![format!("{folder}{name}.rs"), format!("{below}mod.rs")],
                };
                let place = places
                    .into_iter()
                    .find_map(|place| files.get(place.as_str()));
                place.map(|file| {
                    let below = child_folder(&file.path);
                    self.add(files, &file.tree.items, Some(parent), &file.path, &below)
                })
            }
        };
        if let Some(child) = child {
            self.scopes[parent].children.insert(name.to_owned(), child);
        }
    }

    fn add_item(&mut self, item: &syn::Item, module: usize) {
        if let syn::Item::Macro(definition) = item
            && let Some(name) = &definition.ident
        {
            self.macros.insert(name.to_string());
        }
        let scope = &mut self.scopes[module];
        scope.items.extend(item_name(item));
        let mut visitor = PathVisitor {
            paths: &mut scope.paths,
            imports: &mut scope.imports,
        };
        visitor.visit_item(item);
    }

    /// Resolves a path in a module; returns `None` if it leads out of the crate.
    fn resolve(&self, module: usize, path: &[String]) -> Option<Target> {
        let (first, rest) = path.split_first()?;
        let start = match first.as_str() {
            "crate" | "$crate" => Target::Module(0),
            "self" => Target::Module(module),
            "super" => Target::Module(self.scopes[module].parent?),
            name => self.lookup(module, name)?,
        };
        self.walk(start, rest)
    }

    fn walk(&self, start: Target, rest: &[String]) -> Option<Target> {
        let mut at = start;
        for name in rest {
            let Target::Module(module) = at else {
                return Some(at);
            };
            at = match name.as_str() {
                "self" => at,
                "super" => Target::Module(self.scopes[module].parent?),
                name => self.lookup(module, name)?,
            };
        }
        Some(at)
    }

    fn lookup(&self, module: usize, name: &str) -> Option<Target> {
        let key = (module, name.to_owned());
        if let Some(known) = self.known.borrow().get(&key) {
            return *known;
        }
        self.known.borrow_mut().insert(key.clone(), None);
        let found = self.search(module, name);
        self.known.borrow_mut().insert(key, found);
        found
    }

    fn search(&self, module: usize, name: &str) -> Option<Target> {
        let scope = &self.scopes[module];
        if let Some(child) = scope.children.get(name) {
            return Some(Target::Module(*child));
        }
        if scope.items.contains(name) {
            return Some(Target::Item(module));
        }
        // an import that begins with the name itself leads out of the crate: `use log::log`
        let other = |import: &&Import| import.path.first().is_none_or(|first| first != name);
        for import in scope.imports.iter().filter(other) {
            if import.name == name
                && let Some(found) = self.resolve(module, &import.path)
            {
                return Some(found);
            }
        }
        let globs = scope.imports.iter().filter(|import| import.name.is_empty());
        for glob in globs.filter(other) {
            if let Some(Target::Module(inner)) = self.resolve(module, &glob.path)
                && inner != module
                && let Some(found) = self.lookup(inner, name)
            {
                return Some(found);
            }
        }
        None
    }

    /// Returns `true` if a path names, through the root, an item that is neither a module nor a
    /// macro, or if it ends at the root, as in `use crate::*`. `$crate` is permitted, because users
    /// of a macro have no other access to the crate.
    fn is_hub_use(&self, module: usize, path: &[String]) -> bool {
        let mut at = match path.first().map(String::as_str) {
            Some("crate") => Some(0),
            Some("super") => self.scopes[module].parent,
            _ => None,
        };
        let mut rest = path.iter().skip(1).peekable();
        while rest.next_if(|name| *name == "super").is_some() {
            at = at.and_then(|module| self.scopes[module].parent);
        }
        match (at, rest.next()) {
            (Some(0), Some(name)) => {
                !self.scopes[0].modules.contains(name) && !self.macros.contains(name)
            }
            (Some(0), None) => true,
            (Some(_) | None, _) => false,
        }
    }

    fn finish(self, name: String, root: String) -> CrateModules {
        let mut modules = CrateModules {
            name,
            root: root.clone(),
            files: self.scopes.iter().map(|scope| scope.file.clone()).collect(),
            rooms: self.rooms(),
            uses: BTreeMap::new(),
            hub_uses: Vec::new(),
        };
        for (module, scope) in self.scopes.iter().enumerate() {
            let imports = scope
                .imports
                .iter()
                .map(|import| (&import.path, import.line));
            let paths = scope.paths.iter().map(|(path, line)| (path, *line));
            for (path, line) in imports.chain(paths) {
                if scope.file != root && self.is_hub_use(module, path) {
                    modules.hub_uses.push(HubUse {
                        path: scope.file.clone(),
                        line,
                        name: path.join("::"),
                    });
                }
                // naming a module does not use its file; naming an item in it does
                let Some(Target::Item(target)) = self.resolve(module, path) else {
                    continue;
                };
                let to = &self.scopes[target].file;
                if *to != scope.file {
                    let arrow = (scope.file.clone(), to.clone());
                    modules
                        .uses
                        .entry(arrow)
                        .or_default()
                        .insert(path.join("::"));
                }
            }
        }
        modules
    }

    fn rooms(&self) -> BTreeMap<String, String> {
        let mut rooms = BTreeMap::new();
        let Some(root) = self.scopes.first() else {
            return rooms;
        };
        for (name, child) in &root.children {
            let mut open = vec![*child];
            while let Some(module) = open.pop() {
                let scope = &self.scopes[module];
                if scope.file != root.file {
                    rooms.insert(scope.file.clone(), name.clone());
                }
                open.extend(scope.children.values());
            }
        }
        rooms
    }
}

fn path_attribute(attributes: &[syn::Attribute]) -> Option<String> {
    attributes.iter().find_map(|attribute| {
        if let syn::Meta::NameValue(pair) = &attribute.meta
            && pair.path.is_ident("path")
            && let syn::Expr::Lit(literal) = &pair.value
            && let syn::Lit::Str(text) = &literal.lit
        {
            Some(text.value())
        } else {
            None
        }
    })
}

fn item_name(item: &syn::Item) -> Option<String> {
    #[expect(clippy::wildcard_enum_match_arm, reason = "the enum of `syn` is open")]
    let name = match item {
        syn::Item::Const(it) => &it.ident,
        syn::Item::Enum(it) => &it.ident,
        syn::Item::Fn(it) => &it.sig.ident,
        syn::Item::Static(it) => &it.ident,
        syn::Item::Struct(it) => &it.ident,
        syn::Item::Trait(it) => &it.ident,
        syn::Item::TraitAlias(it) => &it.ident,
        syn::Item::Type(it) => &it.ident,
        syn::Item::Union(it) => &it.ident,
        syn::Item::Macro(it) => it.ident.as_ref()?,
        _ => return None,
    };
    Some(name.to_string())
}

/// Collects the leaves of a `use` tree.
fn flatten(tree: &syn::UseTree, before: &mut Vec<String>, found: &mut Vec<Import>) {
    let line = tree.span().start().line;
    match tree {
        syn::UseTree::Path(it) => {
            before.push(it.ident.to_string());
            flatten(&it.tree, before, found);
            before.pop();
        }
        syn::UseTree::Group(it) => {
            for inner in &it.items {
                flatten(inner, before, found);
            }
        }
        syn::UseTree::Glob(_) => found.push(Import {
            name: String::new(),
            path: before.clone(),
            line,
        }),
        syn::UseTree::Name(it) => found.push(import(before, &it.ident, &it.ident, line)),
        syn::UseTree::Rename(it) => found.push(import(before, &it.ident, &it.rename, line)),
    }
}

fn import(before: &[String], last: &syn::Ident, name: &syn::Ident, line: usize) -> Import {
    let mut path = before.to_vec();
    let mut name = name.to_string();
    if last == "self" {
        // `use a::b::{self}` means `use a::b`
        if name == "self" {
            name = path.last().cloned().unwrap_or_default();
        }
    } else {
        path.push(last.to_string());
    }
    Import { name, path, line }
}

/// Collects the paths and local imports of an item.
struct PathVisitor<'a> {
    paths: &'a mut Vec<(Vec<String>, usize)>,
    imports: &'a mut Vec<Import>,
}

impl<'ast> Visit<'ast> for PathVisitor<'_> {
    fn visit_path(&mut self, path: &'ast syn::Path) {
        if path.leading_colon.is_none() {
            let names = path
                .segments
                .iter()
                .map(|segment| segment.ident.to_string());
            self.paths.push((names.collect(), path.span().start().line));
        }
        visit::visit_path(self, path);
    }

    /// Skips visibilities: `pub(super)` contains a path, but uses nothing.
    fn visit_visibility(&mut self, _: &'ast syn::Visibility) {}

    fn visit_item_use(&mut self, import: &'ast syn::ItemUse) {
        let mut found = Vec::new();
        flatten(&import.tree, &mut Vec::new(), &mut found);
        // names imported in a function are not visible in the module, so only the paths count
        self.imports.extend(found.into_iter().map(|import| Import {
            name: "_".to_owned(),
            ..import
        }));
    }

    fn visit_macro(&mut self, call: &'ast syn::Macro) {
        self.visit_path(&call.path);
        token_paths(call.tokens.clone(), self.paths);
    }
}

/// Collects paths with at least two segments in the arguments of a macro.
fn token_paths(tokens: TokenStream, found: &mut Vec<(Vec<String>, usize)>) {
    let mut path: Vec<String> = Vec::new();
    let (mut colons, mut dollar) = (0, false);
    let mut line = 0;
    let mut flush = |path: &mut Vec<String>, line: usize| {
        let path = std::mem::take(path);
        if path.len() > 1 {
            found.push((path, line));
        }
    };
    let mut inner = Vec::new();
    for token in tokens {
        match token {
            TokenTree::Ident(name) => {
                if colons != 2 {
                    flush(&mut path, line);
                    line = name.span().start().line;
                }
                path.push(if std::mem::take(&mut dollar) {
                    format!("${name}")
                } else {
                    name.to_string()
                });
                colons = 0;
            }
            TokenTree::Punct(mark) if mark.as_char() == '$' => {
                flush(&mut path, line);
                (colons, dollar) = (0, true);
            }
            TokenTree::Punct(mark) if mark.as_char() == ':' => colons += 1,
            TokenTree::Group(group) => {
                flush(&mut path, line);
                colons = 0;
                inner.push(group.stream());
            }
            TokenTree::Punct(_) | TokenTree::Literal(_) => {
                flush(&mut path, line);
                colons = 0;
            }
        }
    }
    flush(&mut path, line);
    for stream in inner {
        token_paths(stream, found);
    }
}

#[cfg(test)]
mod tests {
    use super::{CrateModules, of};
    use crate::checkout::Checkout;

    /// The modules of a crate with these files in `src`.
    fn modules(files: &[(&str, &str)]) -> CrateModules {
        let folder = tempfile::tempdir().unwrap();
        let manifest = "[package]\nname = \"one\"\n";
        std::fs::write(folder.path().join("Cargo.toml"), manifest).unwrap();
        std::fs::create_dir(folder.path().join("src")).unwrap();
        for (name, text) in files {
            std::fs::write(folder.path().join("src").join(name), text).unwrap();
        }
        let checkout = Checkout::working_tree(folder.path()).unwrap();
        of(&checkout).pop().unwrap()
    }

    fn hub_uses(text: &str) -> Vec<String> {
        let root = "mod a; mod b; mod generated; pub use b::Name;";
        let found = modules(&[
            ("lib.rs", root),
            ("a.rs", text),
            ("b.rs", "pub struct Name;"),
        ]);
        found.hub_uses.into_iter().map(|hub| hub.name).collect()
    }

    #[test]
    fn a_name_through_the_root_is_found_and_one_from_its_module_is_not() {
        assert_eq!(hub_uses("use crate::Name;"), ["crate::Name"]);
        assert_eq!(hub_uses("use super::Name as Other;"), ["super::Name"]);
        assert_eq!(hub_uses("use crate::*;"), ["crate"]);
        assert!(hub_uses("use crate::b::Name; use crate::{b, generated::Parser};").is_empty());
    }

    #[test]
    fn macros_name_their_own_crate() {
        let text = "macro_rules! new { () => { $crate::Name } }";
        assert!(hub_uses(text).is_empty());
        assert_eq!(hub_uses("fn new() { one!(crate::Name) }"), ["crate::Name"]);
    }

    #[test]
    fn a_re_export_is_followed_to_the_definition() {
        let found = modules(&[
            ("lib.rs", "mod a; mod b; mod c;"),
            ("a.rs", "use crate::b::Name;"),
            ("b.rs", "pub use crate::c::Name;"),
            ("c.rs", "pub struct Name;"),
        ]);
        let arrow = |from: &str, to: &str| (format!("src/{from}.rs"), format!("src/{to}.rs"));
        assert_eq!(found.arrows(), [arrow("a", "c"), arrow("b", "c")].into());
    }
}
