//! The components and messages of this binary, and access to environment variables.

use asmotion_composite::model::BuiltinComponent;
use asmotion_composite::{AsmFiles, Context, Programs, Tables, VariableSource};
use asmotion_lang::Loader;

use crate::programs::AskedPrograms;

/// The components, messages and interfaces of this build.
pub const BUILD: Tables = Tables {
    components: asmotion_components::COMPONENTS,
    messages: asmotion_components::MESSAGES,
    interfaces: asmotion_components::INTERFACES,
    builtins: &[BuiltinComponent::PortProxy],
};

/// The programs that this invocation has asked for their declarations.
pub static PROGRAMS: AskedPrograms = AskedPrograms::new();

/// Opens a composite with properties set on the command line, as pairs of name and text. Starts the programs that implement
/// components to ask them for their declarations.
pub fn open(
    path: &str,
    settings: &[(String, String)],
    loader: &dyn Loader,
) -> asmotion_plan::Opened {
    open_with(path, settings, loader, &PROGRAMS)
}

/// Like [`open`], with other declarations of programs.
pub fn open_with(
    path: &str,
    settings: &[(String, String)],
    loader: &dyn Loader,
    programs: &dyn Programs,
) -> asmotion_plan::Opened {
    let context = Context {
        loader,
        environment: &ProcessEnvironment,
        catalogue: &BUILD,
        specifications: &AsmFiles::new(loader),
        programs,
        settings,
    };
    asmotion_plan::open(path, &context)
}

/// Environment variables and secret files of the process.
#[derive(Clone, Copy, Debug, Default)]
struct ProcessEnvironment;

impl VariableSource for ProcessEnvironment {
    fn variable(&self, name: &str) -> Option<String> {
        std::env::var(name).ok()
    }

    fn secret(&self, path: &str) -> Result<String, String> {
        let text = std::fs::read_to_string(path).map_err(|error| error.to_string())?;
        Ok(text.trim_end_matches(['\r', '\n']).to_owned())
    }
}
