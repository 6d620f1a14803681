//! Components that differ: removed, added, replaced, with other properties or periods.

use asmotion_component::Interface;
use asmotion_datum::Datum;
use asmotion_plan::{Component, Implementation, Pace, Plan, Port, PropertyValues};
use asmotion_runtime::{Change, Replacement};

use super::component_difference;
use super::difference::Difference;
use super::fixed_part::FixedPart;
use super::version::specification;
use crate::start;

impl Difference<'_> {
    pub(super) fn components(&mut self, running: &Plan, wanted: &Plan) {
        for before in &running.components {
            if !self.is_here(&before.name) {
                continue;
            }
            match wanted.component(&before.name) {
                Some(after) => self.component((before, running), (after, wanted)),
                None => self.remove(before),
            }
        }
        let new = |it: &&Component| running.component(&it.name).is_none();
        for component in wanted.components.iter().filter(new) {
            if self.is_here(&component.name) {
                self.add(component);
            }
        }
    }

    fn remove(&mut self, component: &Component) {
        self.builtin(component, "removed");
        self.members.push(Change::Remove {
            component: component.name.clone(),
        });
    }

    /// Records a new or removed component whose implementation is connected when its process starts.
    pub(super) fn builtin(&mut self, component: &Component, change: &'static str) {
        if let Implementation::Builtin { name, .. } = &component.implementation
            && component.bridge.is_none()
        {
            self.fixed.push(FixedPart::Builtin {
                component: component.name.clone(),
                builtin: name.clone(),
                change,
            });
        }
    }

    fn component(&mut self, before: (&Component, &Plan), after: (&Component, &Plan)) {
        let name = &before.0.name;
        let steady = (steady(before.0, after.0), steady(after.0, before.0));
        if steady.0 != steady.1 {
            self.fixed.push(FixedPart::Component {
                component: name.clone(),
                difference: component_difference::described(&steady.0, &steady.1),
                changeable: component_difference::changeable(after.0),
            });
            return;
        }
        self.replacement(before.0, after.0);
        self.topics(before.0, after.0);
        let values = self.values(name, &before.0.properties, &after.0.properties);
        if !values.is_empty() {
            let component = name.clone();
            self.begins.push(Change::Set { component, values });
        }
        let drive = |(it, plan)| start::activity(it, plan).drive;
        let own_pace = after.0.pace.master.is_none();
        if own_pace && drive(before) != drive(after) {
            self.begins.push(Change::SetPeriod {
                component: name.clone(),
                period: drive(after).period().unwrap_or_default(),
            });
        }
    }

    /// Replaces a coordinator whose specification, bindings, ports or watched properties differ.
    fn replacement(&mut self, before: &Component, after: &Component) {
        let Some(file) = specification(after) else {
            return;
        };
        let (running, wanted) = self.versions;
        let name = &after.name;
        let has_same_text = running.texts.get(name) == wanted.texts.get(name);
        let has_same_bindings = before.binding == after.binding;
        let has_same_bindings = has_same_bindings && has_same_ports(before, after);
        if has_same_text && has_same_bindings && before.special.watch == after.special.watch {
            return;
        }
        let (_, shown) = file.rsplit_once('/').unwrap_or(("", file));
        let description = match (has_same_text, has_same_bindings) {
            (false, _) => format!("another version of `{shown}`"),
            (true, false) => format!("`{shown}` with other bindings"),
            (true, true) => format!("`{shown}` with another `watch`"),
        };
        let construct = wanted.constructor(after);
        let mut interface = Interface::new();
        // one that cannot be created is refused by the run
        if construct(&mut interface).is_ok() {
            let declared = interface.declaration().clone();
            self.declared.insert(name.clone(), declared);
        }
        self.begins.push(Change::Replace {
            component: name.clone(),
            by: Replacement::new(description, construct),
        });
    }

    /// Returns the changed property values; properties no longer set return to their default.
    fn values(
        &self,
        component: &str,
        before: &PropertyValues,
        after: &PropertyValues,
    ) -> Vec<(String, Datum)> {
        let declared = self.run.declaration(component).unwrap_or_default();
        let set = after
            .0
            .iter()
            .filter(|(name, value)| before.get(name) != Some(value));
        let unset = before
            .0
            .iter()
            .filter(|(name, _)| after.get(name).is_none());
        let default = |(name, _): &(String, _)| {
            let default = declared.property(name)?.default.clone();
            Some((name.clone(), default))
        };
        set.map(|(name, value)| (name.clone(), value.datum()))
            .chain(unset.filter_map(default))
            .collect()
    }
}

/// Returns whether two versions of a component have the same ports, whatever their topics, and the same references.
fn has_same_ports(before: &Component, after: &Component) -> bool {
    let names =
        |ports: &[Port]| -> Vec<String> { ports.iter().map(|it| it.name.clone()).collect() };
    names(&before.inputs) == names(&after.inputs)
        && names(&before.outputs) == names(&after.outputs)
        && before.references == after.references
}

/// Returns a component without what can be changed at run time. A specification can have other ports and references in the other
/// version.
fn steady(component: &Component, other: &Component) -> Component {
    let mut component = component.clone();
    let is_specification = specification(&component).is_some();
    for (ports, others) in [
        (&mut component.inputs, &other.inputs),
        (&mut component.outputs, &other.outputs),
    ] {
        if is_specification {
            ports.retain(|port| others.iter().any(|other| other.name == port.name));
            ports.sort_by(|one, other| one.name.cmp(&other.name));
        }
        ports.iter_mut().for_each(|port| port.topic = None);
    }
    if is_specification {
        let others = &other.references;
        let references = &mut component.references;
        references.retain(|it| others.iter().any(|other| other.name == it.name));
        references.sort_by(|one, other| one.name.cmp(&other.name));
    }
    if let Implementation::Asm { file, main } = &mut component.implementation {
        file.clear();
        *main = None;
        component.binding = None;
        component.special.watch = None;
    }
    component.properties = PropertyValues::default();
    component.pace = Pace {
        period_ms: 0,
        ..component.pace
    };
    component
}
