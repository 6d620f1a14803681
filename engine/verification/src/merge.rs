//! Puts a specification and its environment together.

use crate::actor::{Actor, ReadFiles};
use crate::error::{ModelError, failed};
use crate::glue::Glue;
use crate::instrument::{Instrumentation, check_parameters};
use asmotion_diagnostics::{Sources, Span};
use asmotion_lang::hir::{self, LoadedFiles, ReadOptions, SourceUnit};
use asmotion_lang::syntax::ast::{
    File, FunctionKind, Import, Init, NameText, PropertyKind, Rule, RuleKind,
};
use asmotion_lang::{Specification, ir, syntax};
use std::sync::Arc;

const TIME_LIBRARY: &str = "<TimeLibrary>";

/// The library of timers without a clock.
const TIME_WITHOUT_CLOCK: &str = include_str!("TimeLibrary.asm");

/// Returns the specification of the whole.
///
/// # Errors
/// The parts do not fit together.
pub(crate) fn merge(
    verified: ReadFiles,
    actors: Vec<Actor>,
    glue: &Glue,
    text: &str,
    uses_time: bool,
    mut sources: Sources,
    options: &ReadOptions,
) -> Result<Specification, ModelError> {
    let mut loaded = verified.loaded;
    let file = sources.add("environment", text);
    let parsed = syntax::parse(file, text);
    if parsed.report.has_errors() {
        return Err(failed(&mut sources, parsed.report));
    }
    if uses_time {
        abstract_time(&mut loaded, &mut sources);
    }
    let mut trees: Vec<File> = actors.into_iter().flat_map(|it| it.trees).collect();
    let own = loaded
        .units
        .iter()
        .filter(|it| !it.library)
        .map(|it| &it.tree);
    check_parameters(&own.chain(&trees).collect::<Vec<_>>(), &glue.given)?;
    let instrumentation = Instrumentation { given: &glue.given };
    let own = loaded.units.iter_mut().filter(|it| !it.library);
    for tree in own.map(|it| &mut it.tree).chain(&mut trees) {
        instrumentation.file(tree);
        for function in &mut tree.functions {
            let name = &*function.name.text;
            if glue.controlled.contains(name) {
                function.kind = FunctionKind::Controlled;
            } else if glue.fixed.contains(name) {
                function.kind = FunctionKind::Static;
            }
        }
        if uses_time {
            // without a clock there is no time of a start
            for init in &mut tree.inits {
                init.functions.retain(|it| &*it.name.text != "start");
            }
        }
    }
    if let Some(unit) = loaded.units.last_mut() {
        for tree in trees {
            add(&mut unit.tree, tree, true);
        }
        add(&mut unit.tree, parsed.file, false);
        if let Some(main) = &mut unit.tree.main {
            let span = main.body.span;
            let environment = RuleKind::Macro {
                name: NameText {
                    text: Arc::from("r_environment"),
                    span,
                },
                arguments: Vec::new(),
            };
            let environment = Rule {
                kind: Box::new(environment),
                span,
                depth: 1,
            };
            let depth = main.body.depth + 1;
            let step = std::mem::replace(&mut main.body, environment.clone());
            main.body = Rule {
                kind: Box::new(RuleKind::Seq(vec![step, environment])),
                span,
                depth,
            };
        }
    }
    specification(loaded, sources, options)
}

/// Adds the declarations of one file to another; properties other than fairness constraints are those of the verified
/// specification only.
fn add(to: &mut File, from: File, has_main: bool) {
    to.domains.extend(from.domains);
    to.functions.extend(from.functions);
    to.domain_definitions.extend(from.domain_definitions);
    to.function_definitions.extend(from.function_definitions);
    to.rules.extend(from.rules);
    to.rules.extend(from.main.filter(|_| has_main));
    let is_fairness = |kind: &PropertyKind| match kind {
        PropertyKind::Justice(_) | PropertyKind::Compassion(..) => true,
        PropertyKind::Invariant { .. }
        | PropertyKind::Constraint(_)
        | PropertyKind::Ctl(_)
        | PropertyKind::Ltl(_) => false,
    };
    to.properties.extend(
        from.properties
            .into_iter()
            .filter(|it| is_fairness(&it.kind)),
    );
    if to.inits.is_empty() {
        to.inits.push(Init {
            name: NameText {
                text: Arc::from("s0"),
                span: Span::default(),
            },
            default: true,
            domains: Vec::new(),
            functions: Vec::new(),
            agents: Vec::new(),
        });
    }
    let default = from
        .inits
        .iter()
        .find(|it| it.default)
        .or(from.inits.first());
    for init in &mut to.inits {
        init.functions
            .extend(default.iter().flat_map(|it| it.functions.iter().cloned()));
        init.domains
            .extend(default.iter().flat_map(|it| it.domains.iter().cloned()));
    }
}

/// Replaces the library of timers by one without a clock, or adds it.
fn abstract_time(loaded: &mut LoadedFiles, sources: &mut Sources) {
    let file = sources.add(TIME_LIBRARY, TIME_WITHOUT_CLOCK);
    let tree = syntax::parse(file, TIME_WITHOUT_CLOCK).file;
    if let Some(unit) = loaded.units.iter_mut().find(|it| it.path == TIME_LIBRARY) {
        unit.tree = tree;
        return;
    }
    let standard = loaded
        .units
        .iter()
        .position(|it| it.path == "<StandardLibrary>");
    let at = loaded.units.len().saturating_sub(1);
    let library = SourceUnit {
        path: TIME_LIBRARY.to_owned(),
        file,
        tree,
        library: true,
        imports: standard.map(|unit| (0, unit)).into_iter().collect(),
        broken_imports: Vec::new(),
        unreadable: None,
    };
    loaded.units.insert(at, library);
    if let Some(unit) = loaded.units.last_mut() {
        let path = NameText {
            text: Arc::from("TimeLibrary"),
            span: Span::default(),
        };
        unit.imports.push((unit.tree.imports.len(), at));
        unit.tree.imports.push(Import { path, names: None });
    }
}

fn specification(
    mut loaded: LoadedFiles,
    mut sources: Sources,
    options: &ReadOptions,
) -> Result<Specification, ModelError> {
    let (model, found) = hir::analyse_with(&mut loaded, &sources, options);
    let Some(model) = model else {
        let mut report = loaded.report;
        report.extend(found);
        return Err(failed(&mut sources, report));
    };
    match ir::lower(&model) {
        Ok(lowered) => Ok(Specification {
            model,
            program: Arc::new(lowered.program),
            origins: lowered.origins,
            sources,
            report: Default::default(),
        }),
        Err(report) => Err(failed(&mut sources, report)),
    }
}
