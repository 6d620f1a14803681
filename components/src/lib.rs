//! The catalogue: component name to constructor
