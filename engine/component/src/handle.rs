//! Handles: what a component keeps of its declarations. Small, typed, copied; no look-up by name in a cycle.

use std::fmt;
use std::marker::PhantomData;

use crate::operation::Operation;

macro_rules! handle {
    ($($(#[$meta:meta])* $name:ident<$of:ident $(: $bound:path)?>;)+) => {
        $(
            $(#[$meta])*
            pub struct $name<$of $(: $bound)?> {
                /// Position in the table of the component that declared it.
                index: u32,
                /// The interface it was declared on.
                owner: u32,
                of: PhantomData<fn() -> $of>,
            }

            impl<$of $(: $bound)?> $name<$of> {
                pub(crate) fn new(owner: u32, index: usize) -> Self {
                    // No component has four thousand million ports; were there one, the handle would be refused.
                    let index = u32::try_from(index).unwrap_or(u32::MAX);
                    Self { index, owner, of: PhantomData }
                }

                /// Its place in the table of its owner; in another's, a place that does not exist.
                pub(crate) fn position(self, owner: u32) -> usize {
                    if self.owner == owner { self.index as usize } else { usize::MAX }
                }
            }

            impl<$of $(: $bound)?> Clone for $name<$of> {
                fn clone(&self) -> Self {
                    *self
                }
            }

            impl<$of $(: $bound)?> Copy for $name<$of> {}

            impl<$of $(: $bound)?> fmt::Debug for $name<$of> {
                fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                    write!(f, "{}({})", stringify!($name), self.index)
                }
            }
        )+
    };
}

handle! {
    /// An input port.
    In<T>;
    /// An output port.
    Out<T>;
    /// A property.
    Property<T>;
    /// An operation that the component serves.
    Provided<O: Operation>;
    /// An operation that the component calls.
    Required<O: Operation>;
}
