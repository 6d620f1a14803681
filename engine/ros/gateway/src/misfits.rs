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
    pub(crate) fn count(&mut self, at: (&String, &String), reason: &str, cycle: &mut Cycle<'_>) {
        self.count_with_details(at, (reason, ""), cycle);
    }

    /// As [`count`](Self::count), with details of the message, which are not part of the cause.
    pub(crate) fn count_with_details(
        &mut self,
        (port, ros): (&String, &String),
        (reason, details): (&str, &str),
        cycle: &mut Cycle<'_>,
    ) {
        let details = match details {
            "" => String::new(),
            details => format!(" ({details})"),
        };
        let text = format!("a message between `{port}` and `{ros}` was dropped: {reason}{details}");
        self.count_cause((port, reason), text, cycle);
    }

    /// Counts a transform that was refused, and reports it if the cause is new for the topic.
    pub(crate) fn count_transform(&mut self, ros: &str, reason: &str, cycle: &mut Cycle<'_>) {
        let text = format!("`{ros}`: a transform was ignored: {reason}");
        self.count_cause((ros, reason), text, cycle);
    }

    fn count_cause(&mut self, (at, reason): (&str, &str), text: String, cycle: &mut Cycle<'_>) {
        self.count += 1;
        let cause = (at.to_owned(), reason.to_owned());
        if self.reported.len() < REPORTED && self.reported.insert(cause) {
            cycle.report(NOTICE_REPORT, Datum::text(text));
        }
    }
}
