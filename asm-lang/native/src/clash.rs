//! Analysis of clashes: the functions whose locations no step updates twice.
//!
//! Two executions of updates can meet in a step unless they lie on different branches of a rule. They update different
//! locations if an argument differs: two constants, or two sums of the same variable and different constants. Executions in
//! different iterations of a `forall` differ if an argument is the variable of the loop plus the same constant in both.

use crate::atoms::{AtomRange, routine_of};
use crate::limits::{MAX_INLINED, MAX_RULES};
use asmotion_ir::{
    Arithmetic, AssignTarget, AxisRange, Binder, BinderRange, DomainElements, FunctionId, Program,
    RoutineId, Rule, RuleNode, Slot, Storage, Term, TermNode,
};
use asmotion_value::Value;

/// Limit for the number of updates of one function.
const MAX_SITES: usize = 1_000;

/// Facts that an analysis has proved of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Known {
    Constant(i64),
    /// A variable, by number, plus a constant.
    Sum(usize, i64),
    Nothing,
}

/// A step on the way from the main rule to an update.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Passage {
    /// A branch of a rule; both by number.
    Branch(usize, usize),
    /// A loop, by the numbers of its variables.
    Loop(Vec<usize>),
    /// An outermost sequence, by number. Its updates override each other.
    Sequence(usize),
}

/// An update in the rules, with the calls and loops around it.
struct UpdateSite {
    function: FunctionId,
    arguments: Vec<Known>,
    path: Vec<Passage>,
}

/// The result of the analysis.
pub(crate) struct ClashAnalysis {
    /// Indexed by function, `true` if no step of the main rule updates a location of the function twice. Covers the updates
    /// that native code inlines; others are left to closures.
    pub free: Vec<bool>,
    /// Number of rules, with those of inlined macros; at most [`MAX_RULES`].
    pub rules: usize,
}

/// Analyses the main rule of a program.
pub(crate) fn analysed(program: &Program, main: RoutineId) -> ClashAnalysis {
    let mut search = ClashSearch {
        program,
        sites: Vec::new(),
        path: Vec::new(),
        inlined: Vec::new(),
        variables: Vec::new(),
        branches: 0,
        visited: 0,
    };
    search.routine(main, Vec::new(), Known::Nothing);
    let mut free = vec![search.visited < MAX_RULES; program.functions.len()];
    let mut by_function: Vec<Vec<&UpdateSite>> = vec![Vec::new(); program.functions.len()];
    for site in &search.sites {
        by_function[site.function.0 as usize].push(site);
    }
    for (free, sites) in free.iter_mut().zip(&by_function) {
        *free &= sites.len() <= MAX_SITES && are_apart(sites);
    }
    ClashAnalysis {
        free,
        rules: search.visited,
    }
}

fn are_apart(sites: &[&UpdateSite]) -> bool {
    sites.iter().enumerate().all(|(index, site)| {
        let mut others = sites.iter().skip(index + 1);
        is_apart_from_itself(site) && others.all(|other| is_apart(site, other))
    })
}

/// Returns `true` if executions of an update in different iterations have different locations.
fn is_apart_from_itself(site: &UpdateSite) -> bool {
    let mut loops = site.path.iter().flat_map(Passage::variables);
    loops.all(|variable| {
        let mut arguments = site.arguments.iter();
        arguments.any(|argument| matches!(argument, Known::Sum(known, _) if known == variable))
    })
}

fn is_apart(one: &UpdateSite, other: &UpdateSite) -> bool {
    let pairs = || one.arguments.iter().zip(&other.arguments);
    let is_other_constant = |(one, other): (&Known, &Known)| matches!((one, other), (Known::Constant(one), Known::Constant(other)) if one != other);
    if pairs().any(is_other_constant) {
        return true;
    }
    let shared = one.path.iter().zip(&other.path);
    let shared = shared.take_while(|(one, other)| one == other).count();
    let around = || one.path.iter().take(shared);
    let mut loops = around().flat_map(Passage::variables);
    let is_sequence = around().any(|passage| matches!(passage, Passage::Sequence(_)));
    if is_sequence && loops.next().is_none() {
        return true;
    }
    let mut loops = around().flat_map(Passage::variables);
    let is_told_by = |variable: &usize| {
        pairs().any(|(one, other)| {
            one == other && matches!(one, Known::Sum(known, _) if known == variable)
        })
    };
    if !loops.all(is_told_by) {
        return false;
    }
    // the same iteration of all loops around both
    let is_exclusive = matches!(
        (one.path.get(shared), other.path.get(shared)),
        (Some(Passage::Branch(one, _)), Some(Passage::Branch(other, _))) if one == other
    );
    is_exclusive
        || pairs().any(|(one, other)| {
            matches!((one, other), (Known::Sum(one, by), Known::Sum(other, other_by))
                if one == other && by != other_by)
        })
}

