//! The verification of a specification: preparation, exploration, verdicts.

use crate::advice::{SpecificationAdvice, advice};
use crate::codes::m001::InputWithoutRange;
use crate::codes::m002::TooManyAlternatives;
use crate::codes::m006::NothingAssumed;
use crate::codes::m013::StorageFailure;
use crate::codes::main_rule;
use crate::counterexample::Replay;
use crate::deciding::Deciding;
use crate::due_fairness::DueFairness;
use crate::environment::EnvironmentModel;
use crate::explore::{Exploration, ExplorationError, ExplorationOptions, Incomplete, Progress};
use crate::explorer::Explorer;
use crate::fair_moves::FairMoves;
use crate::grounded;
use crate::growth::{GrowingLocation, growing_locations};
use crate::inputs::InputRanges;
use crate::logic::visit_conditions;
use crate::machines::MachineSystem;
use crate::mail::MessagePlan;
use crate::observer::ObserverMachine;
#[cfg(feature = "symbolic")]
use crate::options::Engine;
use crate::options::{InputValues, Options, Storage};
use crate::preparation::{Prepared, prepare, report_of};
use crate::property::{CheckedProperty, Note};
use crate::reads::InputFunctions;
use crate::regions::RepresentedInput;
use crate::reuse::{self, KeptExploration};
use crate::spill::Spill;
use crate::steady_growth::steady_growth;
use crate::store::{StateStorage, expected_missed};
use crate::system::{SystemSpecification, VerifiedMachine};
use crate::system_plan::SystemPlan;
use crate::transition::{SingleMachine, TransitionSystem};
use crate::verdicts::verdicts;
use asmotion_diagnostics::Finding;
use asmotion_lang::{Machine, Report, Specification};
use std::collections::BTreeSet;

/// The result of a verification.
#[derive(Debug)]
pub struct Verification {
    /// The machines of the system; one if a single specification is verified.
    pub machines: Vec<VerifiedMachine>,
    /// The properties with their verdicts: those of the specification in their order, then those that all should have.
    pub properties: Vec<CheckedProperty>,
    /// Number of states; 2^64 - 1 if there are more.
    pub states: u64,
    /// Number of transitions that update a location, and of initial states; 2^64 - 1 if there are more.
    pub transitions: u64,
    /// Number of cases, a state with inputs, that an assumption excludes.
    pub excluded: u64,
    /// Texts of the assumptions.
    pub assumptions: Vec<String>,
    /// Inputs without a finite domain, of which a few values stand for all.
    pub represented: Vec<RepresentedInput>,
    /// Number of states in which runs end for some inputs, because every step fails or the script has ended. Temporal properties
    /// consider runs that stay in them for ever. 0 if no property is about paths.
    pub ends: u64,
    /// Greatest number of steps on a shortest path from an initial state.
    pub depth: u32,
    /// The reason for which not all states were explored.
    pub incomplete: Option<Incomplete>,
    /// Locations that take ever new values, if not all states were explored.
    pub growing: Vec<GrowingLocation>,
    /// Names of functions of which locations were left out, since the selected properties do not depend on them. States that differ
    /// only in these are counted once.
    pub left_out: Vec<String>,
    /// Names of the domains whose elements were permuted, with the elements if these are not all. States that permutations make of
    /// each other are then counted once.
    pub symmetric: Vec<String>,
    /// `true` if steps were left out because they lead to the same states in another order: there are fewer states and transitions
    /// than those of the specification.
    pub has_left_out_steps: bool,
    /// Expected number of states that were taken for others, and so were not explored, if only fingerprints of states were stored;
    /// otherwise no state was. Then a verdict holds with a probability only if it is about all states:
    /// see [`CheckedProperty::is_about_all_states`].
    pub expected_missed: Option<f64>,
    /// `true` if the steps were executed in grounded form.
    pub is_grounded: bool,
    /// `true` if the states are those of the verification before, of which only properties differ.
    pub is_reused: bool,
    /// Memory in use for states and transitions at the end of the exploration, in bytes.
    pub memory: u64,
    /// Advice about the specifications, if it was requested and all states were explored.
    pub advice: Vec<SpecificationAdvice>,
    /// `false` if there were too many steps for advice about updates and inputs.
    pub has_advice_on_steps: bool,
    /// The inputs with which states were considered: those that properties mention.
    pub(crate) told_apart: InputFunctions,
}

