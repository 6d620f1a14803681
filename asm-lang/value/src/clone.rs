//! Cloning and dropping, with a fast path for scalars: machines do little else, and mostly to
//! scalars.

#![expect(unsafe_code, reason = "scalars are copied bitwise")]

use crate::value::Value;
use std::sync::Arc;

impl Clone for Value {
    #[inline]
    fn clone(&self) -> Self {
        if self.is_scalar() {
            // SAFETY: `self` is valid for reads, and a scalar owns nothing, so a bitwise copy is a
            // valid clone.
            return unsafe { std::ptr::read(self) };
        }
        self.share()
    }
}

impl Value {
    /// Replaces this value. A scalar is overwritten by a plain store, because it needs no drop.
    #[inline]
    pub fn replace_by(&mut self, value: Self) {
        if self.is_scalar() {
            // SAFETY: `self` is valid for writes, and the overwritten scalar owns nothing that has
            // to be dropped.
            unsafe { std::ptr::write(self, value) }
        } else {
            *self = value;
        }
    }

    /// Drops the value; returns immediately for a scalar.
    #[inline]
    pub fn discard(self) {
        if self.is_scalar() {
            std::mem::forget(self);
        }
    }

    /// Returns `true` if the value owns no heap memory.
    #[inline]
    pub fn is_scalar(&self) -> bool {
        match self {
            Self::Undef
            | Self::Bool(_)
            | Self::Int(_)
            | Self::Real(_)
            | Self::Char(_)
            | Self::Atom(_)
            | Self::Rule(_) => true,
            Self::Text(_)
            | Self::Complex(_)
            | Self::Tuple(_)
            | Self::Seq(_)
            | Self::Set(_)
            | Self::Bag(_)
            | Self::Map(_) => false,
        }
    }

    fn share(&self) -> Self {
        match self {
            Self::Undef => Self::Undef,
            Self::Bool(truth) => Self::Bool(*truth),
            Self::Int(number) => Self::Int(*number),
            Self::Real(number) => Self::Real(*number),
            Self::Char(character) => Self::Char(*character),
            Self::Atom(atom) => Self::Atom(*atom),
            Self::Rule(rule) => Self::Rule(*rule),
            Self::Text(text) => Self::Text(Arc::clone(text)),
            Self::Complex(parts) => Self::Complex(Arc::clone(parts)),
            Self::Tuple(items) => Self::Tuple(Arc::clone(items)),
            Self::Seq(items) => Self::Seq(Arc::clone(items)),
            Self::Set(items) => Self::Set(Arc::clone(items)),
            Self::Bag(items) => Self::Bag(Arc::clone(items)),
            Self::Map(pairs) => Self::Map(Arc::clone(pairs)),
        }
    }
}
