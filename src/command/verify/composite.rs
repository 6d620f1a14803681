//! `asmotion verify` of composites: each specification together with its environment.

use super::projection::ProjectedRun;
use super::watched_results::WatchedResults;
use super::{Verify, exit, json, show};
use crate::build::Build;
use crate::exit::Exit;
use crate::terminal::{NOTE, TerminalOutput, count};
use crate::verification::{
    AlikeComponents, components_with_properties, describe, exchanges_messages,
    in_terms_of_composite, link_messages, model, with_origins,
};
use asmotion_lang::ReadOptions;
use asmotion_plan::{Component, Implementation, Opened, Plan};
use asmotion_verification::{ComponentModel, ModelError, ModelledEnvironment};
use asmotion_verify::{MachineSchedule, SystemSpecification, VerifiedMachine};
use clap::Args;
use serde_json::{Value, json};
use std::collections::BTreeSet;

/// Composites.
#[derive(Args)]
pub struct CompositeOptions {
    /// Component of a composite to verify [default: those whose specifications state properties]
    #[arg(long, value_name = "NAME")]
    component: Vec<String>,

    /// Profile of a composite
    #[arg(long)]
    profile: Option<String>,

    /// Sets a property of a composite
    #[arg(long, value_name = "NAME=VALUE")]
    set: Vec<String>,

    /// Prints the environment of the specifications of a composite, and verifies nothing
    #[arg(long)]
    print_environment: bool,
}

impl Verify {
    /// Returns an error text for an option that is of no use for the files.
    pub(super) fn misplaced(
        &self,
        has_composites: bool,
        has_specifications: bool,
    ) -> Option<&'static str> {
        let given = &self.composite;
        let of_composites = !given.component.is_empty()
            || given.profile.is_some()
            || !given.set.is_empty()
            || given.print_environment;
        if of_composites && has_specifications {
            return Some(
                "`--component`, `--profile`, `--set` and `--print-environment` are for composites",
            );
        }
        if has_composites && self.system.environment != "free" {
            return Some(
                "`--environment` is for specifications: in a composite, the other components are the environment",
            );
        }
        None
    }

    /// Verifies the specifications of a composite.
    pub(super) fn composite(
        &self,
        build: &Build,
        path: &str,
        watched: &mut WatchedResults,
        terminal: &mut TerminalOutput,
    ) -> Exit {
        let mut settings = Vec::new();
        for text in &self.composite.set {
            let Some((name, value)) = text.split_once('=') else {
                terminal.error(format_args!("`--set {text}`: write NAME=VALUE"));
                return Exit::Usage;
            };
            settings.push((name.to_owned(), value.to_owned()));
        }
        let opened = build.open(path, &settings, &self.files);
        if opened.report.has_errors() {
            terminal.report(&opened.report, &opened.sources);
            terminal.error(count(&opened.report).unwrap_or_default());
            return if opened.outside {
                Exit::Usage
            } else {
                Exit::refused(path)
            };
        }
        let plan = match self.plan(&opened) {
            Ok(plan) => plan,
            Err(text) => {
                terminal.error(text);
                return Exit::Usage;
            }
        };
        if exchanges_messages(plan) {
            return self.partners(plan, path, watched, terminal);
        }
        let components: Vec<String> = if self.composite.component.is_empty() {
            let stated = components_with_properties(plan);
            stated.into_iter().map(|it| it.name.clone()).collect()
        } else {
            self.composite.component.clone()
        };
        if self.has_exports() && components.len() > 1 {
            terminal.error(format_args!(
                "`--trace`, `--avalla` and `--itf` are for one component: choose one with `--component` ({})",
                components.join(", ")
            ));
            return Exit::Usage;
        }
        if components.is_empty() {
            terminal.error(format_args!(
                "`{path}` has no component with a specification"
            ));
            return Exit::Usage;
        }
        let mut seen = BTreeSet::new();
        let names = components.iter().map(String::as_str);
        let names: Vec<&str> = names.filter(|it| seen.insert(*it)).collect();
        let groups = AlikeComponents::among(build, plan, &names, &self.terms(), &self.files);
        let exits = groups
            .iter()
            .map(|alike| self.components(build, plan, (path, alike), watched, terminal));
        exits.fold(Exit::Ok, Exit::max)
    }

    fn plan<'o>(&self, opened: &'o Opened) -> Result<&'o Plan, String> {
        let profile = self.composite.profile.as_deref();
        let plan = opened.plan(profile).map(|plan| &**plan);
        plan.ok_or_else(|| {
            let known = opened.profiles.join("`, `");
            match profile {
                Some(profile) if known.is_empty() => {
                    format!("the composite has no profiles: leave out `--profile {profile}`")
                }
                Some(profile) => {
                    format!("the composite has no profile `{profile}`; it has `{known}`")
                }
                None => format!("choose a profile with `--profile`: `{known}`"),
            }
        })
    }

    /// Verifies specifications that exchange messages: all of them together.
    fn partners(
        &self,
        plan: &Plan,
        path: &str,
        watched: &mut WatchedResults,
        terminal: &mut TerminalOutput,
    ) -> Exit {
        if !self.composite.component.is_empty() || self.composite.print_environment {
            terminal.error(format_args!(
                "the specifications of `{path}` exchange messages (CommonBehavior) and are verified together: leave out \
                 `--component` and `--print-environment`"
            ));
            return Exit::Usage;
        }
        let mut system = SystemSpecification::default();
        let specified = plan.components.iter();
        let specified = specified.filter(|it| is_specified(it));
        let periods: BTreeSet<u64> = specified.map(|it| it.pace.period_ms).collect();
        if periods.len() == 1 && !periods.contains(&0) {
            // all make a step in each period
            system.schedule = MachineSchedule::Synchronous;
        }
        for component in &plan.components {
            let Implementation::Asm { file, .. } = &component.implementation else {
                continue;
            };
            match self.open(file, self.init.clone(), terminal) {
                Ok(specification) => system.machines.push(VerifiedMachine {
                    name: component.name.clone(),
                    specification,
                }),
                Err(exit) => return exit,
            }
        }
        link_messages(plan, &mut system);
        self.verified(path, system, watched, terminal)
            .unwrap_or_else(|exit| exit)
    }

    /// The terms of the options, in which names of the environment can occur.
    fn terms(&self) -> Vec<String> {
        let lists = [
            &self.property,
            &self.possible,
            &self.assume,
            &self.values,
            &self.fair,
            &self.strongly_fair,
        ];
        let terms = lists.into_iter().flatten().chain(&self.end);
        terms.cloned().collect()
    }

    /// Verifies the first of components that are alike.
    fn components(
        &self,
        build: &Build,
        plan: &Plan,
        (path, alike): (&str, &AlikeComponents<'_>),
        watched: &mut WatchedResults,
        terminal: &mut TerminalOutput,
    ) -> Exit {
        let (component, others) = (alike.component, alike.others_in_words(""));
        let options = ReadOptions {
            initial: self.init.clone(),
            ..ReadOptions::default()
        };
        let found = model(build, plan, component, &self.files, options);
        let ComponentModel {
            specification,
            environment,
        } = match found {
            Ok(model) => model,
            Err(error) => {
                let usage = matches!(error, ModelError::NoComponent(_));
                let others = others.map_or_else(String::new, |it| format!(" (and {it})"));
                terminal.error(format_args!(
                    "{path}, {component}{others}: {}",
                    describe(&error)
                ));
                return if usage { Exit::Usage } else { Exit::Findings };
            }
        };
        if self.composite.print_environment {
            terminal.result(environment.text.trim_end());
            if let Some(others) = others {
                terminal.result(format_args!("// the same, up to names: {others}"));
            }
            return Exit::Ok;
        }
        let system = SystemSpecification::of(specification);
        let kept = watched.exploration(component);
        let (mut verification, time) = match self.verification(system, kept, terminal) {
            Ok(found) => found,
            Err(exit) => {
                if let Some(others) = others {
                    terminal.error(format_args!("the same is true of {others}"));
                }
                return exit;
            }
        };
        let run = self
            .has_exports()
            .then(|| ProjectedRun::of(&verification, &environment));
        in_terms_of_composite(&mut verification, &environment);
        let mut exit = exit(&verification);
        if self.json {
            let mut result = json::verification(path, &verification, time);
            result["component"] = component.into();
            if !alike.others.is_empty() {
                result["alike"] = alike.others.clone().into();
            }
            result["environment"] = environment_json(&environment);
            terminal.result(result);
        } else {
            with_origins(&mut verification, &environment);
            show::text(
                &format!("{path}, {component}"),
                &verification,
                time,
                self.memory_limit(),
                terminal,
            );
            show_environment(&environment, terminal);
            if let Some(others) = others {
                terminal.result(format_args!(
                    "  {NOTE}alike{NOTE:#} {others}: the same results, up to names of components"
                ));
            }
            watched.show_changes(component, &verification, terminal);
            for other in &alike.others {
                watched.keep(other, &verification);
            }
        }
        let machines = &verification.machines;
        let run = run.flatten();
        exit = exit.max(self.write_projected(run.as_ref(), &environment, machines, terminal));
        exit
    }
}

