//! The state of a coordinator as text, for observers.

use crate::control_locations::CONTROL_STATES;
use crate::coordinator::Coordinator;
use crate::inputs::{BoundInput, InputLocation};
use crate::last_write::LastUpdate;
use asmotion_datum::{Datum, DatumError};
use asmotion_lang::ir::{DomainElements, Function, FunctionId, FunctionKind, Program, ValueShape};
use asmotion_lang::simulate;
use asmotion_lang::value::Value;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// Number of locations of a function from which only their values are counted.
const MAX_LOCATIONS: usize = 16;

/// The state of a coordinator between two steps, as observers see it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct CoordinatorStatus {
    /// Number of the last step.
    pub step: u64,
    /// Locations that rules update and whose values are literals of an enumeration: the control states. A function with more than
    /// sixteen locations comes as one, with the number of locations for each value, as in `IDLE ×9998, RUN ×2`.
    pub state: BTreeMap<String, String>,
    /// The last step that wrote something; `None` before it.
    pub last_update: Option<LastUpdate>,
    /// The monitored locations that the last step read, with their values: the inputs it depends on.
    pub read: BTreeMap<String, String>,
    /// Operations whose calls have not ended, as `reference.operation`.
    pub calls: Vec<String>,
    /// Monitored locations bound to a port or a service for which no message has arrived.
    pub silent: BTreeSet<String>,
    /// Number of events waiting for a step, by location.
    pub waiting_events: BTreeMap<String, u64>,
    /// Properties that steps have violated, with the number of these steps.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub violated: BTreeMap<String, u64>,
    /// Properties that are not watched, with the reason.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub unwatched: BTreeMap<String, String>,
}

impl CoordinatorStatus {
    /// The status as entries for observers, in display order.
    ///
    /// # Errors
    /// None in practice: every part is representable.
    pub fn entries(&self) -> Result<Vec<(String, Datum)>, DatumError> {
        let Datum::Record(fields) = Datum::of(self)? else {
            return Ok(Vec::new());
        };
        let entries = fields.into_iter();
        Ok(entries
            .map(|(name, value)| (name.into_owned(), value))
            .collect())
    }

    /// The control state: the location with a usual name, or the only one, and its value.
    pub fn control_state(&self) -> Option<(&str, &str)> {
        let named = CONTROL_STATES
            .iter()
            .find_map(|name| self.state.get_key_value(*name));
        let only = || self.state.iter().next().filter(|_| self.state.len() == 1);
        let (location, value) = named.or_else(only)?;
        Some((location, value))
    }

    /// The control states in which a coordinator is: the values of the function with a usual name, or of the only function. Several
    /// locations with the same value have one control state, as in `ARRIVED`; others are counted, as in `IDLE ×2, RUN ×1`.
    pub fn control_states(&self) -> Option<String> {
        let names: BTreeSet<&str> = self.state.keys().map(|it| function_of(it)).collect();
        let usual = CONTROL_STATES.iter().find(|it| names.contains(**it));
        let name = match (usual, names.len()) {
            (Some(usual), _) => usual,
            (None, 1) => names.first()?,
            (None, _) => return None,
        };
        let locations = self.state.iter();
        let of_function = locations.filter(|(location, _)| function_of(location) == *name);
        Some(counted(of_function.map(|(_, value)| value.clone())))
    }

    /// Reads the entries of a component's description; `None` if the component is no coordinator.
    pub fn of(entries: &[(String, Datum)]) -> Option<Self> {
        let is_status = entries.iter().any(|(name, _)| name == "waiting_events");
        let record = Datum::record(entries.iter().cloned());
        record.to().ok().filter(|_| is_status)
    }
}

impl Coordinator {
    /// The state between two steps.
    pub(crate) fn status(&self) -> CoordinatorStatus {
        let calls = self.outbox.pending_calls().map(ToString::to_string);
        let calls = calls.chain(self.partners.pending_calls());
        CoordinatorStatus {
            step: self.machine.steps(),
            state: self.control_states(),
            last_update: self.last_write.text(&self.machine),
            read: self.last_inputs(),
            calls: calls.collect(),
            silent: self.silent_locations(),
            waiting_events: self.waiting_events(),
            violated: self.violated(),
            unwatched: self.unwatched(),
        }
    }

