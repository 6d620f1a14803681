//! Programs of the language.