/// The reason for which a specification cannot be verified.
#[derive(Debug)]
pub struct Refusal {
    /// The specification, for rendering the report.
    pub specification: Box<Specification>,
    /// Errors, at least one.
    pub report: Report,
}

/// Verifies a specification. `proceed` is called now and then during the exploration, and ends it by returning `false`.
///
/// # Errors
/// The initial state cannot be computed, a property is no formula, or an input has too many values.
pub fn verify(
    specification: Specification,
    options: &Options,
    proceed: &mut dyn FnMut(Progress) -> bool,
) -> Result<Verification, Refusal> {
    verify_system(SystemSpecification::of(specification), options, proceed)
}

/// Verifies machines together, with their environment. Inputs that are not connected read the functions of the same names of other
/// machines, and partners that are not linked are the machines of the same names.
///
/// # Errors
/// As [`verify`], or the machines do not fit together.
pub fn verify_system(
    system: SystemSpecification,
    options: &Options,
    proceed: &mut dyn FnMut(Progress) -> bool,
) -> Result<Verification, Refusal> {
    verified(system, options, None, proceed)
}

/// Verifies machines as [`verify_system`] does, one version after another. If only properties differ from the last version, its
/// states are not explored again. The symbolic engine keeps nothing.
///
/// # Errors
/// As [`verify_system`].
pub fn verify_again(
    system: SystemSpecification,
    options: &Options,
    kept: &mut KeptExploration,
    proceed: &mut dyn FnMut(Progress) -> bool,
) -> Result<Verification, Refusal> {
    verified(system, options, Some(kept), proceed)
}

fn verified(
    mut system: SystemSpecification,
    options: &Options,
    kept: Option<&mut KeptExploration>,
    proceed: &mut dyn FnMut(Progress) -> bool,
) -> Result<Verification, Refusal> {
    let prepared = match PreparedSystem::of(&mut system, options) {
        Ok(prepared) => prepared,
        Err((machine, report)) => return Err(refusal(system.machines, machine, report)),
    };
    let PreparedSystem {
        fair,
        properties,
        plan,
        machines,
        assumptions,
        represented,
    } = prepared;
    let kept = kept.map(|kept| (reuse::basis(&machines, &plan, options, &assumptions), kept));
    let exploring = Exploring {
        known: &system.machines,
        properties: &properties,
        options,
        fair: &fair,
    };
    let explored = exploring.whole(&machines, &plan, kept, proceed);
    match explored {
        Ok(explored) => Ok(Verification {
            machines: system.machines,
            assumptions,
            represented,
            ..explored
        }),
        Err((machine, report)) => Err(refusal(system.machines, machine, report)),
    }
}

/// A system that is ready to be explored.
struct PreparedSystem {
    properties: Prepared,
    plan: SystemPlan,
    machines: Vec<Machine>,
    /// Texts of the assumptions.
    assumptions: Vec<String>,
    represented: Vec<RepresentedInput>,
    fair: FairMoves,
}

