//! Programs: plain data that back ends compile and machines execute.

use crate::code::{Body, Rule, Term};
use crate::counter::Counted;
use crate::id::{BodyId, DomainId, FunctionId, Origin, RoutineId, Slot};
use crate::value_shape::ValueShape;
use asmotion_stdlib::MessageQuery;
use asmotion_value::{Atom, RuleId, Value};
use std::sync::Arc;

pub use asmotion_hir::{AddedRule, AddedTerm, Assignment};

/// Limit for the elements that [`Program::named_elements`] enumerates.
pub const MAX_NAMED_ELEMENTS: u64 = 4096;

/// A specification in executable form.
#[derive(Debug)]
pub struct Program {
    /// Names, for output only: no decision of a machine depends on them. See [`Symbols`].
    pub symbols: Symbols,
    /// The domain of each declared atom, indexed by the atom.
    pub atom_domains: Vec<DomainId>,
    /// All domains, indexed by [`DomainId`].
    pub domains: Vec<Domain>,
    /// All functions, indexed by [`FunctionId`]; those that are computed have no storage.
    pub functions: Vec<Function>,
    /// Number of slots that get their value in the initial state; they come first. The others get
    /// it on first access.
    pub eager: Slot,
    /// Number of slots laid out at compile time. Interned locations are numbered from here on.
    pub slots: Slot,
    /// The functions with slots laid out at compile time, in ascending order of their slots.
    pub dense: Vec<FunctionId>,
    /// Functions with initial values and domains to be computed, in order of dependency.
    pub initial_order: Vec<Initial>,
    /// Those whose values depend on the inputs or the time of the first step; evaluated after all
    /// of `initial_order`, in order of dependency.
    pub initial_inputs: Vec<Initial>,
    /// Definitions, initial values and conditions.
    pub bodies: Vec<Body<Term>>,
    /// Rules, specialised for their by-name arguments.
    pub routines: Vec<Body<Rule>>,
    /// Targets of [`Value::Rule`], indexed by its [`RuleId`].
    pub rules: Vec<RuleValue>,
    /// The program of the agents of each domain.
    pub programs: Vec<(DomainId, RuleId)>,
    /// The main rule; `None` for a module.
    pub main: Option<RoutineId>,
    /// Conditions that must hold in every state.
    pub invariants: Vec<Invariant>,
    /// Bodies of the terms from outside, indexed by [`AddedTerm`].
    pub added_terms: Vec<BodyId>,
    /// Routines of the rules from outside, indexed by [`AddedRule`].
    pub added_rules: Vec<RoutineId>,
    /// `true` to run as the reference tools do where these observably deviate from the textbook.
    pub compatible: bool,
    /// The coverage counters; empty unless the program was created by [`Program::covered`].
    pub counted: Vec<Counted>,
    /// Number of cached values of closed static terms.
    pub caches: u32,
    /// The slot of `result`, to which turbo rules write the value they return.
    pub result: Slot,
    /// The function whose locations are the variables that rules assign. Arguments: the number of
    /// the run of the binding rule, and the number of the variable.
    pub variables: FunctionId,
    /// The vocabulary of messages; `None` unless the specification imports CommonBehavior.
    pub messages: Option<Messages>,
}

/// The function and the literals of CommonBehavior with which the machine reports on messages.
#[derive(Clone, Debug)]
pub struct Messages {
    /// `status`, which maps an agent to its state of communication.
    pub status: FunctionId,
    /// `READY`: the agent has received a message.
    pub ready: Value,
    /// `BLOCKED`: the agent found no message.
    pub blocked: Value,
    /// `AVAILABLE`: the channel delivers messages.
    pub available: Value,
    /// `UNAVAILABLE`: the channel delivers none.
    pub unavailable: Value,
    /// `CALL_TIMEOUT`: no reply arrived in time.
    pub timeout: Value,
    /// `CALL_UNAVAILABLE`: no provider accepts the call.
    pub no_provider: Value,
    /// `CALL_FAILED`: the provider reported a failure.
    pub failed: Value,
    /// `CALL_CANCELLED`: the caller withdrew the call.
    pub cancelled: Value,
}

