//! The expansion of a program in its initial state.

use crate::known::KnownTerm;
use crate::program::{
    FAULT, GroundProgram, GroundRule, GroundTerm, InputVariable, Permitted, Sort, StateVariable,
};
use crate::ranges;
use asmotion_ir::{
    AssignTarget, BodyId, DomainElements, DomainId, Function, FunctionId, FunctionKind, Program,
    Rule, RuleNode, Slot, Storage, ValueShape,
};
use asmotion_value::Value;
use std::collections::{BTreeMap, BTreeSet};

/// Limit for the parts of a grounded program.
const MAX_PARTS: usize = 400_000;

/// Limit for the parts of terms that are copied: an argument stands in each place where its parameter is used, so that nested calls
/// multiply it.
const MAX_COPIED: usize = 2_000_000;

/// Limit for nested calls during grounding; deeper ones are left to a machine.
const MAX_NESTED: usize = 200;

/// The program is too large for grounding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooLarge;

/// Inputs of grounding besides the program.
pub struct GroundingContext<'a> {
    /// The program. Its initial state must not depend on inputs.
    pub program: &'a Program,
    /// The values of all slots in the initial state.
    pub initial: &'a [Value],
    /// The elements of each domain in the initial state, in ascending order.
    pub extent: &'a dyn Fn(DomainId) -> Vec<Value>,
    /// The possible values of a monitored function, in the order in which they are tried; `None` if they are not enumerated.
    pub inputs: &'a dyn Fn(FunctionId) -> Option<Vec<Value>>,
}

/// Grounds the main rule and the added terms of a program.
///
/// A grounded program describes the steps in all states that differ from the initial one in its variables alone. A step that
/// changes anything else, which only a machine can execute, leads out of them.
///
/// # Errors
/// The grounded program would be too large.
pub fn ground(context: &GroundingContext<'_>) -> Result<GroundProgram, TooLarge> {
    let program = context.program;
    let mut grounding = Grounding {
        context,
        variables: Vec::new(),
        variable_of: BTreeMap::new(),
        inputs: Vec::new(),
        input_of: BTreeMap::new(),
        written: written_functions(program),
        parts: 0,
        copied: 0,
        depth: 0,
        agent: KnownTerm::Value(Value::Undef),
    };
    grounding.declare_variables();
    let rule = match program.main {
        Some(main) => grounding.routine(main, Vec::new()),
        None => GroundRule::Machine,
    };
    let conditions = program.added_terms.iter();
    let conditions = conditions.map(|body| grounding.condition(*body));
    let conditions: Vec<GroundTerm> = conditions.collect();
    if grounding.parts > MAX_PARTS {
        return Err(TooLarge);
    }
    let mut grounded = GroundProgram {
        variables: grounding.variables,
        inputs: grounding.inputs,
        rule,
        conditions,
        counters: program.counted.len(),
    };
    ranges::estimate(&mut grounded);
    Ok(grounded)
}

/// A grounding in progress.
pub(crate) struct Grounding<'a> {
    pub context: &'a GroundingContext<'a>,
    pub variables: Vec<StateVariable>,
    variable_of: BTreeMap<Slot, u32>,
    pub inputs: Vec<InputVariable>,
    input_of: BTreeMap<(FunctionId, Vec<Value>), u32>,
    /// The functions that rules update.
    written: BTreeSet<FunctionId>,
    /// Number of parts so far.
    pub parts: usize,
    /// Number of copied parts so far.
    copied: usize,
    /// Depth of nested calls.
    depth: usize,
    /// The running agent.
    pub agent: KnownTerm,
}

