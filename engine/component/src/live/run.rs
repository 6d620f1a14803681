//! What can be done to a live system while it runs.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use datum::{Datum, Sample};

use super::worker::Command;
use super::{Live, NAP};
use crate::declaration::Declaration;
use crate::run::{Asked, Losses, Run, RunError};
use crate::{Event, Fault, LifeCycleError, State, Time, Transition};

impl Run for Live {
    fn now(&self) -> Time {
        self.world.now()
    }

    fn run_until(&mut self, until: Time) {
        self.advance(until, None);
    }

    fn run_until_event(
        &mut self,
        limit: Time,
        wanted: &mut dyn FnMut(Time, &Event<'_>) -> bool,
    ) -> bool {
        self.events.observe();
        self.advance(limit, Some(wanted))
    }

    fn inject_sample(
        &mut self,
        at: Time,
        port: &str,
        sample: Arc<dyn Sample>,
    ) -> Result<(), RunError> {
        let place = self.doors.port(port, &sample)?;
        self.plan(at, place, sample);
        Ok(())
    }

    fn publish_sample(
        &mut self,
        at: Time,
        topic: &str,
        sample: Arc<dyn Sample>,
    ) -> Result<(), RunError> {
        let place = self.doors.topic(topic, &sample)?;
        self.plan(at, place, sample);
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
        self.take_through(index, transition, self.grace)
    }

    fn trigger(&mut self, component: &str) -> Result<(), RunError> {
        let index = self.find(component)?;
        self.hosts[index].wake.call();
        Ok(())
    }

    fn set_period(&mut self, component: &str, period: Duration) -> Result<(), RunError> {
        let host = &self.hosts[self.find(component)?];
        let busy = || RunError::Busy {
            component: component.to_owned(),
        };
        host.ask(self.grace, |answer| Command::SetPeriod(period, answer))
            .ok_or_else(busy)
    }

    fn set_properties(
        &mut self,
        component: &str,
        values: &[(String, Datum)],
    ) -> Result<(), RunError> {
        let host = &self.hosts[self.find(component)?];
        let values = values.to_vec();
        let answer = host.ask(self.grace, |answer| Command::SetProperties(values, answer));
        answer.unwrap_or_else(|| {
            Err(RunError::Busy {
                component: component.to_owned(),
            })
        })
    }

    fn begin_transition(
        &mut self,
        component: &str,
        transition: Transition,
    ) -> Result<Asked, RunError> {
        let host = &self.hosts[self.find(component)?];
        host.allow_interrupt(transition);
        Ok(host.begin(|answer| Command::Transition(transition, answer)))
    }

    fn begin_set_properties(
        &mut self,
        component: &str,
        values: &[(String, Datum)],
    ) -> Result<Asked, RunError> {
        let host = &self.hosts[self.find(component)?];
        let values = values.to_vec();
        Ok(host.begin(|answer| Command::SetProperties(values, answer)))
    }

    fn components(&self) -> Vec<String> {
        self.hosts
            .iter()
            .map(|host| host.name.to_string())
            .collect()
    }

    fn state(&self, component: &str) -> Option<State> {
        self.host(component).map(|host| host.status.state())
    }

    fn cycles(&self, component: &str) -> u64 {
        let host = self.host(component);
        host.map_or(0, |host| host.status.cycles.load(Ordering::Relaxed))
    }

    fn overruns(&self, component: &str) -> u64 {
        let host = self.host(component);
        host.map_or(0, |host| host.status.overruns.load(Ordering::Relaxed))
    }

    fn losses(&self, component: &str) -> Losses {
        let host = self.host(component);
        host.map(|host| host.status.losses()).unwrap_or_default()
    }

    fn fault(&self, component: &str) -> Option<Fault> {
        let host = self.host(component)?;
        host.ask(self.grace, Command::Fault)?
    }

    fn declaration(&self, component: &str) -> Option<Declaration> {
        self.host(component).map(|host| host.declaration.clone())
    }

    fn properties(&mut self, component: &str) -> Result<Vec<(String, Datum)>, RunError> {
        let host = &self.hosts[self.find(component)?];
        // whoever looks on does not wait for a long cycle
        let answer = host.ask(NAP, Command::Properties);
        answer.ok_or_else(|| RunError::Busy {
            component: component.to_owned(),
        })
    }

    fn stop(&mut self) -> Vec<String> {
        let mut late = Vec::new();
        for index in (0..self.hosts.len()).rev() {
            if !self.hosts[index].status.state().is_running() {
                continue;
            }
            let stopped = self.take_through(index, Transition::Stop, self.grace);
            if matches!(stopped, Err(LifeCycleError::Busy { .. })) {
                late.push(self.hosts[index].name.to_string());
            }
        }
        let now = self.world.now();
        self.advance(now, None);
        late
    }
}
