//! Compatibility of types, which depends on the domains of a model.

use crate::id::DomainId;
use crate::model::{Domain, DomainKind, Model};
use crate::types::{Type, TypeId, TypeTable};
use std::collections::BTreeMap;

/// Name of the library's domain of all values.
const ANY: &str = "Any";

/// Fit of an argument to a parameter: smaller is better, `None` means that it does not fit.
pub(crate) type Fit = Option<u32>;

/// The bindings of type variables within one application.
#[derive(Clone, Debug, Default)]
pub(crate) struct TypeBindings {
    variables: BTreeMap<DomainId, TypeId>,
    /// Number of lookups of variables so far. A comparison of two types that made none does not
    /// depend on the bindings and can be cached in `cache`.
    looks: usize,
    /// `true` for the arguments of an equality, which treats natural numbers and integers alike,
    /// also within collections and tuples.
    equality: bool,
    /// `true` while two arguments of an equality are compared with each other.
    compares: bool,
    /// Cached fits of pairs of types without variables; avoids exponential work for nested
    /// products.
    cache: BTreeMap<(TypeId, TypeId), Fit>,
}

impl TypeBindings {
    /// Creates empty bindings; `equality` tells the arguments of an equality from those of other
    /// functions.
    pub fn of(equality: bool) -> Self {
        Self {
            equality,
            ..Self::default()
        }
    }
}

impl TypeTable {
    /// Returns the type at the end of the chain of bases of a concrete domain; any other type is
    /// its own root.
    pub fn root(&self, id: TypeId, domains: &[Domain]) -> TypeId {
        let mut at = id;
        // at most as many steps as there are domains: declaration errors may have made the chain a
        // cycle
        for _ in 0..=domains.len() {
            let domain = self.get(at).as_domain();
            match domain.and_then(|domain| domains[domain.0 as usize].kind.base()) {
                Some(base) => at = base,
                None => return at,
            }
        }
        at
    }

    /// Returns whether the type is an abstract domain, or a subset of one.
    pub fn is_abstract(&self, id: TypeId, domains: &[Domain]) -> bool {
        let root = self.get(self.root(id, domains)).as_domain();
        root.is_some_and(|root| domains[root.0 as usize].kind == DomainKind::Abstract)
    }

