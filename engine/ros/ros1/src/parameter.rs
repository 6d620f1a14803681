//! Parameters that the node follows: a copy of each, which the master updates.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use asmotion_bus::{Envelope, Payload, SubscriptionSender};

use crate::context::lock;
use crate::names::RosName;
use crate::subscription::now;
use crate::xmlrpc::XmlRpcValue;

/// Depth of parameters in a parameter.
const MAX_DEPTH: usize = 32;

/// A parameter that the node follows, with the parameters in it.
pub(crate) struct FollowedParameter {
    pub(crate) name: RosName,
    state: Mutex<ParameterState>,
}

struct ParameterState {
    value: XmlRpcValue,
    updates: u64,
    observers: Vec<SubscriptionSender>,
}

impl FollowedParameter {
    pub(crate) fn new(name: RosName) -> Self {
        Self {
            name,
            state: Mutex::new(ParameterState {
                value: unset(),
                updates: 0,
                observers: Vec::new(),
            }),
        }
    }

    /// Adds an observer, which receives the value at once if there is one.
    pub(crate) fn add(&self, observer: SubscriptionSender) {
        let mut state = lock(&self.state);
        if state.updates > 0 {
            observer.push(self.envelope(&state));
        }
        state.observers.push(observer);
    }

    /// Removes an observer, and returns whether it was the last.
    pub(crate) fn remove(&self, observer: &SubscriptionSender) -> bool {
        let observers = &mut lock(&self.state).observers;
        observers.retain(|it| !it.is_same(observer));
        observers.is_empty()
    }

    /// Changes the value of the parameter, or of one in it. Returns whether the key is this parameter or in it.
    pub(crate) fn update(&self, key: &str, value: XmlRpcValue) -> bool {
        let key = key.trim_end_matches('/');
        let Some(path) = key.strip_prefix(self.name.as_str()) else {
            return false;
        };
        if !path.is_empty() && !path.starts_with('/') {
            return false;
        }
        let words: Vec<&str> = path.split('/').filter(|it| !it.is_empty()).collect();
        if words.len() > MAX_DEPTH {
            return false;
        }
        let mut state = lock(&self.state);
        set(&mut state.value, &words, value);
        state.updates += 1;
        let envelope = self.envelope(&state);
        for observer in &state.observers {
            observer.push(envelope.clone());
        }
        true
    }

    /// Notes a value that this node has set, of which the master does not tell it. Observers know it from who has set it.
    pub(crate) fn note(&self, value: XmlRpcValue) {
        lock(&self.state).value = value;
    }

    /// The value; an absent one if the parameter is not set.
    fn envelope(&self, state: &ParameterState) -> Envelope {
        let datum = if state.value == unset() {
            asmotion_datum::Datum::Null
        } else {
            state.value.to_datum()
        };
        Envelope {
            topic: self.name.shared(),
            source: "master".into(),
            incarnation: 1,
            sequence: state.updates,
            stamp: now(),
            clock: "".into(),
            age: Duration::ZERO,
            trace: None,
            type_name: "".into(),
            payload: Payload::Sample(Arc::new(datum)),
        }
    }
}

/// What the master says of a parameter that is not set.
fn unset() -> XmlRpcValue {
    XmlRpcValue::Struct(Vec::new())
}

/// Sets a value at a path; with an empty struct, the master says that there is none any more.
fn set(tree: &mut XmlRpcValue, path: &[&str], value: XmlRpcValue) {
    let Some((first, rest)) = path.split_first() else {
        *tree = value;
        return;
    };
    if !matches!(tree, XmlRpcValue::Struct(_)) {
        *tree = unset();
    }
    if let XmlRpcValue::Struct(members) = tree {
        let at = members.iter().position(|(name, _)| name == first);
        if rest.is_empty() && value == unset() {
            if let Some(at) = at {
                members.remove(at);
            }
            return;
        }
        let at = at.unwrap_or_else(|| {
            members.push(((*first).to_owned(), unset()));
            members.len() - 1
        });
        if let Some((_, member)) = members.get_mut(at) {
            set(member, rest, value);
        }
    }
}
