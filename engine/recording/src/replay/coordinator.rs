//! Replays the steps of a coordinator, one after the other.

use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

use asmotion_coordinator::{
    CycleCauses, MachineBegin, MachineOrigin, RecordedCycle, StepSubject, Watch, WatchedStep,
    Watcher,
};
use asmotion_lang::Specification;
use asmotion_lang::guards::PassedGuard;
use asmotion_lang::machine::Machine;

use super::begin::ReplayMachine;
use super::compare::{StepPair, function};
use super::difference::{DifferenceKind, StepDifference};
use super::explanation::{InputChange, LocationWatch, LocationWriter};
use super::failure::ReplayFailure;
use super::inputs::{RecordedChooser, RecordedFrame};
use super::sources::{EditedSpecification, SourceTexts};
use crate::run::{ChainedCycle, CoordinatorEnd, StepChain};

/// Options of a replay.
#[derive(Clone, Debug, Default)]
pub struct ReplayOptions {
    /// Specification in the place of the recorded one.
    pub edited: Option<Rc<EditedSpecification>>,
    /// Location whose last write is wanted.
    pub explained: Option<String>,
    /// Keeps the candidates that `choose` rules take: see [`Machine::keep_candidates`].
    pub keeps_candidates: bool,
}

/// Figures about a replay.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ReplayCounts {
    /// Number of records that were repeated and compared, that of a difference included.
    pub compared: u64,
    /// Number of steps among them that failed, as recorded.
    pub failed: u64,
    /// Number of machines that began: 1, and one for each reset and each replacement.
    pub machines: u64,
    /// Number of records that could not be repeated: after a gap, or after a difference.
    pub not_compared: u64,
    /// Number of places at which records are missing.
    pub gaps: u64,
    /// Time of the first record in the run.
    pub first_ns: Option<i64>,
    /// Time of the last record in the run.
    pub last_ns: i64,
    /// Number of the last step that was repeated.
    pub last_number: u64,
}

/// Hashes of the sources of a specification, none for an edited one, and what is watched.
type SpecificationKey = (Vec<String>, String);

/// A specification with what is watched.
struct WatchedSpecification {
    specification: Rc<Specification>,
    watcher: Watcher,
}

impl WatchedSpecification {
    fn new(mut specification: Specification, watch: &Watch) -> Result<Self, ReplayFailure> {
        let watcher = Watcher::new(&mut specification, watch);
        let watcher = watcher.map_err(|error| ReplayFailure::Watch {
            reason: error.to_string(),
        })?;
        Ok(Self {
            specification: Rc::new(specification),
            watcher,
        })
    }
}

/// Replays a coordinator.
pub struct CoordinatorReplay {
    options: ReplayOptions,
    /// Opened specifications.
    specifications: BTreeMap<SpecificationKey, WatchedSpecification>,
    /// The specification of the machine.
    current: SpecificationKey,
    chain: StepChain,
    /// `None` before the first machine, and after a gap.
    machine: Option<ReplayMachine>,
    /// The recorded specification of the machine, if it can be opened.
    recorded: Option<Rc<Specification>>,
    /// Functions that only the edited specification has, and whose updates reach no one.
    new_functions: BTreeSet<String>,
    frame: RecordedFrame,
    watch: Option<LocationWatch>,
    counts: ReplayCounts,
    difference: Option<StepDifference>,
    /// The guards on the way to the update that is different.
    guards: Vec<PassedGuard>,
    /// What an edited specification could not be given, with the first step.
    notes: BTreeMap<String, u64>,
}

impl CoordinatorReplay {
    /// Begins a replay.
    pub fn new(options: ReplayOptions) -> Self {
        let watch = options.explained.as_deref().map(LocationWatch::new);
        Self {
            options,
            specifications: BTreeMap::new(),
            current: SpecificationKey::default(),
            chain: StepChain::default(),
            machine: None,
            recorded: None,
            new_functions: BTreeSet::new(),
            frame: RecordedFrame::default(),
            watch,
            counts: ReplayCounts::default(),
            difference: None,
            guards: Vec::new(),
            notes: BTreeMap::new(),
        }
    }

