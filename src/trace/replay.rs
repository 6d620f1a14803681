//! The steps of a coordinator in the trace of a run, for a replay with its specification alone.

use std::collections::BTreeMap;
use std::fmt::Write;

use asmotion_coordinator::{FAILED_STEP_REPORT, STEP_REPORT};
use asmotion_diagnostics::or_did_you_mean;
use asmotion_diagnostics::similar;
use asmotion_runtime::REPLACEMENT_REPORT;

/// The recorded steps of a coordinator. Steps that wrote nothing are in no trace; they do not change the state.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RecordedRun {
    /// Inputs, choices and times as a trace of the specification.
    pub causes: String,
    /// The steps, in order.
    pub steps: Vec<RecordedUpdates>,
}

/// The updates of a recorded step.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RecordedUpdates {
    /// Number of the step in the run.
    pub number: u64,
    /// Time of the step in nanoseconds of the run.
    pub at_ns: i64,
    /// The update set, as `location = value`, ordered by location; `None` if the step failed.
    pub updates: Option<Vec<String>>,
}

/// The reason that the trace of a run cannot be replayed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ReplayError {
    /// The trace has no step.
    #[error("`{path}` contains no step of a specification, so there is nothing to replay")]
    Empty {
        /// Path of the trace.
        path: String,
    },
    /// Several coordinators have steps in the trace.
    #[error(
        "`{path}` contains the steps of several coordinators ({}): select one with `--component`",
        names.join(", ")
    )]
    Several {
        /// Path of the trace.
        path: String,
        /// Names of the coordinators.
        names: Vec<String>,
    },
    /// The selected component has no step in the trace.
    #[error(
        "`{path}` contains no step of `{name}`{}; it contains those of {}",
        or_did_you_mean(similar(name, names).map(String::as_str)),
        names.join(", ")
    )]
    Unknown {
        /// Path of the trace.
        path: String,
        /// The selected component.
        name: String,
        /// Names of the coordinators.
        names: Vec<String>,
    },
    /// The trace of a specification has no components.
    #[error("`{path}` is the trace of a specification alone: remove `--component`")]
    NoComponents {
        /// Path of the trace.
        path: String,
    },
    /// The coordinator was replaced or began again during the run.
    #[error(
        "`{name}` was replaced at {} s of the run: its steps are those of several machines, and no single replay gives them",
        *at_ns as f64 / 1e9
    )]
    Replaced {
        /// Name of the coordinator.
        name: String,
        /// Time of the replacement, or of the first step after it.
        at_ns: i64,
    },
    /// The safe rule of the composite made a step.
    #[error(
        "at {} s of the run, the safe rule `{rule}` made a step of `{name}` in place of the main rule: the specification alone does not \
         give it",
        *at_ns as f64 / 1e9
    )]
    SafeRule {
        /// Name of the coordinator.
        name: String,
        /// The safe rule.
        rule: String,
        /// Time of the step.
        at_ns: i64,
    },
    /// The specification exchanges messages, which the trace of a run does not contain.
    #[error(
        "`{specification}` exchanges messages with services, and the trace of a run contains only their checksums: it cannot be replayed"
    )]
    Messages {
        /// Name of the specification.
        specification: String,
    },
    /// A replayed step wrote something else.
    #[error(
        "step {} (at {} s of the run) deviates: the run wrote `{}`, the replay `{}`; the specification or its imports have changed since",
        recorded.number,
        recorded.at_ns as f64 / 1e9,
        listed(recorded.updates.as_deref().unwrap_or_default()),
        listed(replayed)
    )]
    Deviates {
        /// The step of the run.
        recorded: RecordedUpdates,
        /// The update set of the replay.
        replayed: Vec<String>,
    },
    /// A step that failed does not fail in the replay.
    #[error(
        "step {} (at {} s of the run) failed, and in the replay it writes `{}`; the specification or its imports have changed since",
        recorded.number, recorded.at_ns as f64 / 1e9, listed(replayed)
    )]
    DoesNotFail {
        /// The step of the run.
        recorded: RecordedUpdates,
        /// The update set of the replay.
        replayed: Vec<String>,
    },
}

fn listed(updates: &[String]) -> String {
    match updates {
        [] => "nothing".to_owned(),
        updates => updates.join(", "),
    }
}

