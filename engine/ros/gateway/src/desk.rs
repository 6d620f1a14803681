//! Components of the system as a bridge shows them to ROS: a copy of their properties and states, and orders to change these.
//!
//! A bridge is a component, and a component has no access to others. The program that runs the system keeps the copy and carries
//! out the orders: it owns the [`ComponentDesk`]; a bridge reads the copy through a [`ComponentWatch`].

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak, mpsc};

use asmotion_component::declaration::PropertyDeclaration;
use asmotion_component::{State, Transition};
use asmotion_datum::Datum;

use crate::wake::Wake;

/// Changes of state that wait for a bridge; then the oldest is dropped.
const WAITING: usize = 1024;

/// Components that bridges show, and orders of bridges. Shared between clones.
#[derive(Clone, Default)]
pub struct ComponentDesk(Arc<Mutex<DeskContent>>);

#[derive(Default)]
struct DeskContent {
    /// Components that a bridge watches.
    wanted: BTreeSet<String>,
    /// Those of them that do not run here.
    absent: BTreeSet<String>,
    known: BTreeMap<String, KnownComponent>,
    orders: VecDeque<DeskOrder>,
    watches: Vec<Weak<WatchQueue>>,
    /// Number of changes.
    revision: u64,
}

struct KnownComponent {
    component: DeskComponent,
    /// Values that the copy has already, and that the system still reports, by property.
    expected: BTreeMap<String, VecDeque<Datum>>,
}

/// A component as the desk knows it.
#[derive(Clone, Debug, PartialEq)]
pub struct DeskComponent {
    /// State of its life cycle.
    pub state: State,
    /// Properties with their values, in the order of their declaration.
    pub properties: Vec<(PropertyDeclaration, Datum)>,
}

impl DeskComponent {
    /// A property and its value.
    pub fn property(&self, name: &str) -> Option<&(PropertyDeclaration, Datum)> {
        self.properties.iter().find(|(of, _)| of.name == name)
    }
}

/// A change that a bridge orders.
#[derive(Clone, Debug, PartialEq)]
pub enum DeskChange {
    /// Sets properties, all or none.
    Set(Vec<(String, Datum)>),
    /// Makes transitions of the life cycle, one after the other.
    Transitions(Vec<Transition>),
}

/// An order of a bridge.
pub struct DeskOrder {
    /// Name of the component to change.
    pub component: String,
    /// The change to make.
    pub change: DeskChange,
    reply: mpsc::Sender<Result<(), String>>,
    wake: Wake,
}

impl DeskOrder {
    /// Ends the order with its result: the reason if it was refused.
    pub fn end(self, result: Result<(), String>) {
        // a bridge that has ended does not wait
        let _ = self.reply.send(result);
        (self.wake)();
    }
}

/// A component changed its state.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StateChange {
    /// Name of the component.
    pub component: String,
    /// State before.
    pub from: State,
    /// State after.
    pub to: State,
}

struct WatchQueue {
    changes: Mutex<VecDeque<StateChange>>,
    wake: Wake,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl ComponentDesk {
    fn lock(&self) -> MutexGuard<'_, DeskContent> {
        lock(&self.0)
    }

    /// Watches components. `wake` is called after every change of any of them, from any thread.
    pub fn watch(
        &self,
        components: impl IntoIterator<Item = String>,
        wake: Wake,
    ) -> ComponentWatch {
        let queue = Arc::new(WatchQueue {
            changes: Mutex::default(),
            wake,
        });
        let mut content = self.lock();
        content.wanted.extend(components);
        content.watches.retain(|it| it.strong_count() > 0);
        content.watches.push(Arc::downgrade(&queue));
        drop(content);
        ComponentWatch {
            desk: self.clone(),
            queue,
        }
    }

    /// The components that are watched and not known.
    pub fn unknown(&self) -> Vec<String> {
        let content = self.lock();
        let wanted = content.wanted.difference(&content.absent);
        let unknown = wanted.filter(|it| !content.known.contains_key(*it));
        unknown.cloned().collect()
    }

    /// Notes that a component does not run in this process.
    pub fn miss(&self, name: &str) {
        self.lock().absent.insert(name.to_owned());
        self.changed();
    }