    /// Repeats a step and compares it with its record. Returns `false` if it was not repeated: after a gap, or after a difference.
    ///
    /// # Errors
    /// The machine of the step cannot begin.
    pub fn step(
        &mut self,
        step: &ChainedCycle,
        texts: &SourceTexts,
    ) -> Result<bool, ReplayFailure> {
        let cycle = &step.cycle;
        self.counts.first_ns.get_or_insert(cycle.time_ns);
        self.counts.last_ns = cycle.time_ns;
        if self.difference.is_some() || !self.continues(step) {
            self.counts.not_compared += 1;
            self.chain.resume(&step.hashes.hash);
            return Ok(false);
        }
        for begin in &cycle.begins {
            let differs = self.begin(begin, texts)?;
            if let Some(kind) = differs {
                self.differ(step, kind);
                return Ok(true);
            }
        }
        self.counts.compared += 1;
        self.counts.last_number = cycle.number;
        if let Some(mut machine) = self.machine.take() {
            let found = self.repeat(step, &mut machine);
            self.machine = Some(machine);
            if let Some(kind) = found {
                self.differ(step, kind);
            }
        }
        Ok(true)
    }

    /// Checks that the last records are there, for a recording that has an end.
    pub fn end(&mut self, end: &CoordinatorEnd) {
        if end.last_hash == self.chain.last() || self.difference.is_some() {
            return;
        }
        self.counts.gaps += 1;
        self.difference_unless_lost(end.lost);
    }

    /// Turns gaps into a difference if the recording counts no record as lost: then the records were removed.
    pub fn difference_unless_lost(&mut self, lost: u64) {
        if lost > 0 || self.counts.gaps == 0 || self.difference.is_some() {
            return;
        }
        self.difference = Some(StepDifference {
            number: self.counts.last_number + 1,
            time_ns: self.counts.last_ns,
            cause: Vec::new(),
            is_altered: true,
            kind: DifferenceKind::Missing,
            guards: Vec::new(),
        });
    }

    /// Figures about the replay so far.
    pub fn counts(&self) -> &ReplayCounts {
        &self.counts
    }

    /// The first difference.
    pub fn difference(&self) -> Option<&StepDifference> {
        self.difference.as_ref()
    }

    /// What the edited specification could not be given, each with the number of the first step.
    pub fn notes(&self) -> impl Iterator<Item = (&str, u64)> {
        self.notes.iter().map(|(text, number)| (&**text, *number))
    }

    /// The machine after the last step, with its specification.
    pub fn machine(&self) -> Option<(&Specification, &Machine)> {
        let machine = self.machine.as_ref()?;
        Some((&machine.specification, &machine.machine))
    }

    /// The values of all bound inputs in the last step, by location.
    pub fn inputs(&self) -> &BTreeMap<String, String> {
        self.frame.values()
    }

    /// The last write to the location that was asked for.
    pub fn writer(&self) -> Option<LocationWriter> {
        self.watch.as_ref()?.writer()
    }

    /// The last change of the location that was asked for, if it is an input.
    pub fn input_change(&self) -> Option<&InputChange> {
        self.watch.as_ref()?.input()
    }
}

impl CoordinatorReplay {
    fn differ(&mut self, step: &ChainedCycle, kind: DifferenceKind) {
        let cycle = &step.cycle;
        self.difference = Some(StepDifference {
            number: cycle.number,
            time_ns: cycle.time_ns,
            cause: cycle.cause.clone(),
            is_altered: !step.is_intact,
            kind,
            guards: std::mem::take(&mut self.guards),
        });
        self.chain.resume(&step.hashes.hash);
    }

    /// Returns whether a record continues from the one before, or begins anew. Notes a gap.
    fn continues(&mut self, step: &ChainedCycle) -> bool {
        let cycle = &step.cycle;
        let first = cycle.begins.first().map(|begin| &begin.from);
        let begins_anew = matches!(first, Some(MachineOrigin::Initial | MachineOrigin::Frozen));
        let next = self.machine.as_ref().map(|it| it.machine.steps() + 1);
        let is_counted = begins_anew || next.is_none() || next == Some(cycle.number);
        if step.hashes.previous != self.chain.last() || !is_counted {
            self.counts.gaps += 1;
            self.machine = None;
            self.chain.resume(&step.hashes.previous);
        }
        begins_anew || self.machine.is_some()
    }