/// A part of the initial state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Initial {
    /// The elements of a domain.
    Domain(DomainId),
    /// The initial values of a function.
    Function(FunctionId),
}

/// Names, indexed by number. Two things depend on them: output and input in text form (traces,
/// messages, recorded inputs), and specifications that convert an element to a string (`toString`,
/// `print`) or find one by its string. Everything else uses numbers.
#[derive(Debug, Default)]
pub struct Symbols {
    /// Names of the declared atoms.
    pub atoms: Vec<Arc<str>>,
    /// Names of the functions, indexed by [`FunctionId`].
    pub functions: Vec<Arc<str>>,
    /// Names of the domains, indexed by [`DomainId`].
    pub domains: Vec<Arc<str>>,
    /// Names of the rules, indexed by [`RuleId`].
    pub rules: Vec<Arc<str>>,
    /// Domains of each rule's parameters, as in `Integer,Robot`; distinguishes rules of the same
    /// name.
    pub rule_domains: Vec<Arc<str>>,
}

/// A domain of the program.
#[derive(Debug)]
pub struct Domain {
    /// Form in which the elements are known.
    pub elements: DomainElements,
    /// The domain of which it is a subset; `None` unless it is a subset of a declared domain.
    pub base: Option<DomainId>,
    /// `true` if `extend` can add elements: the domain is abstract, or a subset of an abstract one.
    pub grows: bool,
    /// `true` if some rule of the program adds elements, to it or to a subset of it.
    pub is_extended: bool,
    /// `true` if some rule creates elements for this very domain.
    pub is_created_for: bool,
}

/// The elements of a domain, as far as known at compile time.
#[derive(Clone, Debug, PartialEq)]
pub enum DomainElements {
    /// The integers from `low` to `high`, inclusive.
    Ints {
        /// Least element.
        low: i64,
        /// Greatest element.
        high: i64,
    },
    /// Consecutive atoms, to which `extend` may add others.
    Atoms {
        /// First atom.
        first: Atom,
        /// Number of elements in the initial state.
        count: u32,
    },
    /// The set that a closed term denotes in the initial state.
    Computed(BodyId),
    /// None: declared as a subset, but never defined.
    Undefined,
    /// Not enumerated: an anydomain or a basic domain.
    Open,
}

/// A function of the program.
#[derive(Debug)]
pub struct Function {
    /// Determines who may update its locations.
    pub kind: FunctionKind,
    /// Shapes of its arguments.
    pub parameters: Vec<ValueShape>,
    /// Shape of its values.
    pub codomain: ValueShape,
    /// Domain that updates check the value against; `None` if every value of the shape is
    /// permitted.
    pub within: Option<DomainId>,
    /// `true` if a component of the value must be an element of a concrete domain, and that domain has a definition.
    pub restricted: bool,
    /// `true` if a component of an argument must be an element of a concrete domain that does not
    /// grow.
    pub narrow: bool,
    /// `true` if the codomain puts no bound on how deeply values nest, as with `Any`; updates then
    /// check the bound.
    pub open: bool,
    /// Storage of its locations.
    pub storage: Storage,
    /// Body of the initial value, with the function's arguments; `None` for undef.
    pub initial: Option<BodyId>,
    /// For a clock function (`mCurrTimeSecs`), the nanoseconds in its unit. It defaults to the time
    /// of the step if the environment gives no value.
    pub clock: Option<i64>,
    /// The query about messages that the function stands for. The machine answers it if it can,
    /// otherwise the environment.
    pub mail: Option<MessageQuery>,
    /// `true` if the specification declares it, not a library; only such functions are shown in
    /// traces.
    pub own: bool,
}

/// The kind of a function: who may update its locations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FunctionKind {
    /// Rules only.
    Controlled,
    /// Rules only, and the environment observes it.
    Out,
    /// The environment only.
    Monitored,
    /// Both rules and the environment.
    Shared,
    /// Rules, during the run of the rule that declares it.
    Local,
    /// Neither: static or derived.
    Fixed,
}