    /// Iterates over a type, its components, and the bases of the domains in it, each once.
    pub fn reachable_types<'a>(
        &'a self,
        id: TypeId,
        domains: &'a [Domain],
    ) -> impl Iterator<Item = TypeId> + 'a {
        // most types have no parts, or few: a set would cost more than it saves
        let (first, mut next) = (id, Some(id));
        let (mut seen, mut open) = (Vec::new(), Vec::new());
        std::iter::from_fn(move || {
            let id = next.take().or_else(|| open.pop())?;
            let mut add = |part: TypeId| {
                if part != first && !seen.contains(&part) {
                    seen.push(part);
                    open.push(part);
                }
            };
            match self.get(id) {
                Type::Domain(domain) => {
                    if let DomainKind::Concrete { base } = domains[domain.0 as usize].kind {
                        add(base);
                    }
                }
                Type::Prod(items) => items.iter().for_each(|item| add(*item)),
                Type::Seq(item) | Type::Powerset(item) | Type::Bag(item) => add(*item),
                Type::Map(key, value) => [*key, *value].into_iter().for_each(add),
                Type::Invalid
                | Type::Undef
                | Type::Boolean
                | Type::Integer
                | Type::Natural
                | Type::Real
                | Type::Complex
                | Type::Char
                | Type::String
                | Type::Rule => {}
            }
            Some(id)
        })
    }

    fn variable(&self, id: TypeId, domains: &[Domain]) -> Option<DomainId> {
        let domain = self.get(id).as_domain()?;
        (domains[domain.0 as usize].kind == DomainKind::Any).then_some(domain)
    }

    /// Returns `true` if a value of one type may stand where the other is wanted. The relation is
    /// symmetric: a concrete domain and its base fit in both directions, and updates check
    /// membership at run time.
    pub fn compatible(&self, a: TypeId, b: TypeId, domains: &[Domain]) -> bool {
        self.fit(a, b, domains, &mut TypeBindings::default())
            .is_some()
    }

    /// Returns how well `actual` fits `expected`, and binds the type variables of `expected`.
    pub(crate) fn fit(
        &self,
        expected: TypeId,
        actual: TypeId,
        domains: &[Domain],
        bindings: &mut TypeBindings,
    ) -> Fit {
        if let Some(known) = bindings.cache.get(&(expected, actual)) {
            return *known;
        }
        let looks = bindings.looks;
        let fit = self.compute_fit(expected, actual, domains, bindings);
        if bindings.looks == looks {
            bindings.cache.insert((expected, actual), fit);
        }
        fit
    }

    fn compute_fit(
        &self,
        expected: TypeId,
        actual: TypeId,
        domains: &[Domain],
        bindings: &mut TypeBindings,
    ) -> Fit {
        if expected == actual && self.variable(expected, domains).is_none() {
            return Some(0);
        }
        if let Some(variable) = self.variable(expected, domains) {
            return self.bind(variable, actual, domains, bindings);
        }
        if self.variable(actual, domains).is_some() {
            bindings.looks += 1;
            return Some(2);
        }
        let (wanted_root, actual_root) = (self.root(expected, domains), self.root(actual, domains));
        if wanted_root != expected || actual_root != actual {
            let step = u32::from(wanted_root != expected) + u32::from(actual_root != actual);
            // grows the stack: subsets of collections of subsets can be nested as deeply as there
            // are domains
            let fit = stacker::maybe_grow(64 * 1024, 1024 * 1024, || {
                self.fit(wanted_root, actual_root, domains, bindings)
            });
            return Some(fit?.saturating_add(step));
        }
        let compares = bindings.compares;
        let mut all = |pairs: &[(TypeId, TypeId)]| {
            pairs.iter().try_fold(0u32, |sum, &(a, b)| {
                Some(self.fit(a, b, domains, bindings)?.saturating_add(sum))
            })
        };
        match (self.get(expected), self.get(actual)) {
            (Type::Invalid | Type::Undef, _) | (_, Type::Invalid | Type::Undef) => Some(0),
            (Type::Prod(a), Type::Prod(b)) if a.len() == b.len() => {
                all(&a.iter().copied().zip(b.iter().copied()).collect::<Vec<_>>())
            }
            (Type::Seq(a), Type::Seq(b))
            | (Type::Powerset(a), Type::Powerset(b))
            | (Type::Bag(a), Type::Bag(b)) => all(&[(*a, *b)]),
            (Type::Map(a, b), Type::Map(c, d)) => all(&[(*a, *c), (*b, *d)]),
            (a, b) if compares && a.is_whole() && b.is_whole() => Some(1),
            _ => None,
        }
    }

    /// Binds a type variable, or compares the type with its binding.
    fn bind(
        &self,
        variable: DomainId,
        actual: TypeId,
        domains: &[Domain],
        bindings: &mut TypeBindings,
    ) -> Fit {
        bindings.looks += 1;
        if &*domains[variable.0 as usize].name == ANY {
            // `Any` is not a variable: each occurrence accepts a value of another type
            return Some(3);
        }
        let Some(&bound) = bindings.variables.get(&variable) else {
            bindings.variables.insert(variable, actual);
            return Some(3);
        };
        let mut within = TypeBindings {
            compares: bindings.equality,
            ..TypeBindings::default()
        };
        self.fit(bound, actual, domains, &mut within)?;
        // `including({}, 3)`: the empty set leaves the variable open, the element determines it
        if self.is_open(bound) {
            bindings.variables.insert(variable, actual);
        } else if bound != actual {
            // two subsets of one domain have that domain in common
            let root = self.root(bound, domains);
            if root != bound {
                bindings.variables.insert(variable, root);
            }
        }
        Some(3)
    }

    /// Returns `true` if `undef` or an empty collection leaves part of the type undetermined.
    fn is_open(&self, id: TypeId) -> bool {
        match self.get(id) {
            Type::Undef => true,
            Type::Seq(item) | Type::Powerset(item) | Type::Bag(item) => self.is_open(*item),
            Type::Prod(items) => items.iter().any(|&item| self.is_open(item)),
            Type::Map(key, value) => self.is_open(*key) || self.is_open(*value),
            Type::Invalid
            | Type::Boolean
            | Type::Integer
            | Type::Natural
            | Type::Real
            | Type::Complex
            | Type::Char
            | Type::String
            | Type::Rule
            | Type::Domain(_) => false,
        }
    }

    /// Replaces the type variables in a type by their bindings.
    pub(crate) fn substitute(
        &mut self,
        id: TypeId,
        domains: &[Domain],
        bindings: &TypeBindings,
    ) -> TypeId {
        if let Some(variable) = self.variable(id, domains) {
            return bindings.variables.get(&variable).copied().unwrap_or(id);
        }
        let ty = match self.get(id).clone() {
            Type::Prod(items) => Type::Prod(
                items
                    .into_iter()
                    .map(|item| self.substitute(item, domains, bindings))
                    .collect(),
            ),
            Type::Seq(item) => Type::Seq(self.substitute(item, domains, bindings)),
            Type::Powerset(item) => Type::Powerset(self.substitute(item, domains, bindings)),
            Type::Bag(item) => Type::Bag(self.substitute(item, domains, bindings)),
            Type::Map(key, value) => {
                let key = self.substitute(key, domains, bindings);
                Type::Map(key, self.substitute(value, domains, bindings))
            }
            Type::Invalid
            | Type::Undef
            | Type::Boolean
            | Type::Integer
            | Type::Natural
            | Type::Real
            | Type::Complex
            | Type::Char
            | Type::String
            | Type::Rule
            | Type::Domain(_) => return id,
        };
        self.id(ty)
    }

    /// Returns the common type of two, as for the branches of an `if` or the elements of a
    /// collection.
    pub(crate) fn join(&mut self, a: TypeId, b: TypeId, domains: &[Domain]) -> Option<TypeId> {
        if a == b {
            return Some(a);
        }
        if !self.compatible(a, b, domains) {
            return None;
        }
        if self.is_open(a) {
            return Some(b);
        }
        if self.is_open(b) {
            return Some(a);
        }
        Some(self.root(a, domains))
    }

    /// Formats a type as text, as in `Prod(Integer,Robot)`.
    pub fn show(&self, id: TypeId, domains: &[Domain]) -> String {
        let one = |item: TypeId| self.show(item, domains);
        match self.get(id) {
            Type::Invalid => "?".to_owned(),
            Type::Undef => "Undef".to_owned(),
            Type::Boolean => "Boolean".to_owned(),
            Type::Integer => "Integer".to_owned(),
            Type::Natural => "Natural".to_owned(),
            Type::Real => "Real".to_owned(),
            Type::Complex => "Complex".to_owned(),
            Type::Char => "Char".to_owned(),
            Type::String => "String".to_owned(),
            Type::Rule => "Rule".to_owned(),
            Type::Domain(domain) => domains[domain.0 as usize].name.to_string(),
            Type::Prod(items) => {
                let items: Vec<String> = items.iter().map(|&item| one(item)).collect();
                format!("Prod({})", items.join(","))
            }
            Type::Seq(item) => format!("Seq({})", one(*item)),
            Type::Powerset(item) => format!("Powerset({})", one(*item)),
            Type::Bag(item) => format!("Bag({})", one(*item)),
            Type::Map(key, value) => format!("Map({},{})", one(*key), one(*value)),
        }
    }
}

impl Model {
    /// Formats a type as text, as in `Prod(Integer,Robot)`.
    pub fn show_type(&self, ty: TypeId) -> String {
        self.types.show(ty, &self.domains)
    }
}