    /// Notes a component.
    pub fn know(&self, name: &str, component: DeskComponent) {
        let expected = BTreeMap::new();
        let known = KnownComponent {
            component,
            expected,
        };
        self.lock().known.insert(name.to_owned(), known);
        self.changed();
    }

    /// Forgets all components: another version of the system runs, or changes were not observed. They are unknown then.
    pub fn forget(&self) {
        let mut content = self.lock();
        content.known.clear();
        content.absent.clear();
    }

    /// Notes that a component reports a property.
    pub fn property_changed(&self, component: &str, property: &str, value: &Datum) {
        let mut content = self.lock();
        let Some(known) = content.known.get_mut(component) else {
            return;
        };
        let is_last = match known.expected.get_mut(property) {
            None => true,
            Some(expected) => {
                let at = expected.iter().position(|it| it == value);
                if let Some(at) = at {
                    expected.drain(..=at);
                }
                at.is_none() || expected.is_empty()
            }
        };
        // an earlier one of several values that were set here: the copy has the last
        if is_last && known.set(property, value) {
            drop(content);
            self.changed();
        }
    }

    /// Notes that a component has accepted values, which it reports when they take effect.
    pub fn properties_set(&self, component: &str, values: &[(String, Datum)]) {
        let mut content = self.lock();
        let Some(known) = content.known.get_mut(component) else {
            return;
        };
        let mut has_changed = false;
        for (property, value) in values {
            let Some((of, _)) = known.component.property(property) else {
                continue;
            };
            // a type of its own may accept more than its schema: the component reports the value
            let Ok(value) = of.schema.complete(value.clone()) else {
                continue;
            };
            if known.set(property, &value) {
                has_changed = true;
                let expected = known.expected.entry(property.clone()).or_default();
                expected.push_back(value);
            }
        }
        drop(content);
        if has_changed {
            self.changed();
        }
    }

    /// Notes that a component has changed its state.
    pub fn state_changed(&self, component: &str, from: State, to: State) {
        let mut content = self.lock();
        let Some(known) = content.known.get_mut(component) else {
            return;
        };
        known.component.state = to;
        let watches: Vec<_> = content.watches.iter().filter_map(Weak::upgrade).collect();
        drop(content);
        for watch in watches {
            let mut changes = lock(&watch.changes);
            if changes.len() == WAITING {
                changes.pop_front();
            }
            let component = component.to_owned();
            changes.push_back(StateChange {
                component,
                from,
                to,
            });
        }
        self.changed();
    }

    /// The state of a component that is known.
    pub fn state(&self, component: &str) -> Option<State> {
        let content = self.lock();
        let known = content.known.get(component);
        known.map(|it| it.component.state)
    }

    /// Takes the oldest order.
    pub fn take_order(&self) -> Option<DeskOrder> {
        self.lock().orders.pop_front()
    }

    fn changed(&self) {
        let mut content = self.lock();
        content.revision += 1;
        let watches: Vec<_> = content.watches.iter().filter_map(Weak::upgrade).collect();
        drop(content);
        for watch in watches {
            (watch.wake)();
        }
    }
}

impl KnownComponent {
    /// Sets a value of the copy. Returns whether it is another.
    fn set(&mut self, property: &str, value: &Datum) -> bool {
        let mut properties = self.component.properties.iter_mut();
        let found = properties.find(|(of, _)| of.name == property);
        match found {
            Some((_, before)) if *before != *value => {
                *before = value.clone();
                true
            }
            Some(_) | None => false,
        }
    }
}

/// A bridge's view of the components that it shows.
pub struct ComponentWatch {
    desk: ComponentDesk,
    queue: Arc<WatchQueue>,
}

impl ComponentWatch {
    /// Number of changes of all components so far.
    pub fn revision(&self) -> u64 {
        self.desk.lock().revision
    }

    /// A component, if it is known.
    pub fn component(&self, name: &str) -> Option<DeskComponent> {
        let content = self.desk.lock();
        content.known.get(name).map(|it| it.component.clone())
    }