fn is_specified(component: &Component) -> bool {
    matches!(component.implementation, Implementation::Asm { .. })
}

fn environment_json(environment: &ModelledEnvironment) -> Value {
    let pairs = environment.others.iter();
    let others =
        pairs.map(|(component, file)| json!({ "component": component, "behaviour": file }));
    let origins = environment.origins.iter().map(|(input, origins)| {
        let origins = origins
            .iter()
            .map(|it| json!({ "from": it.from, "values": it.values }));
        (input.clone(), Value::from(origins.collect::<Vec<Value>>()))
    });
    json!({
        "components": others.collect::<Vec<Value>>(),
        "without_protocol": environment.open,
        "independent": environment.independent,
        "outside": environment.outside,
        "assumptions": environment.assumptions,
        "origins": Value::Object(origins.collect()),
    })
}

fn show_environment(environment: &ModelledEnvironment, terminal: &mut TerminalOutput) {
    for (component, file) in &environment.others {
        terminal.result(format_args!(
            "  {NOTE}environment{NOTE:#} {component} behaves as in {file}"
        ));
    }
    for component in &environment.open {
        terminal.result(format_args!(
            "  {NOTE}environment{NOTE:#} {component} has no protocol: any event at any time"
        ));
    }
    for component in &environment.independent {
        terminal.result(format_args!(
            "  {NOTE}environment{NOTE:#} {component} receives nothing from {}: any event at any time",
            environment.component
        ));
    }
    if !environment.outside.is_empty() {
        terminal.result(format_args!(
            "  {NOTE}environment{NOTE:#} from outside of the composite at any time: {}",
            environment.outside.join(", ")
        ));
    }
    for assumption in &environment.assumptions {
        terminal.result(format_args!("  {NOTE}assumed{NOTE:#} {assumption}"));
    }
}
