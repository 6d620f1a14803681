//! Programs as plain data.

use crate::code::{Body, Rule, Term};
use crate::cover::Counted;
use asmotion_stdlib::MessageQuery;
use asmotion_value::{Atom, RuleId, Value};
use std::sync::Arc;

pub use asmotion_hir::{AddedRule, AddedTerm, Assignment};

/// The number of a location.
pub type Slot = u32;

/// The number of a variable in its frame.
pub type Local = u32;

/// A place in the sources; [`crate::Lowered::origins`] knows it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Origin(pub u32);

/// A function of the program, numbered as in the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FunctionId(pub u32);

/// A domain of the program, numbered as in the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct DomainId(pub u32);

/// A term with a frame of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct BodyId(pub u32);

/// A rule with a frame of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct RoutineId(pub u32);

/// A specification, ready to be compiled and run.
#[derive(Debug)]
pub struct Program {
    /// What things are called. No decision of a machine depends on it: see [`Symbols`].
    pub symbols: Symbols,
    /// The domain that each atom was declared in.
    pub atom_domains: Vec<DomainId>,
    /// The domains.
    pub domains: Vec<Domain>,
    /// The functions; those without locations have no storage.
    pub functions: Vec<Function>,
    /// How many slots have a value from the beginning; they come first.
    pub eager: Slot,
    /// How many slots are fixed; interned locations get the numbers from here on.
    pub slots: Slot,
    /// The functions with fixed slots, in the order of their slots.
    pub dense: Vec<FunctionId>,
    /// The functions with initial values and the domains that must be computed, each after those its
    /// values depend on.
    pub initial_order: Vec<Initial>,
    /// Those of them whose values depend on the inputs and the time of the first step, likewise.
    pub initial_inputs: Vec<Initial>,
    /// Definitions, initial values, conditions.
    pub bodies: Vec<Body<Term>>,
    /// Rules, specialised.
    pub routines: Vec<Body<Rule>>,
    /// What a [`Value::Rule`] runs.
    pub rules: Vec<RuleValue>,
    /// The programs of agents, by domain.
    pub programs: Vec<(DomainId, RuleId)>,
    /// The main rule; a module has none.
    pub main: Option<RoutineId>,
    /// What must hold in every state.
    pub invariants: Vec<Invariant>,
    /// Terms from outside, by [`AddedTerm`].
    pub added_terms: Vec<BodyId>,
    /// Rules from outside, by [`AddedRule`].
    pub added_rules: Vec<RoutineId>,
    /// Whether it runs as the reference tools run it, where these observably differ.
    pub compatible: bool,
    /// What is counted; nothing, unless the program is [`Program::covered`].
    pub counted: Vec<Counted>,
    /// How many values of closed static terms can be kept.
    pub caches: u32,
    /// The location of `result`, where turbo rules leave theirs.
    pub result: Slot,
    /// The function whose locations are the variables that rules assign: the number of a run of
    /// the rule that binds them, and the number of the variable.
    pub variables: FunctionId,
    /// What a specification with messages is told with.
    pub messages: Option<Messages>,
}

/// The status of agents and the literals that say what became of messages.
#[derive(Clone, Debug)]
pub struct Messages {
    /// The status of an agent.
    pub status: FunctionId,
    /// The status of an agent that has received a message.
    pub ready: Value,
    /// The status of one that has found none.
    pub blocked: Value,
    /// Messages go out.
    pub available: Value,
    /// They do not.
    pub unavailable: Value,
    /// A call that was not answered in time.
    pub timeout: Value,
    /// One that nobody could take.
    pub no_provider: Value,
    /// One whose provider failed.
    pub failed: Value,
    /// One that was taken back.
    pub cancelled: Value,
}

/// What the initial state is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Initial {
    /// The elements of a domain.
    Domain(DomainId),
    /// The initial values of a function.
    Function(FunctionId),
}