/// Returns whether a text is the trace of a run, whose lines begin with a time.
pub fn is_run_trace(text: &str) -> bool {
    let first = text.lines().next().and_then(|line| line.split_once(' '));
    first.is_some_and(|(time, _)| time.parse::<i64>().is_ok())
}

/// Reads the steps of a coordinator from the trace of a run: of `component`, or of the only one.
///
/// # Errors
/// There is no such coordinator, there are several, or it was replaced during the run.
pub fn recorded_run(
    path: &str,
    text: &str,
    component: Option<&str>,
) -> Result<RecordedRun, ReplayError> {
    let path = path.to_owned();
    let mut runs = runs(text);
    let names: Vec<String> = runs.keys().map(|name| (*name).to_owned()).collect();
    match (component, names.as_slice()) {
        (_, []) => Err(ReplayError::Empty { path }),
        (Some(name), _) => runs.remove(name).unwrap_or_else(|| {
            Err(ReplayError::Unknown {
                path,
                name: name.to_owned(),
                names,
            })
        }),
        (None, [only]) => runs
            .remove(only.as_str())
            .unwrap_or_else(|| Ok(RecordedRun::default())),
        (None, _) => Err(ReplayError::Several { path, names }),
    }
}

/// The recorded steps of all coordinators by name, or the reason that they cannot be replayed.
fn runs(text: &str) -> BTreeMap<&str, Result<RecordedRun, ReplayError>> {
    let mut runs: BTreeMap<&str, Result<RecordedRun, ReplayError>> = BTreeMap::new();
    let mut current: Option<&str> = None;
    for line in text.lines() {
        if let Some(fact) = line.strip_prefix("  ") {
            if let Some((name, run)) = current.and_then(|name| Some((name, runs.get_mut(name)?)))
                && let Ok(recorded) = run
            {
                if let Some(rule) = fact.strip_prefix("R ") {
                    let at_ns = recorded.steps.last().map_or(0, |step| step.at_ns);
                    let (name, rule) = (name.to_owned(), rule.to_owned());
                    *run = Err(ReplayError::SafeRule { name, rule, at_ns });
                } else {
                    recorded.add(fact);
                }
            }
            continue;
        }
        if let Some((name, at_ns)) = replacement_of(line) {
            let name_of_run = name.to_owned();
            let replaced = ReplayError::Replaced {
                name: name_of_run,
                at_ns,
            };
            runs.insert(name, Err(replaced));
        }
        let step = step_of(line);
        current = step.as_ref().map(|(name, _)| *name);
        if let Some((name, step)) = step {
            let run = runs
                .entry(name)
                .or_insert_with(|| Ok(RecordedRun::default()));
            if let Ok(recorded) = run
                && let Err(error) = recorded.begin(name, step)
            {
                *run = Err(error);
            }
        }
    }
    runs
}

/// The component and time in the report of its replacement.
fn replacement_of(line: &str) -> Option<(&str, i64)> {
    let (at, line) = line.split_once(" report ")?;
    let (name, line) = line.split_once(' ')?;
    let kind = line.split(' ').next();
    (kind == Some(REPLACEMENT_REPORT)).then_some((name, at.parse().ok()?))
}

/// The component and the step in the first line of a step.
fn step_of(line: &str) -> Option<(&str, RecordedUpdates)> {
    let words: Vec<&str> = line.split(' ').collect();
    let [at, "report", name, kind, number] = words.as_slice() else {
        return None;
    };
    let updates = match *kind {
        STEP_REPORT => Some(Vec::new()),
        FAILED_STEP_REPORT => None,
        _ => return None,
    };
    let step = RecordedUpdates {
        number: number.parse().ok()?,
        at_ns: at.parse().ok()?,
        updates,
    };
    Some((name, step))
}

impl RecordedRun {
    fn begin(&mut self, name: &str, step: RecordedUpdates) -> Result<(), ReplayError> {
        let at_ns = step.at_ns;
        if self
            .steps
            .last()
            .is_some_and(|last| last.number >= step.number)
        {
            let name = name.to_owned();
            return Err(ReplayError::Replaced { name, at_ns });
        }
        self.steps.push(step);
        // writing to a string cannot fail
        let _ = writeln!(self.causes, "@step {}\nT {at_ns}", self.steps.len());
        Ok(())
    }

