//! Numbers of what a program contains.

/// Number of a location in the state.
pub type Slot = u32;

/// Number of a variable in its frame.
pub type Local = u32;

/// Number of a place in the sources, an index into [`crate::Lowered::origins`]. 0 stands for no
/// place.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Origin(pub u32);

/// Index of a function in a [`Program`](crate::Program); the same as in the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FunctionId(pub u32);

/// Index of a domain in a [`Program`](crate::Program); the same as in the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct DomainId(pub u32);

/// Index into [`Program::bodies`](crate::Program::bodies).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct BodyId(pub u32);

/// Index into [`Program::routines`](crate::Program::routines).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct RoutineId(pub u32);