/// Names, by number: a table beside the program. It is read in two places. Texts show names (traces,
/// messages, inputs read from files); and a specification itself may turn an element into a text, by
/// `toString` or `print`, and find one by its text. All else goes by number.
#[derive(Debug, Default)]
pub struct Symbols {
    /// The names of the atoms.
    pub atoms: Vec<Arc<str>>,
    /// The names of the functions.
    pub functions: Vec<Arc<str>>,
    /// The names of the domains.
    pub domains: Vec<Arc<str>>,
    /// The names of the rules.
    pub rules: Vec<Arc<str>>,
    /// The domains of each rule's parameters, as in `Integer,Robot`: two rules may share a name.
    pub rule_domains: Vec<Arc<str>>,
}

/// A domain.
#[derive(Debug)]
pub struct Domain {
    /// Its elements.
    pub elements: DomainElements,
    /// The domain it is a subset of.
    pub base: Option<DomainId>,
    /// Whether `extend` may add elements: it is abstract, or a subset of such a domain.
    pub grows: bool,
}

/// The elements of a domain.
#[derive(Clone, Debug, PartialEq)]
pub enum DomainElements {
    /// All integers from `low` to `high`, bounds included.
    Ints {
        /// The least element.
        low: i64,
        /// The greatest element.
        high: i64,
    },
    /// Atoms side by side; `extend` may add others.
    Atoms {
        /// The first atom.
        first: Atom,
        /// How many there are at the start.
        count: u32,
    },
    /// The value of a closed term in the initial state: a set.
    Computed(BodyId),
    /// No elements: declared as a subset, never defined.
    Undefined,
    /// Not a set of its own: an anydomain or a basic domain.
    Open,
}

/// A function.
#[derive(Debug)]
pub struct Function {
    /// Who writes its locations.
    pub kind: FunctionKind,
    /// The shapes of its arguments.
    pub parameters: Vec<ValueShape>,
    /// The shape of its values.
    pub codomain: ValueShape,
    /// What a value must be an element of when it is written; `None` for all values of the shape.
    pub within: Option<DomainId>,
    /// Whether some part of a value must be an element of a concrete domain.
    pub restricted: bool,
    /// Whether some part of an argument must be an element of one that does not grow.
    pub narrow: bool,
    /// Whether the type of its values leaves open how large they may grow: `Any` holds all nests.
    pub open: bool,
    /// Where its locations are.
    pub storage: Storage,
    /// Its value in the initial state, by arguments.
    pub initial: Option<BodyId>,
    /// Nanoseconds a unit, if it tells the time (`mCurrTimeSecs`): what the environment leaves open
    /// is the time of the step.
    pub clock: Option<i64>,
    /// What it asks about messages: the machine answers, the environment where it cannot.
    pub mail: Option<MessageQuery>,
    /// Whether the specification declares it itself: only these are shown.
    pub own: bool,
}

/// Who writes a function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FunctionKind {
    /// Rules.
    Controlled,
    /// Rules; the environment reads it.
    Out,
    /// The environment.
    Monitored,
    /// Both.
    Shared,
    /// Rules, while the rule runs that declares it.
    Local,
    /// Nobody: computed.
    Fixed,
}

/// The values of a type, as far as inputs and enumeration need to know.
#[derive(Clone, Debug, PartialEq)]
pub enum ValueShape {
    /// `true`, `false`
    Bool,
    /// Integers.
    Int,
    /// Integers from 0.
    Natural,
    /// Real numbers.
    Real,
    /// Characters.
    Char,
    /// Texts.
    Text,
    /// Complex numbers.
    Complex,
    /// Rules.
    Rule,
    /// The elements of a domain.
    Domain(DomainId),
    /// Tuples.
    Tuple(Vec<ValueShape>),
    /// Sequences.
    Seq(Box<ValueShape>),
    /// Sets.
    Set(Box<ValueShape>),
    /// Bags.
    Bag(Box<ValueShape>),
    /// Maps.
    Map(Box<ValueShape>, Box<ValueShape>),
    /// Anything.
    Any,
}

