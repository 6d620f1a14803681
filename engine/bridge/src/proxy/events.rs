//! Events about the target that the proxy sends to its listener.

use std::time::Duration;

use asmotion_component::{Cycle, Dynamic, Interface, Required};
use asmotion_datum::Datum;

use super::ProxyNotification;

/// The listener, and the events to send.
pub(super) struct ProxyEvents {
    listener: Required<Dynamic>,
    notify: ProxyNotification,
    /// `stale` was sent, and no sample has arrived since.
    pub is_stale: bool,
}

impl ProxyEvents {
    pub(super) fn declare(notify: &ProxyNotification, interface: &mut Interface) -> Self {
        let (reference, service) = (&notify.reference, &notify.interface);
        let doc = "receives the events of the target";
        Self {
            listener: interface.require_of(reference, service, &notify.operation, doc),
            notify: notify.clone(),
            is_stale: false,
        }
    }

    /// Sends `busy`: a command was accepted.
    pub(super) fn notify_busy(&self, cycle: &mut Cycle<'_>) {
        if self.notify.busy {
            self.notify("busy", String::new(), cycle);
        }
    }

    /// Sends `idle`: the motion has ended.
    pub(super) fn notify_idle(&self, error: f64, cycle: &mut Cycle<'_>) {
        self.notify("idle", format!("{error:.4} from the goal"), cycle);
    }

    /// Sends `refresh` and `fault` as the sample requires. Returns whether the sample is faulty.
    pub(super) fn notify_sample(
        &mut self,
        port: &str,
        sample: &Datum,
        cycle: &mut Cycle<'_>,
    ) -> bool {
        self.is_stale = false;
        let is = |condition: &Option<crate::condition::MessageCondition>| {
            condition
                .as_ref()
                .filter(|condition| condition.port == port)
                .filter(|condition| condition.is_met_by(sample))
                .map(|condition| sample.get(&condition.path).map(|part| part.to_string()))
        };
        if is(&self.notify.refresh).is_some() {
            self.notify("refresh", String::new(), cycle);
        }
        let fault = is(&self.notify.fault);
        let faulty = fault.is_some();
        if let Some(part) = fault {
            self.notify("fault", part.unwrap_or_default(), cycle);
        }
        faulty
    }

    /// Sends `fault`, if the composite asks for faults.
    pub(super) fn notify_fault(&self, detail: &str, cycle: &mut Cycle<'_>) {
        if self.notify.fault.is_some() {
            self.notify("fault", detail.to_owned(), cycle);
        }
    }

    /// Sends `stale` if samples have just become overdue, and returns their age.
    pub(super) fn notify_stale(
        &mut self,
        age: Duration,
        cycle: &mut Cycle<'_>,
    ) -> Option<Duration> {
        let limit = self.notify.stale?;
        if age < limit || self.is_stale {
            return None;
        }
        self.is_stale = true;
        self.notify("stale", format!("no data for {age:?}"), cycle);
        Some(age)
    }

    /// Returns whether the newest sample is too old to be used.
    pub(super) fn is_stale(&self) -> bool {
        self.is_stale
    }

    fn notify(&self, event: &str, detail: String, cycle: &mut Cycle<'_>) {
        let notice = Datum::record([
            ("event", Datum::text(event)),
            ("detail", Datum::Text(detail)),
        ]);
        cycle.call_one_way(self.listener, self.notify.conversion.apply(&notice));
    }
}
