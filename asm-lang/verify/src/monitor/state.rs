//! The state of monitors as plain data, and its transfer to the monitors of another version of a specification.

use super::{Monitors, PropertyWatch};
use asmotion_temporal::{MonitorState, ResponseState};
use serde::{Deserialize, Serialize};

/// State of all monitors in a run, as plain data.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct MonitorsState(Vec<PropertyWatchState>);

#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct PropertyWatchState {
    safety: Option<(Vec<Vec<u32>>, Vec<bool>)>,
    /// Times of open causes, memory, and whether the position is the first one.
    response: Option<(Vec<Option<i64>>, Vec<bool>, bool)>,
    was_violated: bool,
    is_found: bool,
    violated_steps: u64,
}

impl PropertyWatchState {
    fn of(watch: &PropertyWatch) -> Self {
        let response = watch.response.as_ref().map(|response| {
            let state = response.after_step.as_ref().unwrap_or(&response.state);
            (state.open.clone(), state.memory.clone(), state.is_first)
        });
        Self {
            safety: watch
                .safety
                .as_ref()
                .map(|(_, state)| (state.alternatives.clone(), state.memory.clone())),
            response,
            was_violated: watch.was_violated,
            is_found: watch.is_found,
            violated_steps: watch.violated_steps,
        }
    }

    /// Returns the watch in this state; `None` if it does not fit.
    fn restored(&self, watch: &PropertyWatch) -> Option<PropertyWatch> {
        let mut watch = watch.clone();
        match (&mut watch.safety, &self.safety) {
            (Some((monitor, state)), Some((alternatives, memory))) => {
                *state = MonitorState {
                    alternatives: alternatives.clone(),
                    memory: memory.clone(),
                };
                monitor.fits(state).then_some(())?;
            }
            (None, None) => {}
            (Some(_), None) | (None, Some(_)) => return None,
        }
        match (&mut watch.response, &self.response) {
            (Some(response), Some((open, memory, is_first))) => {
                response.after_step = None;
                response.state = ResponseState {
                    open: open.clone(),
                    memory: memory.clone(),
                    is_first: *is_first,
                };
                response.monitor.fits(&response.state).then_some(())?;
            }
            (None, None) => {}
            (Some(_), None) | (None, Some(_)) => return None,
        }
        (watch.is_stable, watch.is_violated) = (false, false);
        (watch.was_violated, watch.is_found) = (self.was_violated, self.is_found);
        watch.violated_steps = self.violated_steps;
        Some(watch)
    }
}

impl Monitors {
    /// Returns what they know about the run between two steps.
    pub fn state(&self) -> MonitorsState {
        MonitorsState(self.watches.iter().map(PropertyWatchState::of).collect())
    }

    /// Continues in a state. Returns `false` if it is not one of these monitors, which are then unchanged.
    pub fn restore(&mut self, state: &MonitorsState) -> bool {
        let watches = self.watches.iter().zip(&state.0);
        let restored: Option<Vec<PropertyWatch>> = watches
            .map(|(watch, state)| state.restored(watch))
            .collect();
        let Some(restored) = restored.filter(|it| it.len() == state.0.len()) else {
            return false;
        };
        if restored.len() != self.watches.len() {
            return false;
        }
        self.watches = restored;
        self.forget_values();
        true
    }

    /// Continues what monitors of another version of the specification know about properties that both have: with the same kind,
    /// text and time. Returns the texts of the properties that begin anew although a response was open, or that are not watched
    /// any more.
    pub fn continue_from(&mut self, before: &Self) -> Vec<String> {
        let mut lost = Vec::new();
        let known = before.watched.iter().zip(&before.watches);
        for (property, watch) in known {
            let same = self.watched.iter().position(|it| {
                (it.kind, &it.text, it.within_ns)
                    == (property.kind, &property.text, property.within_ns)
            });
            let own = same.and_then(|index| self.watches.get_mut(index));
            let state = PropertyWatchState::of(watch);
            match own {
                Some(own) => match state.restored(own) {
                    Some(restored) => *own = restored,
                    None => lost.push(property.text.clone()),
                },
                None => lost.push(property.text.clone()),
            }
        }
        self.forget_values();
        lost
    }
}
