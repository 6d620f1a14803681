//! The last write to a location: the rule, and why it wrote.

use asmotion_coordinator::{ReadLocation, RecordedCycle};
use asmotion_lang::guards::PassedGuard;
use asmotion_lang::simulate::{self, RecordedStep};

use super::begin::ReplayMachine;

/// The last update of a location.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LocationWriter {
    /// The location.
    pub location: String,
    /// Value before the step.
    pub before: String,
    /// Value after the step.
    pub after: String,
    /// Number of the step.
    pub number: u64,
    /// Time of the step in the run.
    pub time_ns: i64,
    /// Cause of the step.
    pub cause: Vec<String>,
    /// Text of the update rule.
    pub text: String,
    /// Name of the rule declaration that contains it.
    pub rule: Option<String>,
    /// Place of the update rule: path, line and column.
    pub place: (String, usize, usize),
    /// The guards on the way to the update, outermost first.
    pub guards: Vec<PassedGuard>,
    /// The inputs that the step read.
    pub read: Vec<ReadLocation>,
    /// The safe rule, if it made the step in place of the main rule.
    pub safe_rule: Option<String>,
}

/// The last change of an input.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InputChange {
    /// The location.
    pub location: String,
    /// Value before; `None` for the first one.
    pub before: Option<String>,
    /// Value since then.
    pub value: String,
    /// Number of the first step with this value.
    pub number: u64,
    /// Time of that step in the run.
    pub time_ns: i64,
    /// Cause of that step.
    pub cause: Vec<String>,
}

/// Looks for the last write to a location, or the last change of an input.
pub(super) struct LocationWatch {
    /// The location, without blanks.
    location: String,
    written: Option<WrittenStep>,
    input: Option<InputChange>,
}

/// A step that wrote the location, for a repetition that accounts for it: a copy of a machine does not have its last step.
struct WrittenStep {
    before: ReplayMachine,
    step: RecordedStep,
    cycle: RecordedCycle,
}

impl LocationWatch {
    pub fn new(location: &str) -> Self {
        Self {
            location: without_blanks(location),
            written: None,
            input: None,
        }
    }

    /// A machine begins in its initial state, in which nothing is written.
    pub fn forget(&mut self) {
        self.written = None;
        self.input = None;
    }

    pub fn note_inputs(&mut self, cycle: &RecordedCycle) {
        let mut changed = cycle.frame.iter();
        let found = changed.find(|(location, _)| without_blanks(location) == self.location);
        if let Some((location, value)) = found {
            let before = self.input.take().map(|known| known.value);
            self.input = Some(InputChange {
                location: location.clone(),
                before,
                value: value.clone(),
                number: cycle.number,
                time_ns: cycle.time_ns,
                cause: cycle.cause.clone(),
            });
        }
    }

    /// Returns whether a step wrote the location.
    pub fn is_written(&self, cycle: &RecordedCycle) -> bool {
        let mut updates = cycle.updates.iter();
        updates.any(|update| without_blanks(&update.location) == self.location)
    }

    pub fn note_step(&mut self, before: ReplayMachine, step: RecordedStep, cycle: &RecordedCycle) {
        self.written = Some(WrittenStep {
            before,
            step,
            cycle: cycle.clone(),
        });
    }

    /// The last change, if the location is an input.
    pub fn input(&self) -> Option<&InputChange> {
        self.input.as_ref()
    }

    /// The last write to the location.
    pub fn writer(&self) -> Option<LocationWriter> {
        let WrittenStep {
            before,
            step,
            cycle,
        } = self.written.as_ref()?;
        let mut updates = cycle.updates.iter();
        let recorded = updates.find(|it| without_blanks(&it.location) == self.location)?;
        let specification = &before.specification;
        let safe_rule = before.safe_rule.filter(|_| cycle.replaced.is_some());
        let mut before = before.machine.clone();
        step.deliver(&mut before).ok()?;
        let machine = &mut before.clone();
        let (mut inputs, _) = step.readable_inputs(machine);
        // a step that breaks an invariant has made its updates
        let _ = match safe_rule {
            Some(rule) => machine.step_with(rule, &mut inputs, &mut step.choices(), step.now_ns),
            None => machine.step(&mut inputs, &mut step.choices(), step.now_ns),
        };
        let mut updates = machine.last_step().updates().iter();
        let update =
            updates.find(|update| simulate::location(machine, update.slot) == recorded.location)?;
        let location = machine.state().location(machine.program(), update.slot);
        let (function, arguments) = location?;
        let span = specification.span(update.origin);
        let sources = &specification.sources;
        let (line, column) = sources.position(span.file, span.start);
        let rule = specification.rule_at(span);
        Some(LocationWriter {
            location: recorded.location.clone(),
            before: recorded.before.clone(),
            after: recorded.after.clone(),
            number: cycle.number,
            time_ns: cycle.time_ns,
            cause: cycle.cause.clone(),
            text: asmotion_lang::guards::on_one_line(specification, span),
            rule: rule.map(|rule| rule.name.to_string()),
            place: (sources.path(span.file).to_owned(), line, column),
            guards: specification.guards_of_update(machine, &before, function, &arguments),
            read: cycle.read.clone(),
            safe_rule: cycle.replaced.as_ref().map(|it| it.rule.clone()),
        })
    }
}

fn without_blanks(text: &str) -> String {
    text.split_whitespace().collect()
}