impl Grounding<'_> {
    pub fn function(&self, function: FunctionId) -> Option<&Function> {
        self.context.program.functions.get(function.0 as usize)
    }

    /// Returns `true`, and counts the part, unless the grounded program is too large already.
    pub fn has_room(&mut self) -> bool {
        self.parts += 1;
        self.parts <= MAX_PARTS
    }

    /// Returns `true`, and counts the parts of a term that is about to be copied, unless the grounded program would be too large.
    pub fn may_copy(&mut self, term: &KnownTerm) -> bool {
        let mut waiting = vec![term];
        let mut parts = Vec::new();
        while let Some(known) = waiting.pop() {
            match known {
                KnownTerm::Term(term, _) => parts.push(term),
                KnownTerm::Tuple(items) => waiting.extend(items),
                KnownTerm::Value(_) | KnownTerm::Unknown => {}
            }
        }
        while let Some(part) = parts.pop() {
            self.copied += 1;
            if self.copied > MAX_COPIED {
                // nothing has room any more
                self.parts = MAX_PARTS + 1;
                return false;
            }
            parts.extend(part.parts());
        }
        true
    }

    /// Executes `work` one call deeper; `None` if calls are nested too deeply.
    pub fn nested<T>(&mut self, work: impl FnOnce(&mut Self) -> T) -> Option<T> {
        if self.depth >= MAX_NESTED {
            return None;
        }
        self.depth += 1;
        let done = stacker::maybe_grow(128 * 1024, 1024 * 1024, || work(self));
        self.depth -= 1;
        Some(done)
    }

    fn condition(&mut self, body: BodyId) -> GroundTerm {
        self.call(body, Vec::new()).of_sort(Sort::Bool)
    }

    /// Makes a variable of each location of the functions that rules update and whose values are scalars.
    fn declare_variables(&mut self) {
        let written: Vec<FunctionId> = self.written.iter().copied().collect();
        for id in written {
            let Some(function) = self.function(id) else {
                continue;
            };
            let is_state = matches!(function.kind, FunctionKind::Controlled | FunctionKind::Out);
            let Storage::Dense {
                base,
                count,
                lazy: false,
                ..
            } = function.storage
            else {
                continue;
            };
            let is_reserved = (base..base + count).contains(&self.context.program.result);
            if !is_state || is_reserved || function.open {
                continue;
            }
            let Some((sort, permitted)) = self.values_of(function) else {
                continue;
            };
            let new = (base..base.saturating_add(count)).map(|slot| {
                let value = self.context.initial.get(slot as usize)?;
                let (known, initial) = Sort::number(value)?;
                known
                    .is_none_or(|known| known == sort)
                    .then(|| StateVariable {
                        slot,
                        function: id,
                        sort,
                        initial,
                        permitted: permitted.clone(),
                        range: (initial, initial),
                        is_bounded: false,
                        // until the updates are known
                        may_be_undef: true,
                    })
            });
            // a function with an initial value of another kind is left to the machine
            let Some(new) = new.collect::<Option<Vec<StateVariable>>>() else {
                continue;
            };
            self.variables.extend(new);
        }
        self.variables.sort_by_key(|variable| variable.slot);
        let numbered = self.variables.iter().zip(0..);
        self.variable_of = numbered.map(|(it, index)| (it.slot, index)).collect();
    }

    /// Returns the sort of a function's values, and which of them updates may give it.
    fn values_of(&self, function: &Function) -> Option<(Sort, Permitted)> {
        let (sort, all) = match &function.codomain {
            ValueShape::Bool => (Sort::Bool, Permitted::Between(0, 1)),
            ValueShape::Int | ValueShape::Natural => (Sort::Int, Permitted::All),
            ValueShape::Domain(domain) => self.elements_of(*domain)?,
            ValueShape::Real
            | ValueShape::Char
            | ValueShape::Text
            | ValueShape::Complex
            | ValueShape::Rule
            | ValueShape::Tuple(_)
            | ValueShape::Seq(_)
            | ValueShape::Set(_)
            | ValueShape::Bag(_)
            | ValueShape::Map(..)
            | ValueShape::Any => return None,
        };
        match function.within {
            // a domain that static types already guarantee
            None if sort == Sort::Int => Some((sort, Permitted::All)),
            None => Some((sort, all)),
            Some(domain) => {
                let (checked, permitted) = self.elements_of(domain)?;
                (checked == sort).then_some((sort, permitted))
            }
        }
    }

    /// Returns the numbers of a domain's elements.
    fn elements_of(&self, domain: DomainId) -> Option<(Sort, Permitted)> {
        match self
            .context
            .program
            .domains
            .get(domain.0 as usize)?
            .elements
        {
            DomainElements::Ints { low, high } => {
                (low > FAULT).then_some((Sort::Int, Permitted::Between(low, high)))
            }
            DomainElements::Atoms { first, count } => {
                let first = i64::from(first.0);
                let last = first + i64::from(count) - 1;
                Some((Sort::Atom, Permitted::Between(first, last)))
            }
            DomainElements::Computed(_) => {
                let extent = (self.context.extent)(domain);
                let mut numbers = Vec::new();
                let mut sorts = BTreeSet::new();
                for value in &extent {
                    let (sort, number) = Sort::number(value)?;
                    sorts.insert(sort?);
                    numbers.push(number);
                }
                numbers.sort_unstable();
                let sort = *sorts.first()?;
                (sorts.len() == 1).then_some((sort, Permitted::Listed(numbers)))
            }
            DomainElements::Undefined | DomainElements::Open => None,
        }
    }

    /// Returns the value of a location whose slot is known.
    pub fn location(&mut self, function: FunctionId, slot: Slot) -> KnownTerm {
        if let Some(&index) = self.variable_of.get(&slot) {
            let sort = self.variables.get(index as usize).map(|it| it.sort);
            return sort.map_or(KnownTerm::Unknown, |sort| {
                KnownTerm::Term(GroundTerm::Variable(index), sort)
            });
        }
        let Some(declared) = self.function(function) else {
            return KnownTerm::Unknown;
        };
        match declared.kind {
            FunctionKind::Monitored => self.input(function, slot),
            FunctionKind::Controlled | FunctionKind::Out
                if !self.written.contains(&function) && slot < self.context.program.eager =>
            {
                let value = self.context.initial.get(slot as usize);
                value.cloned().map_or(KnownTerm::Unknown, KnownTerm::Value)
            }
            FunctionKind::Controlled
            | FunctionKind::Out
            | FunctionKind::Shared
            | FunctionKind::Local
            | FunctionKind::Fixed => KnownTerm::Unknown,
        }
    }

    fn input(&mut self, function: FunctionId, slot: Slot) -> KnownTerm {
        let Some(arguments) = self.arguments(function, slot) else {
            return KnownTerm::Unknown;
        };
        let key = (function, arguments);
        if let Some(&index) = self.input_of.get(&key) {
            let sort = self.inputs.get(index as usize).map(|it| it.sort);
            return sort.map_or(KnownTerm::Unknown, |sort| {
                KnownTerm::Term(GroundTerm::Input(index), sort)
            });
        }
        let Some((sort, values)) = self.input_values(function) else {
            return KnownTerm::Unknown;
        };
        let index = self.inputs.len() as u32;
        self.inputs.push(InputVariable {
            function,
            arguments: key.1.clone(),
            sort,
            values,
        });
        self.input_of.insert(key, index);
        KnownTerm::Term(GroundTerm::Input(index), sort)
    }

    /// Returns the possible numbers of an input. `None` if they are unknown, or if a value is a fault.
    fn input_values(&self, function: FunctionId) -> Option<(Sort, Vec<i64>)> {
        let declared = self.function(function)?;
        let (expected, permitted) = self.values_of(declared)?;
        let values = (self.context.inputs)(function)?;
        let numbers = values.iter().map(|value| {
            let (sort, number) = Sort::number(value)?;
            let fits = sort.is_none_or(|sort| sort == expected) && permitted.accepts(number);
            fits.then_some(number)
        });
        let numbers = numbers.collect::<Option<Vec<i64>>>()?;
        (!numbers.is_empty() && declared.clock.is_none() && declared.mail.is_none())
            .then_some((expected, numbers))
    }

    /// Returns the arguments of a dense location.
    fn arguments(&self, function: FunctionId, slot: Slot) -> Option<Vec<Value>> {
        let Storage::Dense {
            base, count, axes, ..
        } = &self.function(function)?.storage
        else {
            return None;
        };
        let index = slot.checked_sub(*base).filter(|index| index < count)?;
        let argument = |axis: &asmotion_ir::SlotAxis| {
            axis.over.argument(index / axis.stride % axis.over.count())
        };
        Some(axes.iter().map(argument).collect())
    }

    /// Returns the number of the variable at a slot.
    pub fn variable(&self, slot: Slot) -> Option<u32> {
        self.variable_of.get(&slot).copied()
    }
}

