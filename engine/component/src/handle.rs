//! Handles of a component's declarations: small, typed and copied, so that a cycle looks up no names.

use std::fmt;
use std::marker::PhantomData;

use crate::operation::Operation;

macro_rules! handle {
    ($($(#[$meta:meta])* $name:ident<$of:ident $(: $bound:path)?>;)+) => {
        $(
            $(#[$meta])*
            pub struct $name<$of $(: $bound)?> {
                /// Position in the declaring component's table.
                index: u32,
                /// Number of the interface on which it was declared.
                owner: u32,
                of: PhantomData<fn() -> $of>,
            }

            impl<$of $(: $bound)?> $name<$of> {
                pub(crate) fn new(owner: u32, index: usize) -> Self {
                    // an index beyond `u32` is unrealistic; the saturated handle would be refused
                    let index = u32::try_from(index).unwrap_or(u32::MAX);
                    Self { index, owner, of: PhantomData }
                }

                /// Position in the owner's table; `usize::MAX`, which no table has, for any other component.
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

            impl<$of $(: $bound)?> PartialEq for $name<$of> {
                fn eq(&self, other: &Self) -> bool {
                    (self.owner, self.index) == (other.owner, other.index)
                }
            }

            impl<$of $(: $bound)?> Eq for $name<$of> {}

            impl<$of $(: $bound)?> fmt::Debug for $name<$of> {
                fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                    write!(f, "{}({})", stringify!($name), self.index)
                }
            }
        )+
    };
}

handle! {
    /// Handle of an input port.
    In<T>;
    /// Handle of an output port.
    Out<T>;
    /// Handle of a property.
    Property<T>;
    /// Handle of an operation that the component provides.
    Provided<O: Operation>;
    /// Handle of an operation that the component calls.
    Required<O: Operation>;
}
