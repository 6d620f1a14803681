//! Types and their table, which interns them.

use crate::id::DomainId;
use std::collections::BTreeMap;

/// Id of a type in a [`TypeTable`]; types are interned, so equal types have equal ids.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TypeId(pub u32);

/// The forms of a type.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Type {
    /// Type of an erroneous term; compatible with every type.
    Invalid,
    /// Type of `undef`; compatible with every type.
    Undef,
    /// Truth values.
    Boolean,
    /// Integers, in 64 bits.
    Integer,
    /// Non-negative integers, a domain of its own in AsmetaL.
    Natural,
    /// Real numbers, as 64-bit floats.
    Real,
    /// Complex numbers.
    Complex,
    /// Characters.
    Char,
    /// Character strings.
    String,
    /// Rules as values, as in `<<r_x>>`.
    Rule,
    /// A declared domain: abstract, enumeration, concrete, or an anydomain (a type variable).
    Domain(DomainId),
    /// `Prod(…)`: tuples, by the types of their components.
    Prod(Vec<TypeId>),
    /// `Seq(…)`: finite sequences.
    Seq(TypeId),
    /// `Powerset(…)`: finite sets.
    Powerset(TypeId),
    /// `Bag(…)`: finite multisets.
    Bag(TypeId),
    /// `Map(…)`: finite maps, by the types of key and value.
    Map(TypeId, TypeId),
}

impl Type {
    /// Returns the basic type of this name. Basic domains are known even without an import of the
    /// library.
    pub fn basic(name: &str) -> Option<Self> {
        Some(match name {
            "Boolean" => Self::Boolean,
            "Integer" => Self::Integer,
            "Natural" => Self::Natural,
            "Real" => Self::Real,
            "Complex" => Self::Complex,
            "Char" => Self::Char,
            "String" => Self::String,
            "Rule" => Self::Rule,
            "Undef" => Self::Undef,
            _ => return None,
        })
    }

    /// The domain, if the type is a declared one.
    pub fn as_domain(&self) -> Option<DomainId> {
        if let Self::Domain(domain) = self {
            Some(*domain)
        } else {
            None
        }
    }

    /// Returns `true` for Integer and Natural.
    pub(crate) fn is_whole(&self) -> bool {
        matches!(self, Self::Integer | Self::Natural)
    }
}

/// The types of a model, interned.
#[derive(Debug, Default)]
pub struct TypeTable {
    types: Vec<Type>,
    ids: BTreeMap<Type, TypeId>,
}

impl TypeTable {
    /// Interns a type and returns its id.
    pub fn id(&mut self, ty: Type) -> TypeId {
        if let Some(&id) = self.ids.get(&ty) {
            return id;
        }
        let id = TypeId(self.types.len() as u32);
        self.types.push(ty.clone());
        self.ids.insert(ty, id);
        id
    }

    /// Iterates over the ids of all types.
    pub fn ids(&self) -> impl Iterator<Item = TypeId> + use<> {
        (0..self.types.len() as u32).map(TypeId)
    }

    /// Returns the type with this id.
    pub fn get(&self, id: TypeId) -> &Type {
        &self.types[id.0 as usize]
    }
}
