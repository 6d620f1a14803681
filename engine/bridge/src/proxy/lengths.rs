//! Lengths of lists in commands. The target expects as many elements as it has joints, which no type says; a list of its
//! state has the same number, and the proxy learns it from there, so that it can refuse a command of another length.

use asmotion_datum::Datum;

use super::ListLength;
use crate::fit::{SchemaMisfit, wrong_count};

/// The lists of commands whose lengths are known or can be learnt.
pub(super) struct LengthMonitor {
    lists: Vec<MonitoredList>,
}

struct MonitoredList {
    length: ListLength,
    /// Number of elements that the target has; `None` until a sample shows it.
    known: Option<usize>,
    /// Number of elements of the last command, until its motion has ended; it may not fit a target that has restarted.
    sent: Option<usize>,
}

/// The learnt part of a [`MonitoredList`].
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LearntLength {
    known: Option<usize>,
    sent: Option<usize>,
}

impl LengthMonitor {
    pub(super) fn new(lengths: &[ListLength]) -> Self {
        let lists = lengths.iter().map(|length| MonitoredList {
            known: length.declared,
            length: length.clone(),
            sent: None,
        });
        Self {
            lists: lists.collect(),
        }
    }

    /// Checks a command that is about to be sent through a port.
    ///
    /// # Errors
    /// The first list with another number of elements than the target has.
    pub(super) fn command(&mut self, port: &str, message: &Datum) -> Result<(), SchemaMisfit> {
        let of_port = |list: &MonitoredList| list.length.commanded.0 == port;
        let counts: Vec<Option<usize>> = self
            .lists
            .iter()
            .map(|list| of_port(list).then(|| list.commanded(message)).flatten())
            .collect();
        // messages with several lists leave those empty that they do not use
        let is_partial = counts.iter().flatten().any(|count| *count > 0);
        for (list, count) in self.lists.iter().zip(&counts) {
            let (Some(expected), Some(found)) = (list.known, *count) else {
                continue;
            };
            if found != expected && !(found == 0 && is_partial) {
                return Err(wrong_count(expected, found).in_field(&list.length.commanded.1));
            }
        }
        for (list, count) in self.lists.iter_mut().zip(counts) {
            if of_port(list) {
                list.sent = count.filter(|count| *count > 0);
            }
        }
        Ok(())
    }

    /// Learns lengths from a sample of the target. Returns the ports whose last command turns out not to fit, with the
    /// reason.
    pub(super) fn measure(&mut self, port: &str, sample: &Datum) -> Vec<(String, SchemaMisfit)> {
        let mut unfit = Vec::new();
        for list in &mut self.lists {
            let (measured, path) = &list.length.measured;
            if measured != port {
                continue;
            }
            // an empty list measures nothing
            let count = sample.get(path).and_then(|list| list.count());
            let Some(count) = count.filter(|count| *count > 0) else {
                continue;
            };
            if list.known.replace(count) == Some(count) {
                continue;
            }
            let (commands, path) = &list.length.commanded;
            if let Some(sent) = list.sent.take_if(|sent| *sent != count) {
                unfit.push((commands.clone(), wrong_count(count, sent).in_field(path)));
            }
        }
        unfit
    }

    /// Called when the motion commanded through a port has ended: its command has been carried out.
    pub(super) fn finish(&mut self, port: &str) {
        for list in &mut self.lists {
            if list.length.commanded.0 == port {
                list.sent = None;
            }
        }
    }

    pub(super) fn learnt(&self) -> Vec<LearntLength> {
        let lists = self.lists.iter().map(|list| LearntLength {
            known: list.known,
            sent: list.sent,
        });
        lists.collect()
    }

    /// Restores what was learnt. Returns `false`, without changing anything, if it belongs to other lists.
    pub(super) fn restore(&mut self, learnt: &[LearntLength]) -> bool {
        let fits = learnt.len() == self.lists.len();
        if fits {
            for (list, learnt) in self.lists.iter_mut().zip(learnt) {
                (list.known, list.sent) = (learnt.known, learnt.sent);
            }
        }
        fits
    }
}