/// Returns the functions that rules update.
fn written_functions(program: &Program) -> BTreeSet<FunctionId> {
    let mut written = BTreeSet::new();
    for routine in &program.routines {
        collect_written(&routine.code, &mut written);
    }
    written
}

fn collect_written(rule: &Rule, written: &mut BTreeSet<FunctionId>) {
    let mut all = |rules: &[&Rule]| {
        stacker::maybe_grow(64 * 1024, 1024 * 1024, || {
            rules.iter().for_each(|rule| collect_written(rule, written));
        });
    };
    match &*rule.node {
        RuleNode::Update(target, _) | RuleNode::Assign(Some(target), ..) => match target {
            AssignTarget::Slot(function, _) | AssignTarget::Location(function, _) => {
                written.insert(*function);
            }
            AssignTarget::Local(_) => {}
        },
        RuleNode::Skip
        | RuleNode::Assign(None, ..)
        | RuleNode::Call(..)
        | RuleNode::Run(..)
        | RuleNode::RunAgent(..)
        | RuleNode::Act(..) => {}
        RuleNode::Par(rules) | RuleNode::Seq(rules) => {
            all(&rules.iter().collect::<Vec<&Rule>>());
        }
        RuleNode::If(_, then, otherwise) | RuleNode::Choose(_, _, then, otherwise) => {
            all(&[then, otherwise]);
        }
        RuleNode::Switch(_, cases, otherwise) => {
            let cases = cases.iter().map(|(_, rule)| rule);
            all(&cases.chain([otherwise]).collect::<Vec<&Rule>>());
        }
        RuleNode::Local { initial, body, .. } => {
            all(&initial.iter().chain([body]).collect::<Vec<&Rule>>());
        }
        RuleNode::Forall(_, _, body)
        | RuleNode::Let(_, body)
        | RuleNode::Extend(_, _, body)
        | RuleNode::While { body, .. }
        | RuleNode::Draw(_, body)
        | RuleNode::Counted(_, body)
        | RuleNode::Watched(body) => all(&[body]),
    }
}