/// Where the locations of a function are.
#[derive(Clone, Debug, PartialEq)]
pub enum Storage {
    /// It has none.
    None,
    /// `base + Σ index(argument) · stride`, for arguments on their axes; others are interned.
    Dense {
        /// The slot of the first location.
        base: Slot,
        /// How many slots there are.
        count: u32,
        /// One axis an argument.
        axes: Vec<SlotAxis>,
        /// Whether a location gets its value when it is first met: the axes are those of arguments the
        /// program uses, the domains have no end.
        lazy: bool,
    },
    /// Every location is interned.
    Interned,
}

impl Storage {
    /// Whether its fixed slots get their values when they are first met.
    pub fn is_lazy(&self) -> bool {
        matches!(self, Self::Dense { lazy: true, .. })
    }
}

/// How an argument becomes an index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SlotAxis {
    /// What the argument ranges over.
    pub over: AxisRange,
    /// How far apart the locations of neighbouring arguments are.
    pub stride: u32,
}

/// What an argument ranges over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AxisRange {
    /// `false`, `true`
    Bool,
    /// Integers from `low`, `count` of them.
    Ints {
        /// The least.
        low: i64,
        /// How many.
        count: u32,
    },
    /// Atoms from `first`, `count` of them.
    Atoms {
        /// The first.
        first: u32,
        /// How many.
        count: u32,
    },
}

/// What an agent can be asked.
#[derive(Clone, Debug)]
pub struct AgentOperation {
    /// What it is asked with.
    pub takes: ValueShape,
    /// What it answers.
    pub gives: ValueShape,
    /// Whether every request has a reply.
    pub replies: bool,
}

impl Default for AgentOperation {
    /// Takes and gives anything.
    fn default() -> Self {
        Self {
            takes: ValueShape::Any,
            gives: ValueShape::Any,
            replies: true,
        }
    }
}

impl Program {
    /// What an operation of an agent takes and gives, as an out function of its name declares it. One
    /// whose codomain is `Rule` gives anything, or has no reply at all.
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
            gives: match replies {
                true => function.codomain.clone(),
                false => ValueShape::Any,
            },
            replies,
        }
    }

    /// Whether the initial state, or what must hold in it, depends on the inputs of the first step.
    pub fn needs_inputs(&self) -> bool {
        let mut invariants = self.invariants.iter();
        !self.initial_inputs.is_empty() || invariants.any(|invariant| invariant.waits)
    }

    /// The function one of whose locations has this fixed slot.
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
    /// How many indices there are.
    pub fn count(self) -> u32 {
        match self {
            Self::Bool => 2,
            Self::Ints { count, .. } | Self::Atoms { count, .. } => count,
        }
    }

    /// The index of an argument, if it lies on the axis.
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

    /// The argument at an index.
    pub fn argument(self, index: u32) -> Value {
        match self {
            Self::Bool => Value::Bool(index == 1),
            Self::Ints { low, .. } => Value::Int(low + i64::from(index)),
            Self::Atoms { first, .. } => Value::Atom(Atom(first + index)),
        }
    }
}

/// A rule as a value: a routine and its first arguments.
#[derive(Debug)]
pub struct RuleValue {
    /// The routine; `None` for a rule that cannot be a value.
    pub routine: Option<RoutineId>,
    /// Whether it leaves a result, which nobody takes.
    pub returns: bool,
    /// Arguments already given, each a closed term.
    pub arguments: Vec<BodyId>,
}

/// What must hold in every state.
#[derive(Debug)]
pub struct Invariant {
    /// Its name.
    pub name: Arc<str>,
    /// The condition.
    pub body: BodyId,
    /// Whether it speaks of what the environment alone owns: then it is an assumption, checked before
    /// the step's updates.
    pub assumes: bool,
    /// Whether it speaks of what rules and the environment share: then the initial state satisfies it
    /// or not when the environment has spoken.
    pub waits: bool,
    /// Where it stands.
    pub origin: Origin,
}
