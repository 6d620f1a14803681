//! Lists the components of the process, from the descriptions that it publishes.

use std::sync::{Arc, Mutex, PoisonError};

use asmotion_bus::{Bus, BusError, Notifier, Pattern, QueuePolicy, Subscription};
use asmotion_datum::{Datum, json as written};
use hyper::StatusCode;

use crate::problem::Problem;
use asmotion_http::HttpResponse;

use crate::response;

/// Topics of the descriptions.
const PRESENCE: &str = "presence.*";

/// The parts of a component's description that clients get. Properties are left out, because they can be confidential.
const LISTED: &[&str] = &[
    "name",
    "id",
    "state",
    "period_ms",
    "cycles",
    "rate_hz",
    "overruns",
    "late",
    "dropped",
    "misfits",
];

/// The components as last described; the description is at most a second old.
pub(crate) struct ComponentListing(Mutex<LastPresence>);

struct LastPresence {
    subscription: Subscription,
    components: Vec<Datum>,
}

impl ComponentListing {
    /// Subscribes to the descriptions on a bus.
    ///
    /// # Errors
    /// An error of the bus.
    pub(crate) fn new(bus: &dyn Bus) -> Result<Self, BusError> {
        let notifier = Arc::new(Notifier::new());
        let topics = Pattern::new(PRESENCE);
        let subscription = bus.subscribe("http", &topics, QueuePolicy::Latest, notifier)?;
        Ok(Self(Mutex::new(LastPresence {
            subscription,
            components: Vec::new(),
        })))
    }

    /// The listing of all components.
    pub(crate) fn all(&self) -> Result<HttpResponse, Problem> {
        let components = Datum::List(self.last());
        response_of(&Datum::record([("components", components)]))
    }

    /// The description of one component, by its name or by the identifier of its task.
    pub(crate) fn one(&self, name: &str) -> Result<HttpResponse, Problem> {
        let components = self.last();
        let called = |field: &str| components.iter().find(|it| text_of(it, field) == name);
        match called("name").or_else(|| called("id")) {
            Some(component) => response_of(component),
            None => {
                let names = components.iter().map(|it| text_of(it, "name"));
                let ids = components.iter().map(|it| text_of(it, "id"));
                let available = names.chain(ids.filter(|id| !id.is_empty())).collect();
                Err(Problem::UnknownComponent {
                    name: name.to_owned(),
                    available,
                })
            }
        }
    }

    fn last(&self) -> Vec<Datum> {
        let mut last = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        while let Some(envelope) = last.subscription.try_next() {
            // other programs cannot publish on this bus
            if let Ok(presence) = envelope.payload.to_datum()
                && let Some(Datum::List(components)) = presence.get("components").as_deref()
            {
                last.components = components.iter().map(listed).collect();
            }
        }
        last.components.clone()
    }
}

/// The listed parts of a description, and the internal state by names.
fn listed(component: &Datum) -> Datum {
    let part = |name: &&'static str| Some((*name, component.get(name)?.into_owned()));
    let parts = LISTED.iter().filter_map(part);
    let entries = component
        .get("inspection")
        .map_or_else(Vec::new, |all| entries(&all));
    let inspection = ("inspection", Datum::record(entries));
    Datum::record(parts.chain([inspection]))
}

/// Converts a list of pairs of name and value to the fields of a record.
fn entries(pairs: &Datum) -> Vec<(String, Datum)> {
    let indices = 0..pairs.count().unwrap_or(0);
    let entry = |pair: &Datum| {
        let name = pair.element(0)?.as_text()?.to_owned();
        Some((name, pair.element(1)?.into_owned()))
    };
    indices
        .filter_map(|index| entry(&*pairs.element(index)?))
        .collect()
}

fn text_of(component: &Datum, field: &str) -> String {
    let text = component.get(field);
    text.and_then(|name| Some(name.as_text()?.to_owned()))
        .unwrap_or_default()
}

fn response_of(datum: &Datum) -> Result<HttpResponse, Problem> {
    let text = written::encode(datum).map_err(Problem::Answer)?;
    Ok(response::json(StatusCode::OK, text))
}
