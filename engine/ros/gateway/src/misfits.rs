//! Messages that do not fit the other side: counted, and reported once for each cause.

use std::collections::BTreeSet;

use asmotion_component::{Cycle, NOTICE_REPORT};
use asmotion_datum::Datum;

/// Messages that do not fit the other side.
#[derive(Default)]
pub(crate) struct Misfits {
    count: u64,
    /// Ports and causes that have been reported.
    reported: BTreeSet<(String, String)>,
}

/// Number of different causes that are reported; later ones are counted only.
const REPORTED: usize = 32;

impl Misfits {
    /// Number of misfits so far.
    pub(crate) fn total(&self) -> u64 {
        self.count
    }

    /// Counts a message, and reports it if the cause is new for the port.
    pub(crate) fn count(
        &mut self,
        (port, ros): (&String, &String),
        reason: &str,
        cycle: &mut Cycle<'_>,
    ) {
        self.count += 1;
        let cause = (port.clone(), reason.to_owned());
        if self.reported.len() < REPORTED && self.reported.insert(cause) {
            let text = format!("a message between `{port}` and `{ros}` was dropped: {reason}");
            cycle.report(NOTICE_REPORT, Datum::text(text));
        }
    }
}