    /// Adds an input, a choice or an update to the last step.
    fn add(&mut self, fact: &str) {
        let updates = self.steps.last_mut().and_then(|it| it.updates.as_mut());
        match (fact.strip_prefix("U "), updates) {
            (Some(update), Some(updates)) => updates.push(update.to_owned()),
            (Some(_), None) | (None, _) => {
                self.causes.push_str(fact);
                self.causes.push('\n');
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{ReplayError, is_run_trace, recorded_run};

    const TRACE: &str = "0 life A PreOperational Stopped
50 report A asm/Step 1
  M go = true
  C 1 of 3
  U mode = ON
60 publish A.out #1 std_msgs/Bool 0a
70 report B asm/Step 4
  U n = 1
80 report A asm/Unsent \"map\"
90 report A asm/Step 5
  U mode = OFF
  U n = 2
";

    #[test]
    fn the_steps_of_one_coordinator_are_a_trace_of_its_specification() {
        assert!(is_run_trace(TRACE));
        assert!(!is_run_trace("# trace-format 1\n@step 1\n"));
        let run = recorded_run("t", TRACE, Some("A")).unwrap();
        assert_eq!(
            run.causes,
            "@step 1\nT 50\nM go = true\nC 1 of 3\n@step 2\nT 90\n"
        );
        let numbers: Vec<u64> = run.steps.iter().map(|step| step.number).collect();
        assert_eq!(numbers, [1, 5]);
        let last: Vec<_> = run.steps[1].updates.iter().flatten().collect();
        assert_eq!(last, ["mode = OFF", "n = 2"]);
    }

    #[test]
    fn a_trace_that_cannot_be_replayed_is_refused() {
        let refused = |text: &str, name| recorded_run("t", text, name).unwrap_err();
        let several = refused(TRACE, None);
        assert!(matches!(several, ReplayError::Several { names, .. } if names == ["A", "B"]));
        let unknown = refused(TRACE, Some("C"));
        assert!(matches!(unknown, ReplayError::Unknown { .. }));
        assert!(matches!(
            refused("0 life A X Y\n", None),
            ReplayError::Empty { .. }
        ));
        let again = format!("{TRACE}95 report A asm/Step 1\n  U n = 3\n");
        let replaced = refused(&again, Some("A"));
        assert!(matches!(replaced, ReplayError::Replaced { at_ns: 95, .. }));
        assert!(recorded_run("t", &again, Some("B")).is_ok());
    }

    #[test]
    fn a_run_with_a_step_of_the_safe_rule_is_refused() {
        let safe = format!("{TRACE}95 report A asm/Step 6\n  R r_stop[]\n  U n = 3\n");
        let refused = recorded_run("t", &safe, Some("A")).unwrap_err();
        assert!(matches!(&refused, ReplayError::SafeRule { at_ns: 95, .. }));
        assert!(refused.to_string().contains("`r_stop[]`"), "{refused}");
        assert!(recorded_run("t", &safe, Some("B")).is_ok());
    }

    #[test]
    fn c18_a_replaced_coordinator_is_not_replayed_and_the_others_are() {
        let line = "92 report A replaced \"another version of `a.asm`\"\n95 report A asm/Step 6\n";
        let swapped = format!("{TRACE}{line}  U n = 3\n");
        let refused = recorded_run("t", &swapped, Some("A")).unwrap_err();
        assert!(matches!(refused, ReplayError::Replaced { at_ns: 92, .. }));
        assert!(recorded_run("t", &swapped, Some("B")).is_ok());
    }

    #[test]
    fn c18_an_added_coordinator_is_replayed_unless_it_was_there_before() {
        let added = |name: &str| {
            let report = format!("93 report {name} added \"`a.asm`\"\n");
            let step = format!("95 report {name} asm/Step 1\n  U n = 3\n");
            format!("{TRACE}92 report A removed \"from the running system\"\n{report}{step}")
        };
        let replayed = recorded_run("t", &added("C"), Some("C")).unwrap();
        assert_eq!(replayed.steps[0].updates, Some(vec!["n = 3".to_owned()]));
        assert_eq!(
            recorded_run("t", &added("C"), Some("A"))
                .unwrap()
                .steps
                .len(),
            2
        );
        let again = recorded_run("t", &added("A"), Some("A")).unwrap_err();
        assert!(matches!(again, ReplayError::Replaced { at_ns: 95, .. }));
    }
}
