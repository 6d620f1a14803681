//! Properties of components as parameters of ROS 1.
//!
//! The master keeps the parameters and checks nothing, so both sides follow each other: a value that the component refuses is set
//! back. A parameter that is set when the bridge starts, for example by a launch file, goes to the component.

use std::sync::Arc;
use std::time::{Duration, Instant};

use asmotion_bus::{CallFailure, Notifier, Overflow, PendingCall, QueuePolicy, Subscription};
use asmotion_component::declaration::PropertyDeclaration;
use asmotion_datum::Datum;
use asmotion_ros1::RosNode;

use crate::desk::{ComponentWatch, DeskChange, PendingOrder};
use crate::shown::{Absences, ComponentDisplay, ShownComponent};

/// Time for the master to set a parameter.
const PATIENCE: Duration = Duration::from_secs(2);
/// Time until a parameter is set again that the master did not take.
const AGAIN: Duration = Duration::from_secs(1);

/// Properties of components as parameters.
pub(crate) struct Ros1Parameters {
    node: Arc<RosNode>,
    notifier: Arc<Notifier>,
    watch: ComponentWatch,
    absences: Absences,
    shown: Vec<ShownComponent>,
    parameters: Vec<Ros1Parameter>,
}

/// A property as a parameter.
struct Ros1Parameter {
    component: String,
    property: String,
    /// Name of the parameter.
    name: String,
    /// What the master says.
    followed: Subscription,
    /// The value in the master, as far as it is known: `None` before the master has answered.
    there: Option<Datum>,
    /// A value of ROS that the component has not accepted or refused yet.
    ordered: Option<PendingOrder>,
    /// A value on its way to the master.
    sent: Option<PendingCall>,
    /// When to send the value again.
    again: Option<Instant>,
}

impl Ros1Parameters {
    pub(crate) fn new(
        node: &Arc<RosNode>,
        notifier: Arc<Notifier>,
        watch: ComponentWatch,
        shown: &[ShownComponent],
    ) -> Self {
        let shown = shown.iter().filter(|it| it.has_parameters);
        Self {
            node: Arc::clone(node),
            notifier,
            watch,
            absences: Absences::default(),
            shown: shown.cloned().collect(),
            parameters: Vec::new(),
        }
    }

    /// Follows the parameter of a property. The notice of a name that is none comes once, because the property counts as shown.
    fn follow(&self, shown: &ShownComponent, property: &str) -> Result<Ros1Parameter, String> {
        let name = match shown.property {
            Some(_) => shown.ros.clone(),
            None => format!("{}/{property}", shown.ros.trim_end_matches('/')),
        };
        let newest = QueuePolicy::All {
            size: 64,
            overflow: Overflow::DropOldest,
        };
        let notifier = Arc::clone(&self.notifier);
        let followed = self.node.follow_parameter(&name, newest, notifier);
        Ok(Ros1Parameter {
            component: shown.component.clone(),
            property: property.to_owned(),
            name,
            followed: followed.map_err(|error| error.to_string())?,
            there: None,
            ordered: None,
            sent: None,
            again: None,
        })
    }

    /// Follows the parameters of properties that were not known before, and leaves those that the components no longer have.
    fn follow_new(&mut self, notices: &mut Vec<String>) {
        let mut kept = Vec::new();
        for shown in std::mem::take(&mut self.shown) {
            if let Some(component) = self.watch.component(&shown.component) {
                let properties = component.properties.iter().map(|(of, _)| of.name.clone());
                let is_shown = |name: &String| shown.property.as_ref().is_none_or(|it| it == name);
                for property in properties.filter(is_shown) {
                    let of_this = |it: &Ros1Parameter| {
                        it.component == shown.component && it.property == property
                    };
                    if let Some(at) = self.parameters.iter().position(of_this) {
                        kept.push(self.parameters.swap_remove(at));
                        continue;
                    }
                    match self.follow(&shown, &property) {
                        Ok(parameter) => kept.push(parameter),
                        Err(reason) => notices.push(reason),
                    }
                }
            }
            self.shown.push(shown);
        }
        self.parameters = kept;
    }
}

