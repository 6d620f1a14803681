//! The comparison of two versions of a running system.

use std::collections::BTreeMap;

use asmotion_component::Declaration;
use asmotion_network::OuterName;
use asmotion_plan::Plan;
use asmotion_runtime::{Change, Run};

use super::fixed_part::FixedPart;
use super::version::Version;

/// The differences between two versions: how they are carried out, and those that require a restart.
pub(super) struct Difference<'p> {
    pub(super) run: &'p dyn Run,
    /// The running and the wanted version.
    pub(super) versions: (&'p Version, &'p Version),
    /// Declarations of new and replaced components.
    pub(super) declared: BTreeMap<String, Declaration>,
    /// Removed connections and wires.
    pub(super) ends: Vec<Change>,
    /// Removed and added components.
    pub(super) members: Vec<Change>,
    pub(super) begins: Vec<Change>,
    pub(super) fixed: Vec<FixedPart>,
}

impl<'p> Difference<'p> {
    /// Returns the comparison of a running and a wanted version, in which nothing differs yet.
    pub(super) fn new(versions: (&'p Version, &'p Version), run: &'p dyn Run) -> Self {
        Self {
            run,
            versions,
            declared: BTreeMap::new(),
            ends: Vec::new(),
            members: Vec::new(),
            begins: Vec::new(),
            fixed: Vec::new(),
        }
    }

    /// Returns whether a component runs in this process. None moves to another one.
    pub(super) fn is_here(&self, component: &str) -> bool {
        let (running, wanted) = self.versions;
        running.part.has(component) || wanted.part.has(component)
    }

    /// Returns whether a component is neither new nor removed.
    pub(super) fn is_kept(&self, component: &str) -> bool {
        let (running, wanted) = self.versions;
        let mut plans = [&running.plan, &wanted.plan].into_iter();
        plans.all(|plan| plan.component(component).is_some())
    }

    /// Returns the declaration of a component in the wanted version.
    pub(super) fn declaration(&self, component: &str) -> Declaration {
        let new = self.declared.get(component).cloned();
        let declared = new.or_else(|| self.run.declaration(component));
        declared.unwrap_or_default()
    }
}

/// The name and the bus of a component of a plan outside.
pub(super) fn outer_name<'p>(plan: &'p Plan, component: &str) -> Option<OuterName<'p>> {
    let known = plan.component(component)?;
    Some(OuterName {
        id: &known.id,
        bus: plan.broker_of(component),
    })
}