impl MonitoredList {
    /// Number of elements of the list in a command; an omitted list is empty.
    fn commanded(&self, message: &Datum) -> Option<usize> {
        let list = message.get(&self.length.commanded.1);
        list.map_or(Some(0), |list| list.count())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn monitor(paths: &[&str]) -> LengthMonitor {
        let lengths = paths.iter().map(|path| ListLength {
            commanded: ("commands".to_owned(), (*path).to_owned()),
            measured: ("status".to_owned(), (*path).to_owned()),
            declared: None,
        });
        LengthMonitor::new(&lengths.collect::<Vec<_>>())
    }

    fn message(lists: &[(&'static str, usize)]) -> Datum {
        let lists = lists
            .iter()
            .map(|(name, count)| (*name, Datum::List(vec![Datum::Float(0.0); *count])));
        Datum::record(lists)
    }

    #[test]
    fn it_learns_from_the_target_how_many_joints_there_are() {
        let mut lengths = monitor(&["position"]);
        assert_eq!(lengths.measure("status", &message(&[("position", 6)])), []);
        let refused = lengths.command("commands", &message(&[("position", 5)]));
        assert_eq!(
            refused.unwrap_err().to_string(),
            "`position`: expected a list of 6, found one of 5"
        );
        let omitted = lengths.command("commands", &message(&[]));
        assert_eq!(
            omitted.unwrap_err().to_string(),
            "`position`: expected a list of 6, found one of 0"
        );
        assert_eq!(
            lengths.command("commands", &message(&[("position", 6)])),
            Ok(())
        );
        // neither another port nor an empty list changes what is known
        lengths.measure("other", &message(&[("position", 5)]));
        lengths.measure("status", &message(&[("position", 0)]));
        assert!(
            lengths
                .command("commands", &message(&[("position", 5)]))
                .is_err()
        );
        assert_eq!(
            lengths.command("other", &message(&[("position", 5)])),
            Ok(())
        );
    }

    #[test]
    fn a_command_before_the_first_sample_is_judged_by_it_once() {
        let mut lengths = monitor(&["position"]);
        lengths
            .command("commands", &message(&[("position", 5)]))
            .unwrap();
        let unfit = lengths.measure("status", &message(&[("position", 6)]));
        assert_eq!(
            unfit
                .iter()
                .map(|(port, why)| format!("{port}: {why}"))
                .collect::<Vec<_>>(),
            ["commands: `position`: expected a list of 6, found one of 5"]
        );
        assert_eq!(lengths.measure("status", &message(&[("position", 6)])), []);
    }

    #[test]
    fn a_command_to_a_target_that_returns_with_other_joints_is_unfit_unless_it_has_ended() {
        for has_ended in [false, true] {
            let mut lengths = monitor(&["position"]);
            lengths.measure("status", &message(&[("position", 6)]));
            lengths
                .command("commands", &message(&[("position", 6)]))
                .unwrap();
            if has_ended {
                lengths.finish("commands");
            }
            let unfit = lengths.measure("status", &message(&[("position", 5)]));
            assert_eq!(unfit.is_empty(), has_ended);
        }
    }

    #[test]
    fn a_list_that_a_command_does_not_use_can_be_empty_if_another_is_not() {
        let mut lengths = monitor(&["position", "velocity"]);
        lengths.measure("status", &message(&[("position", 2), ("velocity", 2)]));
        for (position, velocity, accepted) in [
            (2, 0, true),
            (0, 2, true),
            (2, 2, true),
            (0, 0, false),
            (2, 1, false),
        ] {
            let command = message(&[("position", position), ("velocity", velocity)]);
            let result = lengths.command("commands", &command);
            assert_eq!(result.is_ok(), accepted, "{position} {velocity}");
        }
    }

    #[test]
    fn a_declared_length_is_known_before_the_first_sample() {
        let mut lengths = LengthMonitor::new(&[ListLength {
            commanded: ("commands".to_owned(), "position".to_owned()),
            measured: ("status".to_owned(), "position".to_owned()),
            declared: Some(3),
        }]);
        assert!(
            lengths
                .command("commands", &message(&[("position", 5)]))
                .is_err()
        );
    }

    #[test]
    fn what_was_learnt_is_restored() {
        let mut lengths = monitor(&["position"]);
        lengths.measure("status", &message(&[("position", 2)]));
        let mut other = monitor(&["position"]);
        assert!(other.restore(&lengths.learnt()));
        assert!(
            other
                .command("commands", &message(&[("position", 3)]))
                .is_err()
        );
        assert!(!other.restore(&[]));
    }
}
