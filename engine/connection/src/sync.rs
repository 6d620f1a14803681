//! Synchronisation primitives of the standard library, or of loom, which tries every interleaving.

#[cfg(not(feature = "loom"))]
pub(crate) use std::sync::{Arc, atomic::AtomicU8, atomic::AtomicUsize, atomic::fence};

#[cfg(feature = "loom")]
pub(crate) use loom::{
    cell::UnsafeCell,
    sync::Arc,
    sync::atomic::{AtomicU8, AtomicUsize, fence},
};

pub(crate) use std::sync::atomic::Ordering;

/// The standard cell with loom's interface: a closure accesses the content through a pointer.
#[cfg(not(feature = "loom"))]
pub(crate) struct UnsafeCell<T>(std::cell::UnsafeCell<T>);

#[cfg(not(feature = "loom"))]
impl<T> UnsafeCell<T> {
    pub(crate) fn new(content: T) -> Self {
        Self(std::cell::UnsafeCell::new(content))
    }

    #[inline(always)]
    pub(crate) fn with<R>(&self, f: impl FnOnce(*const T) -> R) -> R {
        f(self.0.get())
    }

    #[inline(always)]
    pub(crate) fn with_mut<R>(&self, f: impl FnOnce(*mut T) -> R) -> R {
        f(self.0.get())
    }
}