impl Passage {
    fn variables(&self) -> &[usize] {
        match self {
            Self::Branch(..) | Self::Sequence(_) => &[],
            Self::Loop(variables) => variables,
        }
    }
}

/// The search for updates, in the rules that native code inlines.
struct ClashSearch<'a> {
    program: &'a Program,
    sites: Vec<UpdateSite>,
    path: Vec<Passage>,
    inlined: Vec<RoutineId>,
    /// The range of atoms of each variable, if known.
    variables: Vec<Option<AtomRange>>,
    branches: usize,
    visited: usize,
}

impl ClashSearch<'_> {
    fn routine(&mut self, routine: RoutineId, mut locals: Vec<Known>, agent: Known) {
        let program = self.program;
        let Some(called) = program.routines.get(routine.0 as usize) else {
            return;
        };
        if self.inlined.contains(&routine) || self.inlined.len() >= MAX_INLINED {
            return;
        }
        locals.resize(called.locals as usize, Known::Nothing);
        self.inlined.push(routine);
        self.rule(&called.code, &mut locals, agent);
        self.inlined.pop();
    }

    fn rule(&mut self, rule: &Rule, locals: &mut Vec<Known>, agent: Known) {
        stacker::maybe_grow(64 * 1024, 1024 * 1024, || {
            self.rule_here(rule, locals, agent);
        });
    }

    fn rule_here(&mut self, rule: &Rule, locals: &mut Vec<Known>, agent: Known) {
        self.visited += 1;
        if self.visited >= MAX_RULES {
            return;
        }
        match &*rule.node {
            RuleNode::Update(place, _) => self.site(place, locals, agent),
            RuleNode::Par(rules) => {
                for rule in rules {
                    self.rule(rule, locals, agent);
                }
            }
            RuleNode::If(_, then, otherwise) => {
                self.branches([then, otherwise], locals, agent);
            }
            RuleNode::Switch(_, cases, otherwise) => {
                let cases = cases.iter().map(|(_, case)| case);
                self.branches(cases.chain([otherwise]), locals, agent);
            }
            RuleNode::Choose(binders, _, body, ifnone) => {
                let _ = self.bind(binders, locals);
                self.branches([body, ifnone], locals, agent);
            }
            RuleNode::Forall(binders, _, body) => {
                let variables = self.bind(binders, locals);
                self.path.push(Passage::Loop(variables));
                self.rule(body, locals, agent);
                self.path.pop();
            }
            RuleNode::Let(bindings, body) => {
                for (local, term) in bindings {
                    let value = known(term, locals, agent);
                    if let Some(local) = locals.get_mut(*local as usize) {
                        *local = value;
                    }
                }
                self.rule(body, locals, agent);
            }
            RuleNode::Call(routine, arguments) => {
                let arguments = arguments.iter().map(|term| known(term, locals, agent));
                self.routine(*routine, arguments.collect(), agent);
            }
            RuleNode::RunAgent(term, _) => {
                let agent = known(term, locals, agent);
                if let Some(routine) = self.program_of(agent) {
                    self.routine(routine, Vec::new(), agent);
                }
            }
            RuleNode::Counted(_, rule) => self.rule(rule, locals, agent),
            RuleNode::While { body, .. } => self.sequence([body], locals, agent),
            RuleNode::Seq(rules) => self.sequence(rules, locals, agent),
            RuleNode::Skip
            | RuleNode::Assign(..)
            | RuleNode::Run(..)
            | RuleNode::Extend(..)
            | RuleNode::Watched(_)
            | RuleNode::Local { .. }
            | RuleNode::Draw(..)
            | RuleNode::Act(..) => {}
        }
    }

    fn sequence<'r>(
        &mut self,
        rules: impl IntoIterator<Item = &'r Rule>,
        locals: &mut Vec<Known>,
        agent: Known,
    ) {
        let is_inner = |passage: &Passage| matches!(passage, Passage::Sequence(_));
        let is_outermost = !self.path.iter().any(is_inner);
        if is_outermost {
            self.branches += 1;
            self.path.push(Passage::Sequence(self.branches));
        }
        for rule in rules {
            self.rule(rule, locals, agent);
        }
        if is_outermost {
            self.path.pop();
        }
    }

    fn branches<'r>(
        &mut self,
        rules: impl IntoIterator<Item = &'r Rule>,
        locals: &mut Vec<Known>,
        agent: Known,
    ) {
        self.branches += 1;
        let number = self.branches;
        for (branch, rule) in rules.into_iter().enumerate() {
            self.path.push(Passage::Branch(number, branch));
            self.rule(rule, locals, agent);
            self.path.pop();
        }
    }

    /// Gives new numbers to variables.
    fn bind(&mut self, binders: &[Binder], locals: &mut [Known]) -> Vec<usize> {
        let mut numbers = Vec::new();
        for binder in binders {
            let number = self.variables.len();
            let atoms = match binder.range {
                BinderRange::Atoms(first, count) => Some(AtomRange::Atoms(first, count)),
                BinderRange::Domain(domain) => {
                    let declared = &self.program.domains[domain.0 as usize];
                    match declared.elements {
                        DomainElements::Atoms { .. } if declared.is_extended => {
                            Some(AtomRange::Domain(domain))
                        }
                        DomainElements::Atoms { first, count } => {
                            Some(AtomRange::Atoms(first.0, count))
                        }
                        DomainElements::Ints { .. }
                        | DomainElements::Computed(_)
                        | DomainElements::Undefined
                        | DomainElements::Open => None,
                    }
                }
                BinderRange::Ints(..) | BinderRange::Bools | BinderRange::Elements(_) => None,
            };
            self.variables.push(atoms);
            if let Some(local) = locals.get_mut(binder.local as usize) {
                *local = Known::Sum(number, 0);
            }
            numbers.push(number);
        }
        numbers
    }

    /// Returns the only routine that can be the program of an agent.
    fn program_of(&self, agent: Known) -> Option<RoutineId> {
        let agents = match agent {
            Known::Constant(atom) => AtomRange::Atoms(u32::try_from(atom).ok()?, 1),
            Known::Sum(variable, 0) => self.variables.get(variable).copied()??,
            Known::Sum(..) | Known::Nothing => return None,
        };
        routine_of(self.program, agents)
    }

    fn site(&mut self, place: &AssignTarget, locals: &[Known], agent: Known) {
        let (function, arguments) = match place {
            AssignTarget::Slot(function, slot) => {
                let Some(arguments) = arguments_of(self.program, *function, *slot) else {
                    return self.add(*function, Vec::new());
                };
                (*function, arguments)
            }
            AssignTarget::Location(function, arguments) => {
                let arguments = arguments.iter().map(|term| known(term, locals, agent));
                (*function, arguments.collect())
            }
            AssignTarget::Local(_) => return,
        };
        self.add(function, arguments);
    }

    fn add(&mut self, function: FunctionId, arguments: Vec<Known>) {
        self.sites.push(UpdateSite {
            function,
            arguments,
            path: self.path.clone(),
        });
    }
}

