//! `--mutants`: which changes of a specification no property notices.

use super::words::{heading, place_text};
use super::{Verify, interrupt};
use crate::exit::Exit;
use crate::files::DiskLoader;
use crate::numbers::number;
use crate::terminal::{BAD, FAINT, GOOD, NAME, NOTE, TerminalOutput};
use asmotion_lang::{Loader, ReadOptions, Report};
use asmotion_verify::{Mutant, SystemSpecification, Verdict, mutants, verify_system};
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::sync::Arc;

/// States of a mutant, as a multiple of those of the specification.
const STATES: u64 = 10;

/// States that every mutant may have.
const LEAST_STATES: u64 = 10_000;

/// The verdict of the properties on a mutant.
enum MutantFate {
    /// A property that holds for the specification is violated.
    Killed(String),
    /// All properties hold that hold for the specification.
    Survives,
    /// Not all states of the mutant were explored.
    Unknown,
}

impl Verify {
    /// Verifies the mutants of the specification at a path.
    pub(super) fn mutants_of(&self, path: &str, terminal: &mut TerminalOutput) -> Exit {
        let system = match self.file_system(path, terminal) {
            Ok(Some(system)) => system,
            Ok(None) => return Exit::Ok,
            Err(exit) => return exit,
        };
        let Some(machine) = system.machines.first() else {
            return Exit::Ok;
        };
        let mutants = mutants(&machine.specification);
        let (verification, _) = match self.verification(system, None, terminal) {
            Ok(verified) => verified,
            Err(exit) => return exit,
        };
        if verification.incomplete.is_some() {
            terminal.error("not all states of the specification were explored, so that mutants cannot be compared with it");
            return Exit::Undecided;
        }
        let holding = verification
            .properties
            .iter()
            .filter(|it| it.verdict.holds());
        let holding: BTreeSet<String> = holding.map(heading).collect();
        let limit = verification.states.saturating_mul(STATES).max(LEAST_STATES);
        let Some(original) = verification.machines.first().map(|it| &it.specification) else {
            return Exit::Ok;
        };
        let mut fates = Vec::new();
        for mutant in mutants {
            if interrupt::has_occurred() {
                terminal.error("interrupted");
                return Exit::Undecided;
            }
            let text = original.sources.text(mutant.place.file);
            let text = mutant.applied_to(text);
            let fate = text.and_then(|text| self.fate(path, text, (&holding, limit), terminal));
            fates.extend(fate.map(|fate| (mutant, fate)));
        }
        self.show_fates(path, &fates, original, terminal)
    }

    /// Returns the fate of a mutant; `None` if it is no specification.
    fn fate(
        &self,
        path: &str,
        text: String,
        (holding, limit): (&BTreeSet<String>, u64),
        terminal: &mut TerminalOutput,
    ) -> Option<MutantFate> {
        let files = MutatedFile {
            path,
            text: text.into(),
        };
        let options = ReadOptions {
            initial: self.init.clone(),
            ..ReadOptions::default()
        };
        let specification = asmotion_lang::open_with(path, &files, &options).ok()?;
        let mut system = SystemSpecification::of(specification);
        system.environment = self.environment(&mut system.machines, terminal).ok()?;
        let mut options = self.options(&mut system.machines, terminal).ok()?;
        let own = options.limits.states.unwrap_or(limit);
        options.limits.states = Some(own.min(limit));
        let mut proceed = |_| !interrupt::has_occurred();
        let verification = match verify_system(system, &options, &mut proceed) {
            Ok(verification) => verification,
            Err(refusal) if is_limit(&refusal.report) => return Some(MutantFate::Unknown),
            Err(_) => return Some(MutantFate::Killed("it cannot be verified".to_owned())),
        };
        let mut properties = verification.properties.iter();
        let killed = properties.find(|property| {
            property.verdict.is_violated() && holding.contains(&heading(property))
        });
        if let Some(property) = killed {
            return Some(MutantFate::Killed(heading(property)));
        }
        let mut properties = verification.properties.iter();
        let is_unknown = properties.any(|it| matches!(it.verdict, Verdict::Unknown));
        Some(if is_unknown {
            MutantFate::Unknown
        } else {
            MutantFate::Survives
        })
    }

    fn show_fates(
        &self,
        path: &str,
        fates: &[(Mutant, MutantFate)],
        original: &asmotion_lang::Specification,
        terminal: &mut TerminalOutput,
    ) -> Exit {
        let count =
            |is: fn(&MutantFate) -> bool| fates.iter().filter(|(_, fate)| is(fate)).count() as u64;
        let killed = count(|fate| matches!(fate, MutantFate::Killed(_)));
        let unknown = count(|fate| matches!(fate, MutantFate::Unknown));
        let survive = count(|fate| matches!(fate, MutantFate::Survives));
        let place = |mutant: &Mutant| place_text(original, mutant.place);
        if self.json {
            let mutants = fates.iter().map(|(mutant, fate)| {
                let (word, by) = match fate {
                    MutantFate::Killed(by) => ("killed", Some(by)),
                    MutantFate::Survives => ("survives", None),
                    MutantFate::Unknown => ("unknown", None),
                };
                json!({ "place": place(mutant), "change": mutant.change, "fate": word, "by": by })
            });
            terminal.result(json!({
                "type": "mutants", "v": 1,
                "path": path,
                "mutants": mutants.collect::<Vec<Value>>(),
                "killed": killed,
                "survive": survive,
                "unknown": unknown,
            }));
        } else {
            terminal.result(format_args!("{NAME}{path}{NAME:#}"));
            for (mutant, fate) in fates {
                let (colour, word) = match fate {
                    MutantFate::Killed(_) => continue,
                    MutantFate::Survives => (BAD, "survives"),
                    MutantFate::Unknown => (NOTE, "unknown"),
                };
                let at = place(mutant);
                terminal.result(format_args!(
                    "  {colour}{word:<9}{colour:#} {}  {FAINT}{at}{FAINT:#}",
                    mutant.change
                ));
            }
            let percent = (killed * 100)
                .checked_div(fates.len() as u64)
                .unwrap_or(100);
            terminal.result(format_args!(
                "  {GOOD}{percent} %{GOOD:#} of {} mutants are killed: {} killed, {} survive, {} not known",
                fates.len(),
                number(killed),
                number(survive),
                number(unknown)
            ));
        }
        match (survive, unknown) {
            (0, 0) => Exit::Ok,
            (0, _) => Exit::Undecided,
            _ => Exit::Findings,
        }
    }
}

/// Returns `true` if a specification is refused for a limit of the verifier, which says nothing about the specification: too many
/// combinations in a step, storage that fails, or a construct that diagrams do not represent.
fn is_limit(report: &Report) -> bool {
    let mut findings = report.diagnostics.iter();
    findings.any(|it| ["M002", "M013", "M030"].contains(&it.code.name))
}

/// The files on disk, one of which is changed.
struct MutatedFile<'a> {
    path: &'a str,
    text: Arc<str>,
}

impl Loader for MutatedFile<'_> {
    fn read(&self, path: &str) -> Result<Arc<str>, asmotion_lang::diagnostics::LoadError> {
        if path == self.path {
            Ok(self.text.clone())
        } else {
            DiskLoader.read(path)
        }
    }

    fn resolve(&self, from: &str, import: &str) -> Option<String> {
        DiskLoader.resolve(from, import)
    }
}