/// Storage of a function's locations.
#[derive(Clone, Debug, PartialEq)]
pub enum Storage {
    /// No locations: the function is computed.
    None,
    /// Slots laid out at compile time: `base + Σ index(argument) · stride` if all arguments lie on
    /// their axes. Other locations are interned.
    Dense {
        /// Slot of the first location.
        base: Slot,
        /// Number of slots.
        count: u32,
        /// One axis for each argument.
        axes: Vec<SlotAxis>,
        /// `true` if a location gets its value on first access. This is the case for infinite
        /// domains, where the axes cover the arguments that the program is known to use.
        lazy: bool,
    },
    /// Interned locations, numbered on first access.
    Interned,
}

impl Storage {
    /// Returns `true` if its slots get their values on first access.
    pub fn is_lazy(&self) -> bool {
        matches!(self, Self::Dense { lazy: true, .. })
    }
}

/// The mapping from an argument to its part of the slot number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SlotAxis {
    /// The arguments that lie on the axis.
    pub over: AxisRange,
    /// Distance between the slots of neighbouring arguments.
    pub stride: u32,
}

/// The arguments on an axis; their index counts from 0 in the order given here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AxisRange {
    /// `false`, `true`
    Bool,
    /// Consecutive integers.
    Ints {
        /// Least integer.
        low: i64,
        /// Number of integers.
        count: u32,
    },
    /// Consecutive atoms.
    Atoms {
        /// Number of the first atom.
        first: u32,
        /// Number of atoms.
        count: u32,
    },
}

/// The signature of an operation that an agent provides.
#[derive(Clone, Debug)]
pub struct AgentOperation {
    /// Shape of the request's data; a tuple for several parameters.
    pub takes: ValueShape,
    /// Shape of the reply's data.
    pub gives: ValueShape,
    /// `false` for a one-way operation, whose requests have no reply.
    pub replies: bool,
}

impl Default for AgentOperation {
    /// An operation with arbitrary data, which replies.
    fn default() -> Self {
        Self {
            takes: ValueShape::Any,
            gives: ValueShape::Any,
            replies: true,
        }
    }
}

impl Program {
    /// Returns the signature of an agent's operation, from the out function of that name. The
    /// codomain `Rule` declares an operation without reply. An undeclared operation has the default
    /// signature.
    pub fn operation(&self, name: &str) -> AgentOperation {
        let mut functions = self.symbols.functions.iter().zip(&self.functions);
        let found = functions.find(|(known, function)| {
            function.own
                && function.kind == FunctionKind::Out
                && asmotion_stdlib::operation(known) == name
                && matches!(function.parameters.first(), Some(ValueShape::Domain(_)))
        });
        let Some((_, function)) = found else {
            return AgentOperation::default();
        };
        let takes = match &function.parameters[1..] {
            [one] => one.clone(),
            [] => ValueShape::Any,
            several => ValueShape::Tuple(several.to_vec()),
        };
        let replies = function.codomain != ValueShape::Rule;
        AgentOperation {
            takes,
            gives: if replies {
                function.codomain.clone()
            } else {
                ValueShape::Any
            },
            replies,
        }
    }

