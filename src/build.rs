//! The components and messages of this binary, and access to environment variables.

use asmotion_composite::model::BuiltinComponent;
use asmotion_composite::{AsmFiles, Context, Tables, VariableSource};
use asmotion_lang::Loader;

/// The components, messages and interfaces of this build.
pub const BUILD: Tables = Tables {
    components: asmotion_components::COMPONENTS,
    messages: asmotion_components::MESSAGES,
    interfaces: asmotion_components::INTERFACES,
    builtins: &[BuiltinComponent::PortProxy],
};

/// Opens a composite with properties set on the command line, as pairs of name and text.
pub fn open(
    path: &str,
    settings: &[(String, String)],
    loader: &dyn Loader,
) -> asmotion_plan::Opened {
    let context = Context {
        loader,
        environment: &ProcessEnvironment,
        catalogue: &BUILD,
        specifications: &AsmFiles::new(loader),
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