    /// Begins a machine. Returns how its state differs from the recorded one.
    fn begin(
        &mut self,
        begin: &MachineBegin,
        texts: &SourceTexts,
    ) -> Result<Option<DifferenceKind>, ReplayFailure> {
        self.counts.machines += 1;
        let before = self.machine.take();
        if let (MachineOrigin::Initial, Some(watch)) = (&begin.from, &mut self.watch) {
            watch.forget();
        }
        let recorded = self.recorded(begin, texts);
        let is_edited = self.options.edited.is_some();
        let key = match self.options.edited.clone() {
            Some(edited) => {
                let recorded = recorded.ok();
                let recorded = recorded.and_then(|key| self.specifications.get(&key));
                self.recorded = recorded.map(|it| Rc::clone(&it.specification));
                self.edited(&edited, begin)?
            }
            None => recorded?,
        };
        let specification = self.watch(key, &begin.from)?;
        if is_edited {
            self.new_functions = self.recorded.as_ref().map_or_else(BTreeSet::new, |it| {
                &silent_functions(&specification) - &all_functions(it)
            });
        } else {
            self.recorded = Some(Rc::clone(&specification));
        }
        let mut machine = ReplayMachine::begin(specification, begin, before.as_ref(), is_edited)?;
        let watched = self.specifications.get(&self.current);
        machine.safe_rule = watched.and_then(|it| it.watcher.safe_rule());
        if self.options.keeps_candidates {
            machine.machine.keep_candidates();
        }
        let differs = machine.differs_from(begin).filter(|_| !is_edited);
        self.machine = Some(machine);
        Ok(differs)
    }

    /// Opens the recorded specification.
    fn recorded(
        &mut self,
        begin: &MachineBegin,
        texts: &SourceTexts,
    ) -> Result<SpecificationKey, ReplayFailure> {
        let hashes = begin.sources.iter().map(|it| it.hash.clone());
        let key = (hashes.collect(), format!("{:?}", begin.watch));
        if !self.specifications.contains_key(&key) {
            let opened = WatchedSpecification::new(texts.open(begin)?, &begin.watch)?;
            self.specifications.insert(key.clone(), opened);
        }
        Ok(key)
    }

    /// Opens the edited specification. What was watched and does not fit it is left out.
    fn edited(
        &mut self,
        edited: &EditedSpecification,
        begin: &MachineBegin,
    ) -> Result<SpecificationKey, ReplayFailure> {
        let key = (Vec::new(), format!("{:?}", begin.watch));
        if self.specifications.contains_key(&key) {
            return Ok(key);
        }
        let opened = match WatchedSpecification::new(edited.open()?, &begin.watch) {
            Ok(opened) => opened,
            Err(error) => {
                let number = self.counts.last_number + 1;
                self.notes.insert(error.to_string(), number);
                let own = Watch {
                    is_off: begin.watch.is_off,
                    ..Watch::default()
                };
                WatchedSpecification::new(edited.open()?, &own)?
            }
        };
        self.specifications.insert(key.clone(), opened);
        Ok(key)
    }

    /// Watches a machine of this specification that begins.
    fn watch(
        &mut self,
        key: SpecificationKey,
        from: &MachineOrigin,
    ) -> Result<Rc<Specification>, ReplayFailure> {
        let is_same = key == self.current;
        // taken out, because it may continue from another one
        let taken = self.specifications.remove(&key);
        let mut watched = taken.ok_or(ReplayFailure::Frozen)?;
        match from {
            MachineOrigin::Predecessor { .. } if is_same => {}
            MachineOrigin::Predecessor { .. } => {
                watched.watcher.begin();
                if let Some(before) = self.specifications.get(&self.current) {
                    watched.watcher.continue_from(&before.watcher);
                }
            }
            MachineOrigin::Initial | MachineOrigin::Frozen => watched.watcher.begin(),
        }
        let specification = Rc::clone(&watched.specification);
        self.specifications.insert(key.clone(), watched);
        self.current = key;
        Ok(specification)
    }