    fn violated(&self) -> BTreeMap<String, u64> {
        let monitors = &self.watcher.monitors;
        let watched = monitors.watched().iter().enumerate();
        let counted = watched
            .map(|(index, property)| (property.text.clone(), monitors.violated_steps(index)));
        counted.filter(|(_, steps)| *steps > 0).collect()
    }

    fn unwatched(&self) -> BTreeMap<String, String> {
        let unwatched = self.watcher.monitors.unwatched().iter();
        unwatched
            .map(|it| (it.text.clone(), it.reason.clone()))
            .collect()
    }

    fn control_states(&self) -> BTreeMap<String, String> {
        let (state, program) = (self.machine.state(), self.machine.program());
        let locations = state.locations(program).into_iter();
        let mut shown: BTreeMap<FunctionId, Vec<(String, String)>> = BTreeMap::new();
        for (function, arguments, slot) in locations {
            let declared = program.functions.get(function.0 as usize);
            if declared.is_some_and(|it| is_control(it, program)) {
                let location = simulate::applied(&self.machine, function, &arguments);
                let all = shown.entry(function).or_default();
                all.push((location, self.show(state.get(slot))));
            }
        }
        let limited = shown.into_values().flat_map(|all| {
            if all.len() <= MAX_LOCATIONS {
                return all;
            }
            let name = all
                .first()
                .map(|(location, _)| function_of(location).to_owned());
            let counts = counted(all.into_iter().map(|(_, value)| value));
            name.map(|name| (name, counts)).into_iter().collect()
        });
        limited.collect()
    }

    fn last_inputs(&self) -> BTreeMap<String, String> {
        let step = self.machine.last_step();
        let inputs = step.inputs().iter().map(|input| {
            let location = simulate::location(&self.machine, input.slot);
            (location, self.show(&input.value))
        });
        inputs.collect()
    }

    fn silent_locations(&self) -> BTreeSet<String> {
        let inputs = self.inbox.inputs.iter();
        let silent = inputs.flat_map(|input| input.silent().map(|it| self.location(input, it)));
        silent.collect()
    }

    fn waiting_events(&self) -> BTreeMap<String, u64> {
        let inputs = self.inbox.inputs.iter();
        let all = inputs.flat_map(|input| input.locations.iter().map(move |it| (input, it)));
        let waiting = all.filter(|(_, location)| !location.waiting.is_empty());
        let counted = waiting.map(|(input, location)| {
            let name = self.location(input, location);
            (name, location.waiting.len() as u64)
        });
        counted.collect()
    }

    fn location(&self, input: &BoundInput, location: &InputLocation) -> String {
        simulate::applied(&self.machine, input.located.function, &location.arguments)
    }

    fn show(&self, value: &Value) -> String {
        value.show(&self.machine.naming()).to_string()
    }
}

/// Returns whether rules update the function and its values are literals of an enumeration.
/// The function of a location: `mode` of `mode(r1)`.
pub fn function_of(location: &str) -> &str {
    location.split_once('(').map_or(location, |(name, _)| name)
}

/// The value that all locations have, or the number of locations for each value, the most frequent first.
fn counted(values: impl Iterator<Item = String>) -> String {
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for value in values {
        *counts.entry(value).or_default() += 1;
    }
    let mut counts: Vec<(String, usize)> = counts.into_iter().collect();
    if let [(only, _)] = counts.as_slice() {
        return only.clone();
    }
    counts.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    let counts = counts
        .iter()
        .map(|(value, count)| format!("{value} ×{count}"));
    counts.collect::<Vec<_>>().join(", ")
}

fn is_control(function: &Function, program: &Program) -> bool {
    let is_written = matches!(
        function.kind,
        FunctionKind::Controlled | FunctionKind::Out | FunctionKind::Shared
    );
    let ValueShape::Domain(domain) = &function.codomain else {
        return false;
    };
    let domain = program.domains.get(domain.0 as usize);
    is_written
        && domain.is_some_and(|domain| {
            matches!(domain.elements, DomainElements::Atoms { .. }) && !domain.grows
        })
}