    /// The watched components that do not run in this process.
    pub fn absent(&self) -> Vec<String> {
        self.desk.lock().absent.iter().cloned().collect()
    }

    /// Takes the changes of state since the last time, the oldest first.
    pub fn take_state_changes(&self) -> Vec<StateChange> {
        lock(&self.queue.changes).drain(..).collect()
    }

    /// Gives an order.
    pub fn order(&self, component: &str, change: DeskChange) -> PendingOrder {
        let (reply, result) = mpsc::channel();
        self.desk.lock().orders.push_back(DeskOrder {
            component: component.to_owned(),
            change,
            reply,
            wake: Arc::clone(&self.queue.wake),
        });
        PendingOrder(result)
    }
}

/// An order under way.
#[derive(Debug)]
pub struct PendingOrder(mpsc::Receiver<Result<(), String>>);

impl PendingOrder {
    /// The result, once the order has been carried out: the reason if it was refused.
    pub fn try_take(&self) -> Option<Result<(), String>> {
        match self.0.try_recv() {
            Ok(result) => Some(result),
            Err(mpsc::TryRecvError::Empty) => None,
            Err(mpsc::TryRecvError::Disconnected) => Some(Err("the system ends".to_owned())),
        }
    }
}

#[cfg(test)]
mod tests {
    use asmotion_datum::{Schema, Shape};

    use super::*;

    fn desk() -> (ComponentDesk, ComponentWatch) {
        let desk = ComponentDesk::default();
        let watch = desk.watch(["Arm".to_owned()], Arc::new(|| {}));
        assert_eq!(desk.unknown(), ["Arm"]);
        let declaration = PropertyDeclaration {
            name: "speed".to_owned(),
            doc: String::new(),
            schema: Schema::plain(Shape::F64),
            unit: String::new(),
            default: Datum::Float(0.0),
            range: None,
            choices: Vec::new(),
            conversion: Default::default(),
        };
        let component = DeskComponent {
            state: State::Stopped,
            properties: vec![(declaration, Datum::Float(0.0))],
        };
        desk.know("Arm", component);
        (desk, watch)
    }

    fn speed(watch: &ComponentWatch) -> Datum {
        watch.component("Arm").unwrap().properties[0].1.clone()
    }

    fn set(desk: &ComponentDesk, value: i64) {
        desk.properties_set("Arm", &[("speed".to_owned(), Datum::Int(value))]);
    }

    #[test]
    fn values_that_were_set_here_do_not_come_back() {
        let (desk, watch) = desk();
        set(&desk, 1);
        set(&desk, 2);
        assert_eq!(speed(&watch), Datum::Float(2.0));
        let revision = watch.revision();
        for value in [1.0, 2.0] {
            desk.property_changed("Arm", "speed", &Datum::Float(value));
            assert_eq!(speed(&watch), Datum::Float(2.0));
        }
        assert_eq!(watch.revision(), revision);
        // of another: the same value is news again
        desk.property_changed("Arm", "speed", &Datum::Float(1.0));
        assert_eq!(speed(&watch), Datum::Float(1.0));
    }

    #[test]
    fn the_last_value_that_the_system_reports_counts() {
        let (desk, watch) = desk();
        set(&desk, 3);
        for value in [5.0, 3.0] {
            desk.property_changed("Arm", "speed", &Datum::Float(value));
            assert_eq!(speed(&watch), Datum::Float(value));
        }
    }

    #[test]
    fn changes_of_state_wait_and_orders_end() {
        let (desk, watch) = desk();
        desk.state_changed("Arm", State::Stopped, State::Running);
        assert_eq!(watch.component("Arm").unwrap().state, State::Running);
        let changes = watch.take_state_changes();
        assert_eq!(changes.len(), 1);
        let pending = watch.order("Arm", DeskChange::Transitions(vec![Transition::Stop]));
        assert!(pending.try_take().is_none());
        let order = desk.take_order().unwrap();
        order.end(Err("no".to_owned()));
        assert_eq!(pending.try_take(), Some(Err("no".to_owned())));
        let pending = watch.order("Arm", DeskChange::Set(Vec::new()));
        drop(desk.take_order());
        assert!(pending.try_take().unwrap().is_err());
    }
}