impl PreparedSystem {
    /// Connects the machines, takes the properties out of their specifications, and determines the values of inputs.
    fn of(system: &mut SystemSpecification, options: &Options) -> Result<Self, (usize, Report)> {
        let mut plan = SystemPlan {
            schedule: system.schedule,
            ..SystemPlan::default()
        };
        match std::mem::take(&mut system.environment) {
            EnvironmentModel::Free => {}
            EnvironmentModel::Hold { changes } => plan.changes = Some(changes),
            EnvironmentModel::Script(script) => plan.script = Some(script),
            EnvironmentModel::Specification(specification) => {
                let mut machine = VerifiedMachine::of(*specification);
                if system.machines.iter().any(|it| it.name == machine.name) {
                    "environment".clone_into(&mut machine.name);
                }
                plan.environment = Some(system.machines.len());
                system.machines.push(machine);
            }
        }
        let observer = ObserverMachine::of(system, options)?;
        plan.observer = observer.machine;
        system.connect_by_name()?;
        if let Some(environment) = plan.environment {
            let checked = system.check_environment(environment);
            checked.map_err(|report| (environment, report))?;
        }
        plan.sources = system.input_sources()?;
        let mut properties = prepare(&mut system.machines, options, &plan.sources, &observer)?;
        let has_limit = options.limits.depth.is_some() || options.limits.states.is_some();
        // assumptions, scripts and cones may leave out the states in which it grows
        let is_whole =
            properties.conditions.assumed.is_empty() && plan.script.is_none() && !options.cone;
        let mut machines = Vec::new();
        for (index, known) in system.machines.iter().enumerate() {
            if !has_limit
                && is_whole
                && let Some(growth) = steady_growth(&known.specification.model)
            {
                return Err((index, report_of(growth.diagnostic())));
            }
            let machine = known.specification.machine();
            let machine =
                machine.map_err(|fault| (index, report_of(known.specification.explain(&fault))))?;
            plan.ranges.push(InputRanges::of_program(&machine));
            plan.names.push(known.name.clone());
            machines.push(machine);
        }
        let mut assumptions = properties.assumptions.clone();
        for content in &options.contents {
            if let Some(machine) = machines.get(content.machine) {
                assumptions.push(content.describe(machine));
            }
        }
        for input in &options.inputs {
            if let (Some(ranges), Some(machine)) = (
                plan.ranges.get_mut(input.machine),
                machines.get(input.machine),
            ) {
                ranges.set(input.function, input.values.clone());
                assumptions.push(restriction(machine, input));
            }
        }
        observer.check_inputs(system, &plan.ranges)?;
        let represented = plan.represent_inputs(&system.machines, &machines)?;
        if let Some(changes) = plan.changes {
            let inputs = if changes == 1 {
                "input changes"
            } else {
                "inputs change"
            };
            assumptions.push(format!(
                "at most {changes} {inputs} from one step to the next"
            ));
        }
        if let Some(script) = &plan.script {
            assumptions.push(format!(
                "the inputs of the script, in {} steps",
                script.len()
            ));
        }
        if plan.environment.is_some() {
            let free = system.free_inputs();
            if !free.is_empty() {
                assumptions.push(format!("any value of {}", free.join(", ")));
            }
        }
        let due = DueFairness::of(&system.machines, &machines, &options.fairness)?;
        assumptions.extend(due.texts);
        properties.has_fairness = !(properties.fairness.is_empty() && due.moves.is_empty());
        let script = plan.script.as_ref();
        plan.messages = MessagePlan::of(
            system,
            &machines,
            options.messages,
            &options.contents,
            script,
        )?;
        assumptions.extend(plan.messages.assumptions());
        properties.has_several_starts = machines.len() > 1 || !plan.is_plain();
        Ok(Self {
            properties,
            plan,
            machines,
            assumptions,
            represented,
            fair: due.moves,
        })
    }
}

/// The result of a verification, with its exploration unless a `KeptExploration` has taken that.
type CheckedSystem = (Verification, Option<Exploration>);

/// The subject of an exploration.
struct Exploring<'a> {
    known: &'a [VerifiedMachine],
    properties: &'a Prepared,
    options: &'a Options,
    fair: &'a FairMoves,
}

