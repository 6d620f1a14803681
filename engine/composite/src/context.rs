//! Inputs of a composite from outside its files.

use asmotion_diagnostics::Loader;

use crate::catalogue::{Catalogue, Tables};
use crate::environment::{EmptyEnvironment, VariableSource};
use crate::programs::{NoPrograms, Programs};
use crate::signature::{NoSpecifications, Specifications};

/// Inputs of a composite from outside its files.
#[derive(Clone, Copy)]
pub struct Context<'a> {
    /// Loader of composite, type and property files.
    pub loader: &'a dyn Loader,
    /// Source of environment variables and secret files.
    pub environment: &'a dyn VariableSource,
    /// Components, message types and interfaces in the executable.
    pub catalogue: &'a dyn Catalogue,
    /// Loader of `.asm` files.
    pub specifications: &'a dyn Specifications,
    /// Asks programs that implement components for their declarations.
    pub programs: &'a dyn Programs,
    /// Properties of the outermost composite set from outside, as name and text.
    pub settings: &'a [(String, String)],
}

impl<'a> Context<'a> {
    /// Creates a context with files only: no environment variables, an empty catalogue, specifications that are not loaded
    /// and programs that are not asked.
    pub fn files(loader: &'a dyn Loader) -> Self {
        Self {
            loader,
            environment: &EmptyEnvironment,
            catalogue: &Tables::EMPTY,
            specifications: &NoSpecifications,
            programs: &NoPrograms,
            settings: &[],
        }
    }
}
