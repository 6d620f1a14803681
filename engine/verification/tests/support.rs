//! Composites of the repository and in memory.

use asmotion_composite::{AsmFiles, Context, NoPrograms, Tables, VariableSource};
use asmotion_diagnostics::{LoadError, Loader};
use asmotion_lang::hir::ReadOptions;
use asmotion_plan::{Opened, Plan};
use asmotion_verification::{ComponentModel, ModelContext, ModelError, component_model};
use asmotion_verify::{Options, Verification, verify};
use std::sync::{Arc, LazyLock};

/// Files of the repository, some of them with other texts.
#[derive(Clone, Default)]
pub struct Files {
    changed: Vec<(String, String)>,
}

impl Files {
    /// Replaces a part of a file, which occurs once.
    pub fn change(mut self, path: &str, from: &str, to: &str) -> Self {
        let text = self.read(path).expect("a file");
        assert_eq!(text.matches(from).count(), 1, "`{from}` in {path}");
        self.changed.retain(|(known, _)| known != path);
        self.changed.push((path.to_owned(), text.replace(from, to)));
        self
    }

    /// Adds a file.
    pub fn with(mut self, path: &str, text: String) -> Self {
        self.changed.push((path.to_owned(), text));
        self
    }

    /// The protocol of a component of the catalogue, as changed: its file has the path `components/…/protocol.asm`.
    pub fn protocol(&self, component: &str) -> Option<String> {
        let text = asmotion_components::protocol(component)?;
        let is_changed = |path: &str| {
            let original = std::fs::read_to_string(in_repository(path));
            path.starts_with("components/") && original.is_ok_and(|it| it == text)
        };
        let changed = self.changed.iter().find(|(path, _)| is_changed(path));
        Some(changed.map_or_else(|| text.to_owned(), |(_, text)| text.clone()))
    }
}

pub fn in_repository(path: &str) -> String {
    format!("{}/../../{path}", env!("CARGO_MANIFEST_DIR"))
}

impl Loader for Files {
    fn read(&self, path: &str) -> Result<Arc<str>, LoadError> {
        if let Some((_, text)) = self.changed.iter().find(|(known, _)| known == path) {
            return Ok(Arc::from(text.as_str()));
        }
        let text = std::fs::read_to_string(in_repository(path)).map_err(|error| LoadError {
            path: path.to_owned(),
            reason: error.to_string(),
        })?;
        Ok(Arc::from(text))
    }

    fn resolve(&self, from: &str, import: &str) -> Option<String> {
        let folder = from.rsplit_once('/').map_or("", |(folder, _)| folder);
        let beside = if folder.is_empty() {
            import.to_owned()
        } else {
            format!("{folder}/{import}")
        };
        let with_ending = format!("{beside}.asm");
        [beside, with_ending]
            .into_iter()
            .find(|path| self.read(path).is_ok())
    }
}

pub struct NoVariables;

impl VariableSource for NoVariables {
    fn variable(&self, _: &str) -> Option<String> {
        None
    }

    fn secret(&self, path: &str) -> Result<String, String> {
        Err(format!("no secret {path}"))
    }
}

/// The catalogue, with the components of tests.
pub static CATALOGUE: LazyLock<Tables> = LazyLock::new(|| Tables {
    components: Box::leak(
        [asmotion_components::COMPONENTS, crate::mutants::COMPONENTS]
            .concat()
            .into_boxed_slice(),
    ),
    messages: asmotion_components::MESSAGES,
    interfaces: asmotion_components::INTERFACES,
    builtins: &[asmotion_composite::model::BuiltinComponent::PortProxy],
    ros: None,
});

pub fn open(files: &Files, path: &str) -> Opened {
    let context = Context {
        loader: files,
        environment: &NoVariables,
        catalogue: &*CATALOGUE,
        specifications: &AsmFiles::new(files),
        programs: &NoPrograms,
        settings: &[],
    };
    let opened = asmotion_plan::open(path, &context);
    assert!(
        !opened.report.has_errors(),
        "{}",
        asmotion_lang::render_all(&opened.report, &opened.sources, asmotion_lang::Style::Plain)
    );
    opened
}

pub fn plan(opened: &Opened) -> &Plan {
    opened.plan(None).expect("a plan")
}

pub fn model(files: &Files, plan: &Plan, component: &str) -> Result<ComponentModel, ModelError> {
    let context = ModelContext {
        plan,
        loader: files,
        protocols: &|name| files.protocol(name),
        options: ReadOptions::default(),
    };
    component_model(&context, component)
}

/// The model of a component; panics with the text of the fault.
pub fn modelled(files: &Files, path: &str, component: &str) -> ComponentModel {
    let opened = open(files, path);
    match model(files, plan(&opened), component) {
        Ok(model) => model,
        Err(ModelError::Specification { sources, report }) => panic!(
            "{}",
            asmotion_lang::render_all(&report, &sources, asmotion_lang::Style::Plain)
        ),
        Err(error) => panic!("{error}"),
    }
}

pub fn verified(model: ComponentModel, options: &Options) -> Verification {
    let verified = verify(model.specification, options, &mut |_| true);
    verified.unwrap_or_else(|refusal| {
        let sources = &refusal.specification.sources;
        panic!(
            "{}",
            asmotion_lang::render_all(&refusal.report, sources, asmotion_lang::Style::Plain)
        )
    })
}