impl Exploring<'_> {
    /// Checks the properties, and those whose verdicts depend on which inputs the others mention once more without these.
    fn whole(
        &self,
        machines: &[Machine],
        plan: &SystemPlan,
        kept: Option<(String, &mut KeptExploration)>,
        proceed: &mut dyn FnMut(Progress) -> bool,
    ) -> Result<Verification, (usize, Report)> {
        let (basis, mut kept) = kept.unzip();
        let basis = basis.unwrap_or_default();
        let whole = kept.as_deref_mut().map(|kept| (basis.clone(), kept));
        let (mut found, mut exploration) = self.checked(machines, plan, whole, proceed)?;
        if found.incomplete.is_some() {
            return Ok(found);
        }
        let is_wanted = |index: &usize| {
            let property = self.properties.properties.get(*index);
            property.is_some_and(|it| it.is_wanted(&self.options.only))
        };
        let alone = self.properties.verified_alone(
            &found.told_apart,
            machines,
            found.ends > 0,
            !self.fair.is_empty(),
        );
        let alone: Vec<usize> = alone.into_iter().filter(is_wanted).collect();
        for group in self.properties.groups(&alone) {
            let Some(properties) = self.properties.alone(&group) else {
                continue;
            };
            let texts = properties.properties.iter().map(|it| it.text.clone());
            let options = Options {
                only: texts.collect(),
                advice: false,
                ..self.options.clone()
            };
            let exploring = Exploring {
                properties: &properties,
                options: &options,
                ..*self
            };
            let mut known;
            let states = match (kept.as_deref_mut(), exploration.take()) {
                _ if !properties.mentions_no_inputs() => None,
                (Some(kept), _) => Some(kept.without_inputs()),
                (None, found) => {
                    known = found
                        .and_then(Exploration::without_inputs)
                        .map(|it| KeptExploration::of(&basis, it));
                    known.as_mut()
                }
            };
            let states = states.map(|states| (basis.clone(), states));
            let (of_group, _) = exploring.checked(machines, plan, states, proceed)?;
            for checked in of_group.properties {
                let mut known = found.properties.iter_mut();
                let known = known.find(|it| {
                    it.machine == checked.machine
                        && it.place == checked.place
                        && (&it.kind, &it.text) == (&checked.kind, &checked.text)
                });
                if let Some(known) = known {
                    *known = checked;
                    // the states that all properties share are complete
                    known.notes.extend(of_group.incomplete.map(Note::Undecided));
                }
            }
        }
        Ok(found)
    }

    /// Checks the properties with the engine of the options.
    fn checked(
        &self,
        machines: &[Machine],
        plan: &SystemPlan,
        kept: Option<(String, &mut KeptExploration)>,
        proceed: &mut dyn FnMut(Progress) -> bool,
    ) -> Result<CheckedSystem, (usize, Report)> {
        let is_single = machines.len() == 1 && plan.is_plain();
        #[cfg(feature = "symbolic")]
        let is_symbolic = self.options.engine == Engine::Symbolic;
        match (machines, plan.ranges.first()) {
            #[cfg(feature = "symbolic")]
            ([machine], Some(ranges))
                if is_single && is_symbolic && self.fair.is_empty() && !self.options.advice =>
            {
                let found = self.symbolic(machine, ranges, proceed)?;
                Ok((found, None))
            }
            #[cfg(feature = "symbolic")]
            _ if is_symbolic => {
                let construct = match (self.options.advice, self.fair.is_empty()) {
                    (true, _) => "advice, which is about single states",
                    (false, false) => "fairness of rules and agents",
                    (false, true) => "a system of several machines, an environment or messages",
                };
                let first = self.known.first();
                let report = first.map(|it| crate::symbolic::refuse(&it.specification, construct));
                Err((0, report.unwrap_or_default()))
            }
            ([machine], Some(ranges)) if is_single => {
                let machine = machine.clone();
                self.run(SingleMachine { machine, ranges }, kept, proceed)
            }
            _ => self.run(MachineSystem::new(plan, machines.to_vec()), kept, proceed),
        }
    }

    /// Explores a system and checks the properties.
    fn run<S: TransitionSystem>(
        &self,
        system: S,
        kept: Option<(String, &mut KeptExploration)>,
        proceed: &mut dyn FnMut(Progress) -> bool,
    ) -> Result<CheckedSystem, (usize, Report)> {
        self.run_in(
            &system,
            (self.cone(), self.options.independent),
            kept,
            proceed,
        )
    }

    /// Explores a system and checks the properties, in their cone of influence if there is one. Leaves out the orders of independent
    /// steps if `independent` is set.
    fn run_in<S: TransitionSystem>(
        &self,
        system: &S,
        (cone, independent): (Option<BTreeSet<usize>>, bool),
        mut kept: Option<(String, &mut KeptExploration)>,
        proceed: &mut dyn FnMut(Progress) -> bool,
    ) -> Result<CheckedSystem, (usize, Report)> {
        let conditions = &self.properties.conditions;
        let reused = kept.as_mut().and_then(|(basis, kept)| {
            kept.reused(basis, system, conditions, self.properties.needs_graph())
        });
        let is_reused = reused.is_some();
        let exploration = match reused {
            Some(exploration) => exploration,
            None => {
                let keeps_edges = kept.is_some() || self.properties.needs_graph();
                if let Some((_, kept)) = &mut kept {
                    kept.explored();
                }
                let reductions = (cone, independent);
                let explored = self.explore(system, reductions, keeps_edges, proceed);
                explored.map_err(|error| self.explain(system, &error))?
            }
        };
        if exploration.initial == 0 {
            return Err((0, self.nothing_assumed()));
        }
        let replay = Replay {
            machines: self.known,
            exploration: &exploration,
            system,
            fair: self.fair,
            keeps_states: self.options.keeps_states,
        };
        let deciding = Deciding::new(&exploration, self.options.limits.memory, &mut *proceed);
        let properties = verdicts(self.properties, &replay, &self.options.only, &deciding)
            .map_err(|error| (0, report_of(error.diagnostic())))?;
        // A step of the specification makes the same updates in the cone as a step there, unless it fails. What holds in all states of
        // the cone therefore holds in all states; a run in the cone may not be one of the specification.
        let is_shown = |property: &CheckedProperty| property.verdict.run().is_some();
        let is_part = !exploration.left_out.is_empty() || exploration.has_left_out_steps;
        if is_part && properties.iter().any(is_shown) {
            // shown by the simplest of all runs
            return self.run_in(system, (None, false), kept, proceed);
        }
        let has_advice = self.options.advice && !exploration.stands_for_others();
        let (advice, has_advice_on_steps) = if has_advice && exploration.incomplete.is_none() {
            advice(system, &exploration, self.known, self.properties)
        } else {
            (Vec::new(), true)
        };
        let growing = if exploration.incomplete.is_some() && !exploration.stands_for_others() {
            growing_locations(system, &exploration, self.known)
        } else {
            Vec::new()
        };
        // in a cone, no property is about paths, and transitions are not kept
        let has_paths = self.properties.needs_graph()
            && exploration.keeps_edges
            && exploration.incomplete.is_none();
        let ends = if has_paths { exploration.ends() } else { 0 };
        let states = exploration.state_count();
        // the search for runs and locations may have read what cannot be read
        let checked = exploration.check_storage();
        checked.map_err(|error| self.explain(system, &error))?;
        let is_compact = exploration.is_compact();
        let verification = Verification {
            symmetric: exploration.symmetric.clone(),
            left_out: exploration.left_out.clone(),
            has_left_out_steps: exploration.has_left_out_steps,
            expected_missed: is_compact.then(|| expected_missed(states)),
            machines: Vec::new(),
            properties,
            states,
            transitions: exploration.transitions,
            excluded: exploration.excluded,
            assumptions: Vec::new(),
            represented: Vec::new(),
            ends,
            depth: exploration.depth(),
            incomplete: exploration.incomplete,
            growing,
            is_grounded: exploration.words.is_some(),
            is_reused,
            memory: exploration.memory(),
            advice,
            has_advice_on_steps,
            told_apart: exploration.told_apart(),
        };
        let exploration = match kept {
            Some((basis, kept)) => {
                kept.keep(basis, exploration);
                None
            }
            None => Some(exploration),
        };
        Ok((verification, exploration))
    }

    /// Returns the conditions of the selected properties, if these are about single states and locations may be left out. The general
    /// properties are about all locations, so that they must not be selected.
    fn cone(&self) -> Option<BTreeSet<usize>> {
        let only = self.options.only.as_slice();
        // advice is about all locations
        if !self.options.cone || self.options.advice || only.is_empty() {
            return None;
        }
        let mut conditions = BTreeSet::new();
        let properties = self.properties.properties.iter();
        for property in properties.filter(|it| it.is_wanted(only)) {
            self.properties.of_nodes(property)?;
            visit_conditions(&property.formula, &mut |index| {
                conditions.insert(index);
            });
            conditions.extend(&property.antecedents);
        }
        Some(conditions)
    }

    /// Explores a system, in its grounded form if it has one.
    fn explore<S: TransitionSystem>(
        &self,
        system: &S,
        (cone, independent): (Option<BTreeSet<usize>>, bool),
        keeps_edges: bool,
        proceed: &mut dyn FnMut(Progress) -> bool,
    ) -> Result<Exploration, ExplorationError> {
        let conditions = &self.properties.conditions;
        let mut options = ExplorationOptions {
            cone,
            limits: self.options.limits,
            keeps_edges,
            threads: self.options.threads.max(1),
            storage: storage_of(&self.options.storage),
            symmetry: self.options.symmetry,
            // advice is about all steps
            independent: independent && !self.options.advice,
        };
        if !self.options.without_grounding {
            if options.cone.is_some() {
                options.keeps_edges = false;
                let part = grounded::explore(system, conditions, &options, self.fair, proceed)?;
                if let Some(exploration) = part {
                    return Ok(exploration);
                }
                options.cone = None;
                options.keeps_edges = self.properties.needs_graph();
            }
            let grounded = grounded::explore(system, conditions, &options, self.fair, proceed)?;
            if let Some(exploration) = grounded {
                return Ok(exploration);
            }
        }
        Explorer::new(system.clone(), conditions, &options, self.fair).run(proceed)
    }

    /// Explores a specification with decision diagrams.
    #[cfg(feature = "symbolic")]
    fn symbolic(
        &self,
        machine: &Machine,
        ranges: &InputRanges,
        proceed: &mut dyn FnMut(Progress) -> bool,
    ) -> Result<Verification, (usize, Report)> {
        let symbolic = crate::symbolic::Symbolic {
            known: self.known,
            properties: self.properties,
            options: self.options,
            machine,
            ranges,
            fair: self.fair,
        };
        let found = symbolic.run(proceed).map_err(|report| (0, report))?;
        if !found.has_initial {
            return Err((0, self.nothing_assumed()));
        }
        Ok(Verification {
            machines: Vec::new(),
            properties: found.properties,
            states: found.states,
            transitions: found.transitions,
            excluded: found.excluded,
            assumptions: Vec::new(),
            represented: Vec::new(),
            ends: found.ends,
            depth: found.depth,
            incomplete: found.incomplete,
            growing: Vec::new(),
            symmetric: Vec::new(),
            has_left_out_steps: false,
            left_out: Vec::new(),
            expected_missed: None,
            advice: Vec::new(),
            has_advice_on_steps: false,
            is_grounded: false,
            is_reused: false,
            memory: found.memory,
            told_apart: self.properties.all_inputs(),
        })
    }

    /// Describes assumptions that exclude all initial states.
    fn nothing_assumed(&self) -> Report {
        let at = self.known.first().map(|it| main_rule(&it.specification));
        let finding = NothingAssumed {
            assumptions: self.properties.assumptions.clone(),
            at: at.unwrap_or_default(),
        };
        report_of(finding.diagnostic())
    }

    fn explain<S: TransitionSystem>(
        &self,
        system: &S,
        error: &ExplorationError,
    ) -> (usize, Report) {
        let (index, fault) = match error {
            ExplorationError::Input(fault) | ExplorationError::Initial(fault) => {
                (fault.machine, Some(fault))
            }
            ExplorationError::Alternatives | ExplorationError::Storage(_) => (0, None),
        };
        let Some(known) = self.known.get(index) else {
            return (index, Report::new());
        };
        let specification = &known.specification;
        let diagnostic = match (error, fault, system.machines().get(index)) {
            (ExplorationError::Input(_), Some(fault), Some(machine))
                if fault.is_of_unbounded_input() =>
            {
                fault
                    .step()
                    .map(|fault| InputWithoutRange::of(specification, machine, fault).diagnostic())
            }
            (_, Some(fault), _) => Some(fault.diagnostic(specification, None)),
            (ExplorationError::Storage(reason), None, _) => {
                let failure = StorageFailure {
                    reason: reason.clone(),
                    at: main_rule(specification),
                };
                Some(failure.diagnostic())
            }
            (_, None, _) => Some(TooManyAlternatives::of(specification).diagnostic()),
        };
        (index, diagnostic.map(report_of).unwrap_or_default())
    }
}

/// Describes the values of an input.
fn restriction(machine: &Machine, input: &InputValues) -> String {
    let naming = machine.naming();
    let values = input
        .values
        .iter()
        .map(|value| value.show(&naming).to_string());
    let names = &machine.program().symbols.functions;
    let name = names
        .get(input.function.0 as usize)
        .map_or("", |name| &**name);
    format!(
        "{name} in {{{}}}",
        values.collect::<Vec<String>>().join(", ")
    )
}

fn refusal(mut machines: Vec<VerifiedMachine>, machine: usize, report: Report) -> Refusal {
    let machine = machine.min(machines.len().saturating_sub(1));
    Refusal {
        specification: Box::new(machines.swap_remove(machine).specification),
        report,
    }
}

fn storage_of(storage: &Storage) -> StateStorage {
    match storage {
        Storage::Exact => StateStorage::Memory,
        Storage::Compact => StateStorage::Fingerprints,
        Storage::Disk(space) => StateStorage::Files(Spill::new(space.clone())),
    }
}