impl ComponentDisplay for Ros1Parameters {
    fn update(&mut self) -> Vec<String> {
        let mut notices = self.absences.notices(&self.watch);
        self.follow_new(&mut notices);
        for parameter in &mut self.parameters {
            let component = self.watch.component(&parameter.component);
            let property = component.as_ref();
            let property = property.and_then(|it| it.property(&parameter.property));
            if let Some((of, value)) = property {
                parameter.take_from_master((of, value), &self.watch);
                notices.extend(parameter.take_answers(value));
                parameter.send((of, value), (&self.node, &self.notifier));
            }
        }
        notices
    }

    fn patience(&self) -> Option<Duration> {
        let mut parameters = self.parameters.iter();
        let is_waiting = parameters.any(|it| it.again.is_some() || it.sent.is_some());
        is_waiting.then_some(AGAIN)
    }
}

/// Returns whether a value of ROS is that of a property. Numbers are compared as the property has them.
fn is_same(of: &PropertyDeclaration, there: &Datum, here: &Datum) -> bool {
    let as_here = of.schema.complete(there.clone());
    // also for floats that are no numbers
    as_here.is_ok_and(|it| it == *here || format!("{it:?}") == format!("{here:?}"))
}

impl Ros1Parameter {
    /// Gives the newest value of ROS to the component.
    fn take_from_master(
        &mut self,
        (of, value): (&PropertyDeclaration, &Datum),
        watch: &ComponentWatch,
    ) {
        let arrived = std::iter::from_fn(|| self.followed.try_next());
        let Some(newest) = arrived.last().and_then(|it| it.payload.to_datum().ok()) else {
            return;
        };
        let is_news = !newest.is_null() && !is_same(of, &newest, value);
        if is_news {
            let set = vec![(self.property.clone(), newest.clone())];
            // an earlier one has been replaced: its answer is of no interest
            self.ordered = Some(watch.order(&self.component, DeskChange::Set(set)));
        }
        if self.sent.is_some() {
            // the master may have taken this value before the one on its way
            self.again = Some(Instant::now());
        }
        self.there = Some(newest);
    }

    /// Takes what has become of values on their way. Returns a notice of one that was refused.
    fn take_answers(&mut self, value: &Datum) -> Option<String> {
        let name = &self.name;
        if let Some(result) = self.sent.as_ref().and_then(PendingCall::try_take) {
            self.sent = None;
            match result {
                Ok(_) => {}
                Err(CallFailure::Refused(refusal)) => {
                    return Some(format!("the parameter `{name}` is not set: {refusal}"));
                }
                // the node reports that the master is down
                Err(_) => self.again = Some(Instant::now() + AGAIN),
            }
        }
        let result = self.ordered.as_ref().and_then(PendingOrder::try_take)?;
        self.ordered = None;
        let reason = result.err()?;
        Some(format!(
            "the parameter `{name}` is set back to {value}: {reason}"
        ))
    }

    /// Sends the value of the component, if the master has another.
    fn send(
        &mut self,
        (of, value): (&PropertyDeclaration, &Datum),
        (node, notifier): (&RosNode, &Arc<Notifier>),
    ) {
        let is_due = self.again.is_none_or(|it| Instant::now() >= it);
        let (Some(there), None, None, true) = (&self.there, &self.ordered, &self.sent, is_due)
        else {
            return;
        };
        if self.again.is_none() && is_same(of, there, value) {
            return;
        }
        if there.is_null() {
            // cannot fail: the name is that of a parameter that is followed
            let _ = node.delete_parameter_at_end(&self.name);
        }
        self.again = None;
        self.there = Some(value.clone());
        let sent = node.set_parameter(&self.name, value, PATIENCE, Arc::clone(notifier));
        self.sent = sent.ok();
    }
}
