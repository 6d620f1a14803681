//! Resolution of written values: locations removed, substitutions and defaults applied.

use std::net::SocketAddr;

use asmotion_diagnostics::Span;

use super::Key;
use crate::address::Endpoint;
use crate::at::At;
use crate::codes::c064::InvalidAddress;
use crate::end;
use crate::finding::Findings;
use crate::model::{Address, Amount, Condition, End, MessagePath, Template};
use crate::scope::{PropertyScope, SubstitutionNotes};
use crate::tree::Node;
use crate::value::SettingValue;

/// A written value that can be resolved.
pub trait Resolve {
    /// Type of the resolved value.
    type Resolved;

    /// Resolves the value; `None` if it is unknown, which has been reported.
    fn resolve(&self, key: &Key, to: &mut Resolver<'_>) -> Option<Self::Resolved>;
}

/// Context for the resolution of values.
pub struct Resolver<'r> {
    pub(crate) scope: &'r PropertyScope<'r>,
    /// Diagnostics and unset environment variables found so far.
    pub notes: &'r mut SubstitutionNotes,
    /// Name prefix of the enclosing composites, with a trailing slash.
    pub(crate) prefix: &'r str,
    /// Source location of the value being resolved.
    pub(crate) at: Span,
    /// Description of the element that has the value, for messages.
    pub owner: String,
}

impl<'r> Resolver<'r> {
    /// Creates a resolver for values in `scope`; `prefix` contains the names of the enclosing composites.
    pub fn new(
        scope: &'r PropertyScope<'r>,
        prefix: &'r str,
        notes: &'r mut SubstitutionNotes,
    ) -> Self {
        let at = Span::default();
        Self {
            scope,
            notes,
            prefix,
            at,
            owner: String::new(),
        }
    }

    /// Qualifies the name of an element of this composite.
    pub fn local(&self, name: &str) -> String {
        format!("{}{name}", self.prefix)
    }

    /// Resolves an optional table; its defaults if absent.
    pub fn or_default<T: Resolve<Resolved: Default>>(
        &mut self,
        written: Option<&T>,
    ) -> T::Resolved {
        let resolved = written.and_then(|it| it.resolve(&Key::NAME, self));
        resolved.unwrap_or_default()
    }

    /// Resolves a value or table.
    pub fn of<T: Resolve>(&mut self, written: &T) -> Option<T::Resolved> {
        written.resolve(&Key::NAME, self)
    }
}

impl<T: Resolve> Resolve for At<T> {
    type Resolved = T::Resolved;

    fn resolve(&self, key: &Key, to: &mut Resolver<'_>) -> Option<T::Resolved> {
        to.at = self.span;
        self.value.resolve(key, to)
    }
}

/// Implements `Resolve` for types that resolve to themselves or to their text.
macro_rules! plain {
    ($($kind:ty => $resolved:ty: |$it:ident| $value:expr;)*) => {
        $(impl Resolve for $kind {
            type Resolved = $resolved;

            fn resolve(&self, _: &Key, _: &mut Resolver<'_>) -> Option<$resolved> {
                let $it = self;
                Some($value)
            }
        })*
    };
}

plain! {
    String => String: |it| it.clone();
    bool => bool: |it| *it;
    u64 => u64: |it| *it;
    f64 => f64: |it| *it;
    MessagePath => String: |it| it.to_string();
    Condition => String: |it| it.text.value.clone();
    End => end::End: |it| end::End {
        component: it.component.value.clone(),
        name: it.name.value.clone(),
    };
}

impl Resolve for Template {
    type Resolved = Endpoint;

    fn resolve(&self, _: &Key, to: &mut Resolver<'_>) -> Option<Endpoint> {
        let filled = to.scope.fill(self, to.notes)?;
        Some(Endpoint::new(filled.text, filled.shown))
    }
}

/// Reports an invalid address with the name of the element that `Resolver::owner` holds.
impl Resolve for Address {
    type Resolved = SocketAddr;

    fn resolve(&self, _: &Key, to: &mut Resolver<'_>) -> Option<SocketAddr> {
        let filled = to.scope.fill(&self.0, to.notes)?;
        let address = filled.text.parse().ok();
        if address.is_none() {
            to.notes.found(InvalidAddress {
                name: to.owner.clone(),
                text: filled.shown,
                at: to.at,
            });
        }
        address
    }
}

impl Resolve for Amount {
    type Resolved = u64;

    fn resolve(&self, key: &Key, to: &mut Resolver<'_>) -> Option<u64> {
        to.scope.amount(key, self, to.at, to.notes)
    }
}

impl Resolve for Node {
    type Resolved = SettingValue;

    fn resolve(&self, _: &Key, to: &mut Resolver<'_>) -> Option<SettingValue> {
        to.scope.node(self, to.notes)
    }
}
