//! From what was written to what holds: places left out, substitutions made.

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

/// Something written that stands for a value.
pub trait Resolve {
    /// The value.
    type Resolved;

    /// The value; `None` where it is not known, which was reported.
    fn resolve(&self, key: &Key, to: &mut Resolver<'_>) -> Option<Self::Resolved>;
}

/// What values of a composite are resolved with.
pub struct Resolver<'r> {
    pub(crate) scope: &'r PropertyScope<'r>,
    /// Collects the findings, and the variables that are not set.
    pub notes: &'r mut SubstitutionNotes,
    /// The names of the composites around, each with a `/` behind it.
    pub(crate) prefix: &'r str,
    /// Where the value being resolved was written.
    pub(crate) at: Span,
    /// What it is a value of, for messages.
    pub owner: String,
}

impl<'r> Resolver<'r> {
    /// Resolves values in `scope`; the names around are in `prefix`.
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

    /// The name that something of this composite has in the whole system.
    pub fn local(&self, name: &str) -> String {
        format!("{}{name}", self.prefix)
    }

    /// What an optional table holds; its defaults where it was left out.
    pub fn or_default<T: Resolve<Resolved: Default>>(
        &mut self,
        written: Option<&T>,
    ) -> T::Resolved {
        let resolved = written.and_then(|it| it.resolve(&Key::NAME, self));
        resolved.unwrap_or_default()
    }

    /// What a value or table holds.
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

/// Values that stand for themselves, or are told by their text.
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
