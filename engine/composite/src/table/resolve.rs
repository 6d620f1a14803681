//! Resolution of written values: locations removed, substitutions and defaults applied.

use asmotion_diagnostics::Span;

use super::{Key, NamedValue};
use crate::at::At;
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

    /// Qualifies the name of an element of this composite. A URL names an element of another system and stays as it is.
    pub fn local(&self, name: &str) -> String {
        if name.contains("://") {
            return name.to_owned();
        }
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

impl<T: Resolve> Resolve for NamedValue<T> {
    type Resolved = (String, T::Resolved);

    fn resolve(&self, key: &Key, to: &mut Resolver<'_>) -> Option<(String, T::Resolved)> {
        let value = self.value.resolve(key, to)?;
        Some((self.name.value.clone(), value))
    }
}

impl<T: Resolve> Resolve for Box<T> {
    type Resolved = T::Resolved;

    fn resolve(&self, key: &Key, to: &mut Resolver<'_>) -> Option<T::Resolved> {
        T::resolve(self, key, to)
    }
}

/// Values that resolve to themselves.
macro_rules! plain {
    ($($kind:ty)*) => {
        $(impl Resolve for $kind {
            type Resolved = Self;

            fn resolve(&self, _: &Key, _: &mut Resolver<'_>) -> Option<Self> {
                Some(self.to_owned())
            }
        })*
    };
}

plain! { String bool u64 f64 }

impl Resolve for Node {
    type Resolved = SettingValue;

    fn resolve(&self, _: &Key, to: &mut Resolver<'_>) -> Option<SettingValue> {
        to.scope.node(self, to.notes)
    }
}
