//! Domains: their elements, as far as known at compile time.

use super::Lowering;
use crate::code::BinderRange;
use crate::id::DomainId;
use crate::program::{Domain, DomainElements};
use crate::value_shape::ValueShape;
use asmotion_hir::{DomainKind, Meaning, Term, TermKind, Type, TypeId};
use asmotion_value::{Atom, Value};

/// Converts the id of a domain, whose number is the same in the model and in the program.
pub(super) fn id(id: asmotion_hir::DomainId) -> DomainId {
    DomainId(id.0)
}

impl Lowering<'_> {
    /// Fills the table of domains. Definitions to be computed at run time get their body later.
    pub(super) fn domains(&mut self) {
        for index in 0..self.model.domains.len() {
            let domain = &self.model.domains[index];
            let base = self.base(&domain.kind).map(id);
            let elements = self.elements(asmotion_hir::DomainId(index as u32));
            let grows = match domain.kind {
                DomainKind::Abstract => true,
                DomainKind::Concrete { base } => self.is_abstract(base),
                DomainKind::Any | DomainKind::Basic | DomainKind::Enum { .. } => false,
            };
            self.program.domains.push(Domain {
                elements,
                base,
                grows,
                is_extended: false,
                is_created_for: false,
            });
        }
    }

    /// Notes that a rule adds elements to a domain, and thereby to those that it is a subset of.
    pub(super) fn extends(&mut self, domain: DomainId) {
        self.program.domains[domain.0 as usize].is_created_for = true;
        let mut extended = Some(domain);
        while let Some(id) = extended {
            let domain = &mut self.program.domains[id.0 as usize];
            if std::mem::replace(&mut domain.is_extended, true) {
                return;
            }
            extended = domain.base;
        }
    }

    fn elements(&mut self, domain: asmotion_hir::DomainId) -> DomainElements {
        let declared = self.model.domain(domain);
        match declared.kind {
            DomainKind::Any | DomainKind::Basic => DomainElements::Open,
            DomainKind::Enum { first, count } => DomainElements::Atoms { first, count },
            DomainKind::Abstract => self.constants(domain),
            DomainKind::Concrete { base } => match &declared.definition {
                Some(definition) => match self.interval(&definition.root) {
                    Some((low, high)) => DomainElements::Ints { low, high },
                    None => {
                        let body = self.reserve_body(declared.span, definition);
                        DomainElements::Computed(body)
                    }
                },
                None if self.is_abstract(base) => self.constants(domain),
                None => DomainElements::Undefined,
            },
        }
    }

    fn is_abstract(&self, ty: TypeId) -> bool {
        self.model.types.is_abstract(ty, &self.model.domains)
    }

    /// The declared domain that a concrete one is a subset of.
    fn base(&self, kind: &DomainKind) -> Option<asmotion_hir::DomainId> {
        self.model.types.get(kind.base()?).as_domain()
    }

    /// Returns the constants of an abstract domain and its subsets, which have consecutive numbers.
    fn constants(&self, domain: asmotion_hir::DomainId) -> DomainElements {
        let contains = |mut inner: asmotion_hir::DomainId| {
            for _ in 0..=self.model.domains.len() {
                if inner == domain {
                    return true;
                }
                match self.base(&self.model.domain(inner).kind) {
                    Some(base) => inner = base,
                    None => return false,
                }
            }
            false
        };
        let atoms = self
            .model
            .atoms
            .iter()
            .enumerate()
            .filter(|(_, atom)| contains(atom.domain));
        let mut indices = atoms.map(|(index, _)| index as u32);
        let first = indices.next();
        let count = first.map_or(0, |_| 1 + indices.count() as u32);
        DomainElements::Atoms {
            first: Atom(first.unwrap_or(0)),
            count,
        }
    }

    /// Returns the bounds of a closed term that is an interval of integers or lists all of one.
    fn interval(&self, term: &Term) -> Option<(i64, i64)> {
        if let TermKind::Interval(_, from, to, None) = &*term.kind {
            let (low, high) = (self.integer(from, 0)?, self.integer(to, 0)?);
            return (low <= high).then_some((low, high));
        }
        let TermKind::Listed(_, items) = &*term.kind else {
            return None;
        };
        let mut numbers: Vec<i64> = items
            .iter()
            .map(|item| self.integer(item, 0))
            .collect::<Option<_>>()?;
        numbers.sort_unstable();
        numbers.dedup();
        let (low, high) = (*numbers.first()?, *numbers.last()?);
        (high.checked_sub(low)? == numbers.len() as i64 - 1).then_some((low, high))
    }

    /// Evaluates a closed term that is an integer, a negated integer, or a constant defined as one.
    fn integer(&self, term: &Term, depth: u32) -> Option<i64> {
        if let TermKind::Value(Value::Int(number)) = &*term.kind {
            return Some(*number);
        }
        let TermKind::Apply(function, arguments) = &*term.kind else {
            return None;
        };
        if depth >= 32 {
            return None;
        }
        let function = self.model.function(*function);
        match (&function.meaning, arguments.as_slice()) {
            (Meaning::Defined(body), []) if function.kind == asmotion_hir::FunctionKind::Static => {
                self.integer(&body.root, depth + 1)
            }
            (Meaning::Builtin(builtin), [one]) if builtin.name == "minus" => {
                self.integer(one, depth + 1)?.checked_neg()
            }
            (Meaning::Builtin(builtin), [one]) if builtin.name == "plus" => {
                self.integer(one, depth + 1)
            }
            (Meaning::Builtin(builtin), [left, right]) => {
                let (left, right) = (
                    self.integer(left, depth + 1)?,
                    self.integer(right, depth + 1)?,
                );
                match builtin.name {
                    "plus" => left.checked_add(right),
                    "minus" => left.checked_sub(right),
                    "mult" => left.checked_mul(right),
                    _ => None,
                }
            }
            _ => None,
        }
    }

    /// Returns the shape of a type's values.
    pub(super) fn shape(&self, ty: TypeId) -> ValueShape {
        let boxed = |item: TypeId| Box::new(self.shape(item));
        match self.model.types.get(ty) {
            Type::Invalid | Type::Undef => ValueShape::Any,
            Type::Boolean => ValueShape::Bool,
            Type::Integer => ValueShape::Int,
            Type::Natural => ValueShape::Natural,
            Type::Real => ValueShape::Real,
            Type::Complex => ValueShape::Complex,
            Type::Char => ValueShape::Char,
            Type::String => ValueShape::Text,
            Type::Rule => ValueShape::Rule,
            Type::Domain(domain) if self.model.domain(*domain).kind == DomainKind::Any => {
                ValueShape::Any
            }
            Type::Domain(domain) => ValueShape::Domain(id(*domain)),
            Type::Prod(items) => {
                ValueShape::Tuple(items.iter().map(|&item| self.shape(item)).collect())
            }
            Type::Seq(item) => ValueShape::Seq(boxed(*item)),
            Type::Powerset(item) => ValueShape::Set(boxed(*item)),
            Type::Bag(item) => ValueShape::Bag(boxed(*item)),
            Type::Map(key, value) => ValueShape::Map(boxed(*key), boxed(*value)),
        }
    }

    /// Returns `true` if values of a type may nest to any depth, because a component has any type.
    pub(super) fn is_open(&self, ty: TypeId) -> bool {
        let mut parts = self.model.types.reachable_types(ty, &self.model.domains);
        parts.any(|part| match self.model.types.get(part) {
            Type::Invalid | Type::Undef => true,
            Type::Domain(domain) => self.model.domain(*domain).kind == DomainKind::Any,
            Type::Prod(_)
            | Type::Seq(_)
            | Type::Powerset(_)
            | Type::Bag(_)
            | Type::Map(..)
            | Type::Boolean
            | Type::Integer
            | Type::Natural
            | Type::Real
            | Type::Complex
            | Type::Char
            | Type::String
            | Type::Rule => false,
        })
    }

    /// Returns the concrete domain that values of a type must be elements of, checked by updates.
    pub(super) fn membership(&self, ty: TypeId) -> Option<DomainId> {
        let domain = self.model.types.get(ty).as_domain()?;
        let is_concrete = self.model.domain(domain).kind.base().is_some();
        is_concrete.then_some(id(domain))
    }

    /// Returns `true` if a component of the type is a concrete domain with a definition, so that not every value of
    /// its shape belongs to the type.
    pub(super) fn is_restricted(&self, ty: TypeId) -> bool {
        let mut parts = self.model.types.reachable_types(ty, &self.model.domains);
        parts.any(|part| {
            let elements = |it: DomainId| &self.program.domains[it.0 as usize].elements;
            self.membership(part)
                .is_some_and(|domain| *elements(domain) != DomainElements::Undefined)
        })
    }

    /// Returns `true` if an argument must be an element of a concrete domain that does not grow.
    /// For subsets of abstract domains, the check of types suffices.
    pub(super) fn is_narrow(&self, parameters: &[TypeId]) -> bool {
        let (types, domains) = (&self.model.types, &self.model.domains);
        let mut parts = parameters
            .iter()
            .flat_map(|&ty| types.reachable_types(ty, domains));
        parts.any(|part| {
            let domain = self.membership(part);
            domain.is_some_and(|domain| !self.program.domains[domain.0 as usize].grows)
        })
    }

    /// Returns the elements of a domain as a range that needs no computation where possible.
    pub(super) fn range(&self, domain: asmotion_hir::DomainId) -> BinderRange {
        match (
            &self.program.domains[domain.0 as usize].elements,
            &self.model.domain(domain).kind,
        ) {
            (DomainElements::Ints { low, high }, _) => BinderRange::Ints(*low, *high),
            (DomainElements::Atoms { first, count }, DomainKind::Enum { .. }) => {
                BinderRange::Atoms(first.0, *count)
            }
            _ => BinderRange::Domain(id(domain)),
        }
    }
}