fn arguments_of(program: &Program, function: FunctionId, slot: Slot) -> Option<Vec<Known>> {
    let Storage::Dense { base, axes, .. } = &program.functions[function.0 as usize].storage else {
        return None;
    };
    let mut rest = slot.checked_sub(*base)?;
    let mut arguments = Vec::new();
    for axis in axes {
        let index = rest.checked_div(axis.stride)?;
        rest %= axis.stride;
        let first = match axis.over {
            AxisRange::Bool => 0,
            AxisRange::Ints { low, .. } => low,
            AxisRange::Atoms { first, .. } => first.into(),
        };
        let argument = first.checked_add(i64::from(index));
        arguments.push(argument.map_or(Known::Nothing, Known::Constant));
    }
    Some(arguments)
}

fn known(term: &Term, locals: &[Known], agent: Known) -> Known {
    if let TermNode::Constant(value) = &*term.node {
        constant(value)
    } else if let TermNode::Local(local) = &*term.node {
        let local = locals.get(*local as usize).copied();
        local.unwrap_or(Known::Nothing)
    } else if let TermNode::Agent = &*term.node {
        agent
    } else if let TermNode::Arithmetic(operation, left, right) = &*term.node {
        let (left, right) = (known(left, locals, agent), known(right, locals, agent));
        let sum = match (operation, left, right) {
            (Arithmetic::Plus, Known::Sum(variable, by), Known::Constant(number))
            | (Arithmetic::Plus, Known::Constant(number), Known::Sum(variable, by)) => {
                by.checked_add(number).map(|by| (variable, by))
            }
            (Arithmetic::Minus, Known::Sum(variable, by), Known::Constant(number)) => {
                by.checked_sub(number).map(|by| (variable, by))
            }
            _ => None,
        };
        sum.map_or(Known::Nothing, |(variable, by)| Known::Sum(variable, by))
    } else {
        Known::Nothing
    }
}

fn constant(value: &Value) -> Known {
    if let Value::Int(number) = value {
        Known::Constant(*number)
    } else if let Value::Bool(truth) = value {
        Known::Constant(i64::from(*truth))
    } else if let Value::Atom(atom) = value {
        Known::Constant(atom.0.into())
    } else {
        Known::Nothing
    }
}