    /// Returns the values of a shape with their names, in ascending order, if they are known before
    /// the run and number at most [`MAX_NAMED_ELEMENTS`].
    pub fn named_elements(&self, shape: &ValueShape) -> Option<Vec<(String, Value)>> {
        match shape {
            ValueShape::Bool => {
                let truths = [false, true].into_iter();
                Some(truths.map(|it| (it.to_string(), Value::Bool(it))).collect())
            }
            ValueShape::Domain(domain) => match self.domains.get(domain.0 as usize)?.elements {
                DomainElements::Ints { low, high } if low > high => Some(Vec::new()),
                DomainElements::Ints { low, high } => {
                    let numbers = (low..=high).map(|it| (it.to_string(), Value::Int(it)));
                    (high.abs_diff(low) < MAX_NAMED_ELEMENTS).then(|| numbers.collect())
                }
                DomainElements::Atoms { first, count } => {
                    let atoms = first.0..first.0.checked_add(count)?;
                    let named = atoms.map(|atom| {
                        let name = self.symbols.atoms.get(atom as usize)?;
                        Some((name.to_string(), Value::Atom(Atom(atom))))
                    });
                    named.collect()
                }
                DomainElements::Computed(_) | DomainElements::Undefined | DomainElements::Open => {
                    None
                }
            },
            ValueShape::Int
            | ValueShape::Natural
            | ValueShape::Real
            | ValueShape::Char
            | ValueShape::Text
            | ValueShape::Complex
            | ValueShape::Rule
            | ValueShape::Tuple(_)
            | ValueShape::Seq(_)
            | ValueShape::Set(_)
            | ValueShape::Bag(_)
            | ValueShape::Map(..)
            | ValueShape::Any => None,
        }
    }

    /// Returns `true` if the initial state, or an invariant in it, depends on the inputs of the
    /// first step.
    pub fn needs_inputs(&self) -> bool {
        let mut invariants = self.invariants.iter();
        !self.initial_inputs.is_empty() || invariants.any(|invariant| invariant.waits)
    }

    /// Returns the function to which a slot laid out at compile time belongs.
    pub fn dense_function(&self, slot: Slot) -> Option<FunctionId> {
        let begins_after = |id: &FunctionId| match self.functions[id.0 as usize].storage {
            Storage::Dense { base, .. } => base <= slot,
            Storage::None | Storage::Interned => false,
        };
        let after = self.dense.partition_point(begins_after);
        self.dense
            .get(after.checked_sub(1)?)
            .copied()
            .filter(|_| slot < self.slots)
    }
}

impl AxisRange {
    /// Returns the number of indices.
    pub fn count(self) -> u32 {
        match self {
            Self::Bool => 2,
            Self::Ints { count, .. } | Self::Atoms { count, .. } => count,
        }
    }

    /// Returns the index of an argument, or `None` if it does not lie on the axis.
    #[inline]
    pub fn index(self, argument: &Value) -> Option<u32> {
        match (self, argument) {
            (Self::Bool, Value::Bool(truth)) => Some(u32::from(*truth)),
            (Self::Ints { low, count }, Value::Int(number)) => {
                let index = number.checked_sub(low)?;
                (0..i64::from(count))
                    .contains(&index)
                    .then_some(index as u32)
            }
            (Self::Atoms { first, count }, Value::Atom(atom)) => {
                let index = atom.0.wrapping_sub(first);
                (index < count).then_some(index)
            }
            _ => None,
        }
    }

    /// Returns the argument at an index.
    pub fn argument(self, index: u32) -> Value {
        match self {
            Self::Bool => Value::Bool(index == 1),
            Self::Ints { low, .. } => Value::Int(low + i64::from(index)),
            Self::Atoms { first, .. } => Value::Atom(Atom(first + index)),
        }
    }
}

/// A rule as a value: a routine and its leading arguments.
#[derive(Debug)]
pub struct RuleValue {
    /// The routine; `None` for a rule that cannot be used as a value.
    pub routine: Option<RoutineId>,
    /// `true` if the rule writes `result`, which is discarded because the call has no target.
    pub returns: bool,
    /// Bodies of the arguments bound to the value.
    pub arguments: Vec<BodyId>,
}

/// A condition that must hold in every state.
#[derive(Debug)]
pub struct Invariant {
    /// Declared name; the text of the condition if it has none.
    pub name: Arc<str>,
    /// Body of the condition.
    pub body: BodyId,
    /// `true` if the condition depends on monitored functions. It is then an assumption about the
    /// environment, checked before the updates of a step are applied.
    pub assumes: bool,
    /// `true` if the condition depends on inputs, including shared functions. The initial state can
    /// then be checked only with the inputs of the first step.
    pub waits: bool,
    /// `true` for a constraint (`INVAR`) of the specification.
    pub is_constraint: bool,
    /// Place of the condition in the sources.
    pub origin: Origin,
}
