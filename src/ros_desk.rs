//! Serves the components that ros-bridges show to ROS: keeps their copy, and carries out the orders of clients in ROS.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use asmotion_component::{State, Time, Transition};
use asmotion_plan::Plan;
use asmotion_ros_gateway::{ComponentDesk, DeskChange, DeskComponent, DeskOrder};
use asmotion_runtime::{Asked, Event, Observer, ReportInterest, Run, RunError, System};

/// Longest time until the observers of a run hear of a state that it has.
const UNTIL_OBSERVED: Duration = Duration::from_secs(1);

/// Serves the components that ros-bridges show.
#[derive(Default)]
pub(crate) struct RosDesk {
    desk: ComponentDesk,
    pending: Vec<PendingOrder>,
}

/// An order that the component has not carried out.
struct PendingOrder {
    order: DeskOrder,
    asked: Option<Asked>,
    /// Transitions after the one under way.
    next: VecDeque<Transition>,
    /// When the component had carried it out.
    done: Option<Instant>,
}

impl RosDesk {
    /// The components, for a bridge.
    pub(crate) fn components(&self) -> ComponentDesk {
        self.desk.clone()
    }

    /// Observes the components, if a bridge shows any.
    pub(crate) fn observe(&self, system: &mut System, plan: &Plan) {
        let mut special = plan.components.iter().map(|it| &it.special);
        if !special.any(|it| !it.parameters.is_empty() || !it.managed.is_empty()) {
            return;
        }
        let desk = self.desk.clone();
        let observer = move |_: Time, event: &Event<'_>| {
            if let Event::Property {
                component,
                property,
                value,
            } = event
            {
                desk.property_changed(component, property, value);
            } else if let Event::LifeCycle {
                component,
                from,
                to,
            } = event
            {
                desk.state_changed(component, *from, *to);
            } else if let Event::Lost { .. } = event {
                desk.forget();
            }
        };
        system.observe(observer.using(ReportInterest::NONE));
    }

    /// Reads all components again, because another version of the system runs.
    pub(crate) fn follow(&self) {
        self.desk.forget();
    }

    /// Reads components that are not known yet, and carries out orders.
    pub(crate) fn process(&mut self, run: &mut dyn Run) {
        for name in self.desk.unknown() {
            self.learn(&name, run);
        }
        while let Some(order) = self.desk.take_order() {
            let mut pending = PendingOrder {
                order,
                asked: None,
                next: VecDeque::new(),
                done: None,
            };
            match pending.begin(run) {
                Ok(()) => self.pending.push(pending),
                Err(error) => pending.order.end(Err(error.to_string())),
            }
        }
        for pending in std::mem::take(&mut self.pending) {
            self.pending.extend(pending.go_on(run, &self.desk));
        }
    }

    fn learn(&self, name: &str, run: &mut dyn Run) {
        let Some(declaration) = run.declaration(name) else {
            return self.desk.miss(name);
        };
        // busy: in the next round
        let (Ok(values), Some(state)) = (run.properties(name), run.state(name)) else {
            return;
        };
        let properties = declaration.properties.into_iter().filter_map(|of| {
            let value = values.iter().find(|(name, _)| *name == of.name);
            value.map(|(_, value)| (of, value.clone()))
        });
        let properties = properties.collect();
        self.desk.know(name, DeskComponent { state, properties });
    }
}

impl PendingOrder {
    fn begin(&mut self, run: &mut dyn Run) -> Result<(), RunError> {
        match &self.order.change {
            DeskChange::Set(values) => {
                let asked = run.begin_set_properties(&self.order.component, values)?;
                self.asked = Some(asked);
            }
            DeskChange::Transitions(transitions) => {
                self.next = transitions.iter().copied().collect();
                self.begin_next(run)?;
            }
        }
        Ok(())
    }

    fn begin_next(&mut self, run: &mut dyn Run) -> Result<(), RunError> {
        if let Some(transition) = self.next.pop_front() {
            let asked = run.begin_transition(&self.order.component, transition)?;
            self.asked = Some(asked);
        }
        Ok(())
    }

    /// Ends the order if it has been carried out; returns it otherwise.
    fn go_on(mut self, run: &mut dyn Run, desk: &ComponentDesk) -> Option<Self> {
        if let Some(result) = self.asked.as_ref().map(Asked::try_take) {
            let result = match result {
                None => return Some(self),
                Some(result) => result.and_then(|()| {
                    self.asked = None;
                    self.begin_next(run)
                }),
            };
            if let Err(error) = result {
                self.order.end(Err(error.to_string()));
                return None;
            }
            if self.asked.is_some() {
                return Some(self);
            }
        }
        let component = &self.order.component;
        if let DeskChange::Set(values) = &self.order.change {
            desk.properties_set(component, values);
        } else {
            // its caller reads the state that it has brought about
            let state: Option<State> = run.state(component);
            let since = *self.done.get_or_insert_with(Instant::now);
            if desk.state(component) != state && since.elapsed() < UNTIL_OBSERVED {
                return Some(self);
            }
        }
        self.order.end(Ok(()));
        None
    }
}
