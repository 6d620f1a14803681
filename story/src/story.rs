//! The story of a run.

#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use asmotion_component::{CallError, CallId, Fault, LOG_REPORT, Losses, NOTICE_REPORT, Time};
use asmotion_coordinator::{
    BAD_REPLY_REPORT, BRIEF_STEP_REPORT, BadReply, LOSSES_REPORT, STEP_REPORT, StepRecord,
    UNFIT_REPORT, UNSENT_REPORT, VIOLATION_REPORT, ViolationRecord,
};
use asmotion_datum::{Datum, Sample};
use asmotion_messages::Event as NavigationEvent;
use asmotion_plan::{Part, Plan};
use asmotion_runtime::{
    ADDITION_REPORT, Event, REMOVAL_REPORT, REPLACEMENT_REPORT, WAITING_REPORT,
};

use crate::driven_path::DrivenPath;
use crate::entry::StoryEntry;
use crate::input::{StoryInput, StoryInputs};
use crate::limit::StoryLimit;
use crate::losses::OngoingLosses;
use crate::repeats::RepeatedEntries;
use crate::style::{BAD, FAINT, NAME, NOTE};
use crate::summary::Summary;
use crate::{message, step};

/// Turns the events of a run into lines.
#[derive(Debug, Default)]
pub struct Story {
    /// The inputs of specifications, whose messages are reported.
    inputs: StoryInputs,
    /// Only the summary is wanted.
    is_silent: bool,
    /// Messages on topics reach the components of this process by the bus as well.
    topics_return: bool,
    repeats: RepeatedEntries,
    limit: StoryLimit,
    losses: OngoingLosses,
    summary: Summary,
    /// Names of components in logs, where they differ from those in the composite.
    ids: BTreeMap<String, String>,
    /// The newest call of each component that the summary counts. Numbers of calls ascend, so that an older one is a call that
    /// goes to another binding of its reference, or that is made again.
    last_calls: BTreeMap<String, CallId>,
    /// The newest attempt of each open call that was made again. Each attempt is reported once, whatever number of bindings it
    /// takes.
    attempts: BTreeMap<(String, CallId), u32>,
}

impl Story {
    /// Creates the story of the part of a plan that runs in this process and has not started yet.
    pub fn of(plan: &Plan, part: &Part) -> Self {
        Self {
            inputs: StoryInputs::of(plan),
            topics_return: part.takes_the_bus_inside(),
            ids: ids(plan),
            limit: StoryLimit::of(plan),
            ..Self::default()
        }
    }

    /// The story without its lines: only the summary.
    pub fn silent(self) -> Self {
        Self {
            is_silent: true,
            inputs: self.inputs.events(),
            ..self
        }
    }

    /// Tells the story of another version of the system from now on.
    pub fn follow(&mut self, plan: &Plan) {
        self.ids = ids(plan);
        self.limit = StoryLimit::of(plan);
        let inputs = StoryInputs::of(plan);
        let inputs = if self.is_silent {
            inputs.events()
        } else {
            inputs
        };
        let known = std::mem::replace(&mut self.inputs, inputs);
        self.inputs.continue_from(&known);
        let is_present = |component: &str| plan.component(component).is_some();
        self.summary.retain_coordinators(is_present);
    }

    /// The summary of all events so far.
    pub fn summary(&self) -> &Summary {
        &self.summary
    }

    /// Handles an event. Returns the lines to print, which are usually none.
    pub fn report(&mut self, at: Time, event: &Event<'_>) -> Option<String> {
        let entry = self.entry(at, event);
        if self.is_silent {
            return None;
        }
        let entry = entry.filter(|entry| match &entry.loss {
            Some(place) => self.losses.is_due(at, place.clone(), &entry.line),
            None => true,
        });
        let ended = self.losses.ended(at);
        let repeated = self.repeats.due(at, entry.as_ref());
        let entry = entry.filter(|entry| match &entry.again {
            Some(name) => {
                let change = entry.is_change.then_some(&*entry.line);
                self.repeats.is_new(at, name, change)
            }
            None => true,
        });
        let hidden = self.limit.pass(at);
        let entry = entry.filter(|entry| self.limit.admits(entry.is_warning));
        let entry = entry.map(|entry| entry.line);
        let lines = [hidden, repeated].into_iter().flatten();
        let lines = lines.chain(ended).chain(entry);
        let lines: Vec<String> = lines.map(|line| stamped(at, &line)).collect();
        (!lines.is_empty()).then(|| lines.join("\n"))
    }

    /// The last changes and numbers of losses that have only been counted, for the end of a run.
    pub fn last_changes(&mut self) -> Vec<String> {
        let losses = self.losses.rest();
        let changes = self.repeats.last_changes().into_iter().chain(losses);
        let mut changes: Vec<String> = changes.map(|(at, line)| stamped(at, &line)).collect();
        self.limit.shorten(&mut changes);
        changes.extend(self.limit.rest());
        changes
    }

