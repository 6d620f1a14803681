//! Loading, checking and planning of a composite.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use asmotion_component::declaration::OperationDeclaration;
use asmotion_datum::Schema;
use asmotion_diagnostics::{Diagnostic, Report, Severity, Sources, Span};

use asmotion_composite::family::Family;
use asmotion_composite::model::Composite;
use asmotion_composite::scope::SubstitutionNotes;
use asmotion_composite::types::Types;
use asmotion_composite::{Catalogue, Context, check};

use crate::flatten::{Parts, flatten};
use crate::plan::Plan;

/// A loaded composite: its source texts, diagnostics and a plan for every profile without errors.
#[derive(Debug)]
pub struct Opened {
    /// All source texts; diagnostics refer to them.
    pub sources: Sources,
    /// All diagnostics, ordered by location.
    pub report: Report,
    /// Whether an error concerns a value that was set outside the files, such as on the command line.
    pub outside: bool,
    /// Resolved path of the outermost composite.
    pub path: String,
    /// Resolved paths of the type files named by the composites.
    pub type_files: Vec<String>,
    /// Model of the outermost composite; `None` if it could not be read.
    pub composite: Option<Composite>,
    /// Profile names in ascending order; empty if the composite has none.
    pub profiles: Vec<String>,
    plans: Vec<(Option<String>, Arc<Plan>)>,
}

impl Opened {
    /// Returns the schema of a message type used by a port of a plan.
    pub fn schema(&self, name: &str) -> Option<&Schema> {
        self.plans.iter().find_map(|(_, plan)| plan.types.get(name))
    }

    /// Returns the plan of a profile; pass `None` if the composite has no profiles. Returns `None` if the profile is
    /// unknown or has errors. Those who keep a plan share it.
    pub fn plan(&self, profile: Option<&str>) -> Option<&Arc<Plan>> {
        let found = self
            .plans
            .iter()
            .find(|(name, _)| name.as_deref() == profile);
        found.map(|(_, plan)| plan)
    }

    /// Returns `true` if a component of a profile stands for one of another robot. Its interface is known only to that robot.
    pub fn has_robot_components(&self) -> bool {
        let components = self.plans.iter().flat_map(|(_, plan)| &plan.components);
        let mut addresses = components.map(|it| it.implementation.robot_component());
        addresses.any(|it| it.is_some())
    }

    /// Names of the processes that have components in every profile.
    pub fn processes(&self) -> BTreeSet<&str> {
        let mut plans = self.plans.iter().map(|(_, plan)| {
            let used = plan.processes.iter().filter(|it| !it.components.is_empty());
            used.map(|it| &*it.name).collect::<BTreeSet<_>>()
        });
        let first = plans.next().unwrap_or_default();
        plans.fold(first, |all, used| &all & &used)
    }
}

/// Loads and checks a composite in every profile and plans the profiles without errors.
pub fn open(path: &str, context: &Context<'_>) -> Opened {
    let mut sources = Sources::new();
    let mut report = Report::new();
    let mut family = Family::read(path, context, &mut sources, &mut report);
    family.complete_programs(context.catalogue);
    let family = family;
    let build = context.catalogue;
    let catalogue = family.extend(build);
    let context = &Context {
        catalogue: &catalogue,
        ..*context
    };
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
            plan.interfaces = interfaces(&plan, &family, build);
            plans.push((profile.map(str::to_owned), Arc::new(plan)));
        }
        outside |= notes.outside;
        found.push((profile, notes.report));
    }
    report.extend(merge(found));
    let files = family.members().flat_map(|(_, member)| {
        let files = member.composite.head.types.iter();
        files
            .filter_map(|file| member.path(file))
            .map(str::to_owned)
    });
    let files: BTreeSet<String> = files.collect();
    let report = family.combine_instances(report).finish();
    let path = family.root.clone();
    Opened {
        sources,
        report,
        outside,
        path,
        type_files: files.into_iter().collect(),
        composite: family.into_root(),
        profiles,
        plans,
    }
}

/// Schemas of the message types used by ports; unknown types are absent.
fn schemas(plan: &Plan, types: &BTreeMap<&str, Types<'_>>) -> BTreeMap<String, Schema> {
    let components = plan.components.iter();
    let ports = components.flat_map(|it| it.inputs.iter().chain(&it.outputs));
    let kinds: BTreeSet<&String> = ports.map(|port| &port.kind).collect();
    kinds
        .into_iter()
        .filter_map(|kind| {
            let schema = types.values().find_map(|types| types.schema(kind))?;
            Some((kind.clone(), schema))
        })
        .collect()
}

/// Operations of the service interfaces that only folders with definitions of ROS have.
fn interfaces(
    plan: &Plan,
    family: &Family,
    build: &dyn Catalogue,
) -> BTreeMap<String, Vec<OperationDeclaration>> {
    let components = plan.components.iter();
    let named = components.flat_map(|it| it.services.iter().chain(&it.references));
    let unknown = named.filter(|it| build.operations(&it.interface).is_none());
    unknown
        .filter_map(|it| Some((it.interface.clone(), family.ros_interface(&it.interface)?)))
        .collect()
}

/// Merges the diagnostics of all profiles; those that occur in some profiles only are marked with the profile names.
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

/// Returns the number of errors and warnings as text.
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
