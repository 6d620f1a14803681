//! Everything a composite needs from outside its files.

use asmotion_diagnostics::Loader;

use crate::catalogue::{Catalogue, Tables};
use crate::environment::{EmptyEnvironment, VariableSource};
use crate::signature::{NoSpecifications, Specifications};

/// Everything a composite needs from outside its files.
#[derive(Clone, Copy)]
pub struct Context<'a> {
    /// Where files come from.
    pub loader: &'a dyn Loader,
    /// Where `${NAME}` comes from.
    pub environment: &'a dyn VariableSource,
    /// What this build has.
    pub catalogue: &'a dyn Catalogue,
    /// Opens `.asm` files.
    pub specifications: &'a dyn Specifications,
    /// Properties of the outermost composite, set from outside: name and text.
    pub settings: &'a [(String, String)],
}

impl<'a> Context<'a> {
    /// Files alone: no variables, nothing in the build, specifications not opened.
    pub fn files(loader: &'a dyn Loader) -> Self {
        Self {
            loader,
            environment: &EmptyEnvironment,
            catalogue: &Tables::EMPTY,
            specifications: &NoSpecifications,
            settings: &[],
        }
    }
}
