//! Opens a composite with everything it names: read, checked in every profile, and planned.

use std::collections::{BTreeMap, BTreeSet};

use asmotion_datum::Schema;
use asmotion_diagnostics::{Diagnostic, Report, Severity, Sources, Span};

use asmotion_composite::family::Family;
use asmotion_composite::model::Composite;
use asmotion_composite::scope::SubstitutionNotes;
use asmotion_composite::types::Types;
use asmotion_composite::{Context, check};

use crate::flatten::{Parts, flatten};
use crate::plan::Plan;

/// A composite that was opened: its texts, what was found, and a plan for every profile in which
/// no error was found.
pub struct Opened {
    /// All texts that were read; the findings point into them.
    pub sources: Sources,
    /// Everything that was found, by place.
    pub report: Report,
    /// Whether a value that was set from outside all files is among what is wrong.
    pub outside: bool,
    /// The path of the outermost composite, as the loader resolved it.
    pub path: String,
    /// The files of message types that the composites name, as the loader resolved them.
    pub type_files: Vec<String>,
    /// The model of the outermost composite, as far as it could be read.
    pub composite: Option<Composite>,
    /// The profiles in order of their names; none where the composite has none.
    pub profiles: Vec<String>,
    plans: Vec<(Option<String>, Plan)>,
}

impl Opened {
    /// What a type looks like that a port of a plan names.
    pub fn schema(&self, name: &str) -> Option<&Schema> {
        self.plans.iter().find_map(|(_, plan)| plan.types.get(name))
    }

    /// The plan for a profile; for none where the composite has none. `None` where an error stands
    /// in the way, or where there is no such profile.
    pub fn plan(&self, profile: Option<&str>) -> Option<&Plan> {
        let found = self
            .plans
            .iter()
            .find(|(name, _)| name.as_deref() == profile);
        found.map(|(_, plan)| plan)
    }
}

/// Opens a composite: text in, a plan for every profile out, and every finding of all of them.
pub fn open(path: &str, context: &Context<'_>) -> Opened {
    let mut sources = Sources::new();
    let mut report = Report::new();
    let family = Family::read(path, context, &mut sources, &mut report);
    let types = family.all_types(context.catalogue, &mut report);
    let profiles = check::profiles(&family, &mut report);
    let broken = report.has_errors();

    let names: Vec<Option<&str>> = if profiles.is_empty() {
        vec![None]
    } else {
        profiles.iter().map(|name| Some(name.as_str())).collect()
    };
    let mut plans = Vec::new();
    let mut found = Vec::new();
    let mut outside = false;
    for profile in names {
        let mut notes = SubstitutionNotes::default();
        let faces = check::check(
            &family,
            &types,
            context.catalogue,
            profile,
            &mut notes.report,
        );
        let parts = Parts {
            family: &family,
            types: &types,
            faces: &faces,
            context,
            sources: &sources,
            profile,
        };
        let plan = flatten(&parts, &mut notes);
        if let Some(mut plan) = plan.filter(|_| !broken && !notes.report.has_errors()) {
            plan.types = schemas(&plan, &types);
            plans.push((profile.map(str::to_owned), plan));
        }
        outside |= notes.outside;
        found.push((profile, notes.report));
    }
    report.extend(merge(found));
    let composite = family
        .member(&family.root)
        .map(|member| member.composite.clone());
    let files = family.members().flat_map(|(_, member)| {
        let files = member.composite.head.types.iter();
        files
            .filter_map(|file| member.path(file))
            .map(str::to_owned)
    });
    let files: BTreeSet<String> = files.collect();
    Opened {
        sources,
        report: report.finish(),
        outside,
        path: family.root.clone(),
        type_files: files.into_iter().collect(),
        composite,
        profiles,
        plans,
    }
}

/// The shape of every type that a port names, as far as anybody says.
fn schemas(plan: &Plan, types: &BTreeMap<&str, Types<'_>>) -> BTreeMap<String, Schema> {
    let components = plan.components.iter();
    let ports = components.flat_map(|it| it.inputs.iter().chain(&it.outputs));
    ports
        .filter_map(|port| {
            let schema = types.values().find_map(|types| types.schema(&port.kind))?;
            Some((port.kind.clone(), schema))
        })
        .collect()
}

/// The findings of all profiles, each once; one that some profiles do not have says which do.
fn merge(reports: Vec<(Option<&str>, Report)>) -> Report {
    let profiles = reports.len();
    let mut merged: Vec<(Diagnostic, Vec<&str>)> = Vec::new();
    let mut places: BTreeMap<(Option<Span>, &str, String), Vec<usize>> = BTreeMap::new();
    for (profile, report) in reports {
        for finding in report.finish().diagnostics {
            let name = profile.unwrap_or("");
            let place = finding.primary.as_ref().map(|label| label.span);
            let known = places
                .entry((place, finding.code.name, finding.message.clone()))
                .or_default();
            let same = |index: &&usize| merged.get(**index).is_some_and(|it| it.0 == finding);
            match known
                .iter()
                .find(same)
                .copied()
                .and_then(|index| merged.get_mut(index))
            {
                Some((_, names)) => names.push(name),
                None => {
                    known.push(merged.len());
                    merged.push((finding, vec![name]));
                }
            }
        }
    }
    let findings = merged.into_iter().map(|(finding, mut names)| {
        names.dedup();
        if names.len() < profiles {
            finding.note(format!("in profile `{}`", names.join("`, `")))
        } else {
            finding
        }
    });
    Report {
        diagnostics: findings.collect(),
    }
}

/// Counts of a report, as people say them.
pub fn summary(report: &Report) -> String {
    let count = |severity, one: &str| match report.count(severity) {
        0 => format!("no {one}s"),
        1 => format!("1 {one}"),
        more => format!("{more} {one}s"),
    };
    let (errors, warnings) = (
        count(Severity::Error, "error"),
        count(Severity::Warning, "warning"),
    );
    format!("{errors}, {warnings}")
}