    /// Repeats a step on the machine. Returns the first difference.
    fn repeat(&mut self, step: &ChainedCycle, own: &mut ReplayMachine) -> Option<DifferenceKind> {
        let cycle = &step.cycle;
        self.frame.advance(cycle);
        let written = self.watch.as_mut().is_some_and(|watch| {
            watch.note_inputs(cycle);
            watch.is_written(cycle)
        });
        let before = written.then(|| own.clone());
        let prepared = self.frame.step(cycle);
        let (mut inputs, mut unfit) = prepared.readable_inputs(&own.machine);
        for message in &cycle.messages {
            if let Err(error) = message.apply(&mut own.machine) {
                unfit.push(error.0);
            }
        }
        let is_edited = self.options.edited.is_some();
        if !unfit.is_empty() && !is_edited {
            return Some(DifferenceKind::Unfit { texts: unfit });
        }
        // with the messages of the step, for an account of it
        let ready = is_edited.then(|| own.machine.clone());
        let mut chooser = RecordedChooser::new(cycle);
        let steps = own.machine.steps();
        let subject = StepSubject {
            specification: &own.specification,
            machine: &mut own.machine,
            inputs: &mut inputs,
            chooser: &mut chooser,
            now_ns: cycle.time_ns,
        };
        let watcher = self.specifications.get_mut(&self.current);
        let made = watcher.map_or_else(WatchedStep::default, |it| {
            it.watcher.step(subject, &|_| true)
        });
        let fault = made.failure.as_ref();
        let fault = fault.map(|it| it.message(&own.specification, &own.machine));
        self.counts.failed += u64::from(fault.is_some() && cycle.fault.is_some());
        let causes = CycleCauses {
            cause: cycle.cause.clone(),
            begins: cycle.begins.clone(),
            messages: cycle.messages.clone(),
            frame: cycle.frame.clone(),
        };
        let replayed = RecordedCycle {
            violations: made.violations,
            replaced: made.replaced,
            ..RecordedCycle::of(&own.specification, &own.machine, steps, causes, fault)
        };
        if let (Some(watch), Some(before)) = (&mut self.watch, before) {
            watch.note_step(before, prepared, cycle);
        }
        if let Some(ready) = ready {
            self.note(&unfit, &chooser, own, cycle.number);
            self.chain.resume(&step.hashes.hash);
            let pair = self.pair(cycle, &replayed, own);
            let found = pair.effects(&self.new_functions, false)?;
            self.guards = own.guards(&ready, &found);
            return Some(found);
        }
        self.difference_from(step, &replayed, own)
    }

    /// Returns the first difference from a repetition with the recorded specification.
    fn difference_from(
        &mut self,
        step: &ChainedCycle,
        replayed: &RecordedCycle,
        own: &ReplayMachine,
    ) -> Option<DifferenceKind> {
        let linked = self.chain.link(replayed);
        let is_equal = linked.is_ok() && self.chain.last() == step.hashes.hash && step.is_intact;
        if is_equal {
            return None;
        }
        let pair = self.pair(&step.cycle, replayed, own);
        let effects = pair.effects(&self.new_functions, true);
        let found = effects.or_else(|| pair.causes());
        Some(found.unwrap_or(DifferenceKind::Altered))
    }

    fn pair<'a>(
        &'a self,
        recorded: &'a RecordedCycle,
        replayed: &'a RecordedCycle,
        own: &'a ReplayMachine,
    ) -> StepPair<'a> {
        StepPair {
            recorded,
            replayed,
            recorded_specification: self.recorded.as_deref(),
            replayed_specification: &own.specification,
        }
    }

    /// Notes what an edited specification could not be given in a step.
    fn note(
        &mut self,
        unfit: &[String],
        chooser: &RecordedChooser,
        own: &ReplayMachine,
        number: u64,
    ) {
        let known = all_functions(&own.specification);
        // an input that the specification does not have is not missing
        let unfit = unfit.iter().filter(|text| {
            let name = function(text.split(" = ").next().unwrap_or_default());
            known.contains(name) || !text.contains(" = ")
        });
        let unfit = unfit.map(|text| format!("`{text}` does not fit and is left out"));
        let missing = self.frame.missing(&own.machine).into_iter();
        let missing = missing
            .map(|location| format!("`{location}` is read, and the recording has no value of it"));
        let new = self.new_functions.iter();
        let updates = own.machine.last_step().updates().iter();
        let written: BTreeSet<_> = updates
            .map(|update| asmotion_lang::simulate::location(&own.machine, update.slot))
            .collect();
        let new = new.filter(|name| written.iter().any(|it| function(it) == **name));
        let new = new.map(|name| format!("`{name}` is new: its updates are not compared"));
        let open = chooser.open.iter().cloned();
        let notes: Vec<_> = unfit.chain(missing).chain(new).chain(open).collect();
        for note in notes {
            self.notes.entry(note).or_insert(number);
        }
    }
}

/// Names of the functions of a specification.
fn all_functions(specification: &Specification) -> BTreeSet<String> {
    let own = specification.model.own_functions();
    own.map(|(_, function)| function.name.to_string()).collect()
}

/// Names of the functions that rules update, and whose updates nobody outside sees.
fn silent_functions(specification: &Specification) -> BTreeSet<String> {
    let own = specification.model.own_functions();
    let silent =
        own.filter(|(_, function)| function.kind == asmotion_lang::FunctionKind::Controlled);
    silent
        .map(|(_, function)| function.name.to_string())
        .collect()
}