    fn entry(&mut self, at: Time, event: &Event<'_>) -> Option<StoryEntry> {
        match event {
            Event::Published {
                component,
                port,
                topic,
                sample,
                ..
            } => {
                let collision = self.collided(*sample);
                let moved = self.summary.moved(component, at, *sample);
                self.summary.observe_truth(component, port, *sample);
                // what goes out by the bus is counted when it comes back
                let topic = topic.filter(|_| !self.topics_return);
                let readers = self.inputs.of_output(component, port, topic);
                self.set_goals(*sample, &readers);
                match readers.first().and_then(|it| self.inputs.get_mut(*it)) {
                    Some(input) if self.is_silent => {
                        self.summary.received.count(&input.name_of(*sample));
                        None
                    }
                    Some(input) => message_entry(input, &mut self.summary, component, *sample),
                    None => collision.or(moved),
                }
            }
            Event::Injected {
                target: place,
                source,
                sample,
            } => {
                let readers = self.inputs.of_place(place);
                self.set_goals(*sample, &readers);
                let input = self.inputs.get_mut(*readers.first()?)?;
                if self.is_silent {
                    self.summary.received.count(&input.name_of(*sample));
                    return None;
                }
                message_entry(
                    input,
                    &mut self.summary,
                    source.unwrap_or("outside"),
                    *sample,
                )
            }
            Event::Called {
                component,
                reference,
                operation,
                call,
                attempt,
                argument,
            } => {
                let is_new = self.is_new_call(component, *call);
                if is_new {
                    self.summary
                        .calls
                        .count(&format!("{reference}.{operation}"));
                }
                (!self.is_silent && (is_new || self.is_new_attempt(component, *call, *attempt)))
                    .then(|| StoryEntry::call(reference, operation, *attempt, *argument))
            }
            Event::Replied {
                component,
                reference,
                operation,
                call,
                result,
            } => {
                if self.is_silent {
                    self.summary.failed_calls += u64::from(result.is_err());
                    return None;
                }
                self.attempts.remove(&((*component).to_owned(), *call));
                Some(self.reply_entry(reference, operation, *result))
            }
            Event::Report {
                component,
                kind,
                data: what,
            } => self.report_entry(component, kind, what),
            Event::Fault { component, fault } => {
                self.summary.faults.push(format!("{component}: {fault}"));
                Some(StoryEntry::warning(
                    BAD,
                    "fault",
                    format!("of {component}: {fault}"),
                ))
            }
            Event::Overrun { component, missed } => {
                let fault = Fault::Overrun { missed: *missed };
                let what = format!("{component} {fault}");
                Some(StoryEntry::warning(NOTE, "overrun", what))
            }
            Event::Late {
                component,
                took,
                deadline,
            } => {
                let what = format!(
                    "{component} took {took:.1?} for a cycle; its deadline is {deadline:?}"
                );
                Some(StoryEntry::warning(NOTE, "late", what))
            }
            Event::Denied { component, denied } => Some(StoryEntry::warning(
                NOTE,
                "denied",
                format!("{component}: {denied}"),
            )),
            Event::Dropped {
                component,
                port,
                to,
                total,
                reason,
            } => {
                let mut what = format!("{component}.{port} → {to}: {total} so far");
                if let Some(reason) = reason {
                    what += &format!(" ({reason})");
                }
                Some(StoryEntry::loss([*component, *port, *to], what))
            }
            Event::Lost { count } => {
                let what = format!("{count} events of this run");
                Some(StoryEntry::warning(NOTE, "lost", what))
            }
            Event::Cycle { .. }
            | Event::Answered { .. }
            | Event::LifeCycle { .. }
            | Event::Property { .. } => None,
        }
    }

    /// Sets the goal of each robot whose specification receives the message as an event, if it contains one. Robots can share
    /// a topic.
    fn set_goals(&mut self, sample: &dyn Sample, readers: &[usize]) {
        let Some(goal) = DrivenPath::goal(sample) else {
            return;
        };
        let readers = readers.iter().filter_map(|it| self.inputs.get(*it));
        for input in readers.filter(|input| !input.is_state()) {
            self.summary.robots.set_goal(input.component(), goal);
        }
    }

