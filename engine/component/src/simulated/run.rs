//! What can be done to a simulation while it runs.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use datum::{Datum, Sample};

use super::Simulation;
use crate::activity::Drive;
use crate::declaration::Declaration;
use crate::run::{Asked, Losses, Run, RunError};
use crate::unit::Unit;
use crate::{Event, Fault, LifeCycleError, State, Time, Transition};

impl Run for Simulation {
    fn now(&self) -> Time {
        self.world.now
    }

    fn run_until(&mut self, until: Time) {
        self.advance(until, None);
    }

    fn run_until_event(
        &mut self,
        limit: Time,
        wanted: &mut dyn FnMut(Time, &Event<'_>) -> bool,
    ) -> bool {
        self.advance(limit, Some(wanted))
    }

    fn inject_sample(
        &mut self,
        at: Time,
        port: &str,
        sample: Arc<dyn Sample>,
    ) -> Result<(), RunError> {
        let place = self.doors.port(port, &sample)?;
        self.enqueue(at, place, sample);
        Ok(())
    }

    fn publish_sample(
        &mut self,
        at: Time,
        topic: &str,
        sample: Arc<dyn Sample>,
    ) -> Result<(), RunError> {
        let place = self.doors.topic(topic, &sample)?;
        self.enqueue(at, place, sample);
        Ok(())
    }

    fn transition(
        &mut self,
        component: &str,
        transition: Transition,
    ) -> Result<(), LifeCycleError> {
        let index = self.find(component).map_err(|_| LifeCycleError::Unknown {
            component: component.to_owned(),
        })?;
        self.take_through(index, transition)
    }

    fn trigger(&mut self, component: &str) -> Result<(), RunError> {
        let component = self.find(component)?;
        let now = self.world.now;
        self.world.trigger(component, now);
        Ok(())
    }

    fn set_period(&mut self, component: &str, period: Duration) -> Result<(), RunError> {
        let index = self.find(component)?;
        self.units[index].activity.drive = Drive::of_period(period);
        self.world.follow(&self.units[index]);
        Ok(())
    }

    fn set_properties(
        &mut self,
        component: &str,
        values: &[(String, Datum)],
    ) -> Result<(), RunError> {
        let index = self.find(component)?;
        self.attend(index, |unit, now, outside| {
            unit.set_properties(values, now, outside)
        })?;
        Ok(())
    }

    fn begin_transition(
        &mut self,
        component: &str,
        transition: Transition,
    ) -> Result<Asked, RunError> {
        let done = self.transition(component, transition);
        Ok(Asked::done(component, done.map_err(RunError::from)))
    }

    fn begin_set_properties(
        &mut self,
        component: &str,
        values: &[(String, Datum)],
    ) -> Result<Asked, RunError> {
        let done = self.set_properties(component, values);
        Ok(Asked::done(component, done))
    }

    fn components(&self) -> Vec<String> {
        self.units
            .iter()
            .map(|unit| unit.name.to_string())
            .collect()
    }

    fn state(&self, component: &str) -> Option<State> {
        self.unit(component).map(Unit::state)
    }

    fn cycles(&self, component: &str) -> u64 {
        let unit = self.unit(component);
        unit.map_or(0, |unit| unit.status.cycles.load(Ordering::Relaxed))
    }

    fn overruns(&self, component: &str) -> u64 {
        let unit = self.unit(component);
        unit.map_or(0, |unit| unit.status.overruns.load(Ordering::Relaxed))
    }

    fn losses(&self, component: &str) -> Losses {
        let unit = self.unit(component);
        unit.map(|unit| unit.status.losses()).unwrap_or_default()
    }

    fn fault(&self, component: &str) -> Option<Fault> {
        self.unit(component).and_then(|unit| unit.fault.clone())
    }

    fn declaration(&self, component: &str) -> Option<Declaration> {
        let unit = self.unit(component);
        unit.map(|unit| unit.body.declaration.clone())
    }

    fn properties(&mut self, component: &str) -> Result<Vec<(String, Datum)>, RunError> {
        let index = self.find(component)?;
        Ok(self.units[index].body.values())
    }

    fn stop(&mut self) -> Vec<String> {
        for index in (0..self.units.len()).rev() {
            if self.units[index].state().is_running() {
                let _ = self.take_through(index, Transition::Stop);
            }
        }
        Vec::new()
    }
}