    fn report_entry(&mut self, component: &str, kind: &str, what: &Datum) -> Option<StoryEntry> {
        match kind {
            STEP_REPORT => {
                let record: StepRecord = what.to().ok()?;
                self.summary.step(component, &record);
                Some(step::entry(component, &record))
            }
            BRIEF_STEP_REPORT => {
                match StepRecord::of_report(what) {
                    Some(record) => self.summary.step(component, &record),
                    None => self.summary.steps += 1,
                }
                None
            }
            BAD_REPLY_REPORT => {
                let reply: BadReply = what.to().ok()?;
                let (reference, operation) = (&reply.reference, &reply.operation);
                Some(self.reply_entry(reference, operation, Err(&reply.error())))
            }
            VIOLATION_REPORT => {
                let violation: ViolationRecord = what.to().ok()?;
                let what = format!("{component}: {violation}");
                Some(StoryEntry::warning(BAD, "violated", what))
            }
            UNSENT_REPORT => {
                let missing = what.as_text().unwrap_or_default();
                let what = format!("{component} has no value for `{missing}` yet");
                Some(StoryEntry::warning(NOTE, "unsent", what))
            }
            UNFIT_REPORT => {
                let what = what.as_text().unwrap_or_default();
                let what = format!("{component} sends nothing on {what}");
                Some(StoryEntry::warning(NOTE, "unsent", what))
            }
            WAITING_REPORT => {
                let what = format!("{component} for {}", what.as_text().unwrap_or_default());
                Some(StoryEntry::warning(NOTE, "waiting", what))
            }
            LOSSES_REPORT => {
                let Losses { dropped, misfits } = what.to().ok()?;
                let what = format!(
                    "{component}: {dropped} events dropped and {misfits} unsuitable messages so far"
                );
                Some(StoryEntry::warning(NOTE, "lost", what))
            }
            REPLACEMENT_REPORT => {
                let what = format!("{component} by {}", what.as_text().unwrap_or_default());
                Some(StoryEntry::warning(NOTE, "replaced", what))
            }
            ADDITION_REPORT => {
                // the calls of a component that was removed and added again are numbered anew
                self.last_calls.remove(component);
                self.attempts.retain(|(caller, _), _| caller != component);
                let what = format!("{component}: {}", what.as_text().unwrap_or_default());
                Some(StoryEntry::warning(NOTE, "added", what))
            }
            REMOVAL_REPORT => {
                let what = format!("{component} {}", what.as_text().unwrap_or_default());
                Some(StoryEntry::warning(NOTE, "removed", what))
            }
            LOG_REPORT => {
                let what = what.as_text().unwrap_or_default();
                let id = self.ids.get(component).map_or(component, String::as_str);
                Some(StoryEntry::warning(NOTE, "log", format!("{id}: {what}")))
            }
            NOTICE_REPORT => {
                let what = what.as_text().unwrap_or_default();
                let id = self.ids.get(component).map_or(component, String::as_str);
                Some(StoryEntry::warning(NOTE, "notice", format!("{id}: {what}")))
            }
            _ => None,
        }
    }

    /// Counts a collision of a simulated world. Returns its entry.
    fn collided(&mut self, sample: &dyn Sample) -> Option<StoryEntry> {
        let event: &NavigationEvent = sample.downcast_ref()?;
        if event.code != NavigationEvent::COLLISION {
            return None;
        }
        self.summary.collisions += 1;
        Some(StoryEntry::warning(
            BAD,
            "collision",
            message::one_line(&event.detail),
        ))
    }

    /// Returns whether a call is made again, and this attempt has not been reported before.
    fn is_new_attempt(&mut self, component: &str, call: CallId, attempt: u32) -> bool {
        let known = self.attempts.entry((component.to_owned(), call));
        let known = known.or_insert(1);
        let is_new = attempt > *known;
        *known = attempt.max(*known);
        is_new
    }

    /// Returns whether a call has not been reported before: it is reported for each binding and each attempt.
    fn is_new_call(&mut self, component: &str, call: CallId) -> bool {
        match self.last_calls.get_mut(component) {
            Some(last) if call <= *last => false,
            Some(last) => {
                *last = call;
                true
            }
            None => {
                self.last_calls.insert(component.to_owned(), call);
                true
            }
        }
    }

    fn reply_entry(
        &mut self,
        reference: &str,
        operation: &str,
        result: Result<&dyn Sample, &CallError>,
    ) -> StoryEntry {
        let name = format!("{reference}.{operation}");
        let line = |what: &str| format!("{NAME}reply{NAME:#} {name}: {what}");
        match result {
            Ok(sample) => {
                let what = message::brief(sample).unwrap_or_else(|| "done".to_owned());
                StoryEntry::repeatable(line(&what), format!("reply {name}: {what}"))
            }
            Err(error) => {
                self.summary.failed_calls += 1;
                StoryEntry::single(line(&format!("{NOTE}{error}{NOTE:#}")))
            }
        }
    }
}

/// The names of the plan's components outside the composite, where they differ.
fn ids(plan: &Plan) -> BTreeMap<String, String> {
    let components = plan.components.iter().filter(|it| it.id != it.name);
    components
        .map(|it| (it.name.clone(), it.id.clone()))
        .collect()
}

/// The entry for a message to a specification, if it is worth reporting.
fn message_entry(
    input: &mut StoryInput,
    summary: &mut Summary,
    speaker: &str,
    sample: &dyn Sample,
) -> Option<StoryEntry> {
    let (name, what) = input.describe(sample)?;
    if !input.is_state() {
        summary.received.count(&name);
    }
    let what = what.map_or_else(String::new, |what| format!(" {what}"));
    let topic = &input.name;
    let line = format!("{NAME}{topic}{NAME:#} {what}   {FAINT}{speaker}{FAINT:#}");
    // streams of numbers are reported from time to time, words each time
    let flows = input.is_state() && !what.contains(char::is_alphabetic);
    Some(if flows {
        StoryEntry::repeatable(line, name)
    } else {
        StoryEntry::single(line)
    })
}

fn stamped(at: Time, line: &str) -> String {
    format!("{FAINT}{:>8.2} s{FAINT:#}  {line}", at.seconds())
}
