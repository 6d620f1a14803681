//! The grounded form of a program: plain data over integer variables.

use asmotion_ir::{
    Arithmetic, Comparison, Connective, Counter, FunctionId, Origin, Quantifier, Slot,
};
use asmotion_value::{Atom, Value};

/// The number that stands for `undef`.
pub const UNDEF: i64 = i64::MIN;

/// The result of a term whose evaluation needs a machine: it fails, or it cannot be grounded.
pub const FAULT: i64 = i64::MIN + 1;

/// The kind of values that the numbers of a variable or term stand for. `undef` is [`UNDEF`] in each of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Sort {
    /// Truth values: 0 for false, 1 for true.
    Bool,
    /// Integers.
    Int,
    /// Atoms: elements of enumerations and abstract domains, by their numbers.
    Atom,
}

impl Sort {
    /// Returns the sort and the number of a value; `None` for a value that is neither scalar nor undef. `undef` has no sort.
    pub fn number(value: &Value) -> Option<(Option<Self>, i64)> {
        match value {
            Value::Undef => Some((None, UNDEF)),
            Value::Bool(truth) => Some((Some(Self::Bool), i64::from(*truth))),
            Value::Int(number) if *number > FAULT => Some((Some(Self::Int), *number)),
            Value::Atom(atom) => Some((Some(Self::Atom), i64::from(atom.0))),
            Value::Int(_)
            | Value::Real(_)
            | Value::Char(_)
            | Value::Rule(_)
            | Value::Text(_)
            | Value::Complex(_)
            | Value::Tuple(_)
            | Value::Seq(_)
            | Value::Set(_)
            | Value::Bag(_)
            | Value::Map(_) => None,
        }
    }

    /// Returns the value that a number of this sort stands for.
    pub fn value(self, number: i64) -> Value {
        match self {
            _ if number == UNDEF => Value::Undef,
            Self::Bool => Value::Bool(number != 0),
            Self::Int => Value::Int(number),
            Self::Atom => Value::Atom(Atom(u32::try_from(number).unwrap_or(u32::MAX))),
        }
    }
}

/// The numbers that a function accepts as values.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Permitted {
    /// All of its sort.
    All,
    /// Those from the first to the second, inclusive.
    Between(i64, i64),
    /// Those listed, in ascending order.
    Listed(Vec<i64>),
}

impl Permitted {
    /// Returns `true` if an update to this number is no fault. Every function accepts `undef`.
    #[inline]
    pub fn accepts(&self, number: i64) -> bool {
        number == UNDEF
            || match self {
                Self::All => true,
                Self::Between(low, high) => (*low..=*high).contains(&number),
                Self::Listed(numbers) => numbers.binary_search(&number).is_ok(),
            }
    }
}

/// A location that rules update.
#[derive(Clone, Debug)]
pub struct StateVariable {
    /// Slot of the location in a machine.
    pub slot: Slot,
    /// The function of which it is a location.
    pub function: FunctionId,
    /// Kind of its values.
    pub sort: Sort,
    /// Number in the initial state.
    pub initial: i64,
    /// The values that updates may give it.
    pub permitted: Permitted,
    /// Least and greatest number that it is expected to have besides `undef`. For a function without bounds these are
    /// estimates.
    pub range: (i64, i64),
    /// `true` if it never has a number outside `range`.
    pub is_bounded: bool,
    /// `true` if it may become, or initially is, `undef`.
    pub may_be_undef: bool,
}

/// A location that the environment determines in each step.
#[derive(Clone, Debug)]
pub struct InputVariable {
    /// The monitored function.
    pub function: FunctionId,
    /// Arguments of the location.
    pub arguments: Vec<Value>,
    /// Kind of its values.
    pub sort: Sort,
    /// Its possible numbers, in the order in which they are tried.
    pub values: Vec<i64>,
}

/// An argument that selects an element of a table.
#[derive(Clone, Debug, PartialEq)]
pub struct TableIndex {
    /// Computes the argument.
    pub term: GroundTerm,
    /// Number of the first row.
    pub low: i64,
    /// Number of rows.
    pub count: u32,
    /// Distance between the elements of neighbouring rows.
    pub stride: u32,
}

/// A term over variables, inputs and numbers. Subterms are evaluated in order and as lazily as a machine does.
#[derive(Clone, Debug, PartialEq)]
pub enum GroundTerm {
    /// A number, [`UNDEF`] or [`FAULT`].
    Constant(i64),
    /// The value of the state variable with this index.
    Variable(u32),
    /// The value of the input variable with this index.
    Input(u32),
    /// `not`
    Not(Box<GroundTerm>),
    /// A connective of strong Kleene logic; the right operand is skipped if the left one decides.
    Logic(Connective, Box<GroundTerm>, Box<GroundTerm>),
    /// A quantifier over its instances; evaluation ends with the first that decides.
    Quantified(Quantifier, Vec<GroundTerm>),
    /// `=` of two terms of one sort, defined for `undef`.
    Equal(Box<GroundTerm>, Box<GroundTerm>),
    /// An order relation of integers; undef if an operand is.
    Compare(Comparison, Box<GroundTerm>, Box<GroundTerm>),
    /// An operation on integers; undef if an operand is, a fault if the result exceeds 64 bits or the divisor is 0.
    Arithmetic(Arithmetic, Box<GroundTerm>, Box<GroundTerm>),
    /// Guard, `then`, `else`. An undef guard is a fault.
    If(Box<GroundTerm>, Box<GroundTerm>, Box<GroundTerm>),
    /// The element `Σ (argument − low) · stride` of a table.
    Table {
        /// Arguments, each with its lower bound and stride.
        indices: Vec<TableIndex>,
        /// The elements; variables or constants.
        elements: Vec<GroundTerm>,
        /// The result if an argument is undef. An argument in no row is a fault.
        undefined: Box<GroundTerm>,
    },
    /// Evaluates the first terms for their faults and inputs only, and returns the last term's value.
    After(Vec<GroundTerm>, Box<GroundTerm>),
}

/// The left-hand side of an update.
#[derive(Clone, Debug, PartialEq)]
pub enum GroundTarget {
    /// The variable with this index.
    Variable(u32),
    /// The variable `Σ (argument − low) · stride` of a table; an argument in no row is a fault.
    Table(Vec<TableIndex>, Vec<u32>),
}

/// A candidate of a `choose`.
#[derive(Clone, Debug, PartialEq)]
pub struct GroundCandidate {
    /// Values of the chosen variables.
    pub chosen: Vec<Value>,
    /// The candidate takes part if it is true; undef is a fault.
    pub guard: GroundTerm,
    /// The rule to execute if it is chosen.
    pub rule: GroundRule,
}

/// A rule over variables and inputs.
#[derive(Clone, Debug, PartialEq)]
pub enum GroundRule {
    /// Yields no update.
    Skip,
    /// Target, value, place of the rule. Terms of the target are evaluated after the value.
    Update(GroundTarget, GroundTerm, Origin),
    /// All rules in the same state; different updates of a variable are a fault.
    Par(Vec<GroundRule>),
    /// Each rule in the state that the previous ones produce.
    Seq(Vec<GroundRule>),
    /// Guard, `then`, `else`. An undef guard is a fault.
    If(GroundTerm, Box<GroundRule>, Box<GroundRule>),
    /// One of the candidates whose guards are true, all of which are evaluated first; the last rule if there is none.
    Choose(Vec<GroundCandidate>, Box<GroundRule>, Origin),
    /// Evaluates terms for their faults and inputs only, then executes the rule.
    After(Vec<GroundTerm>, Box<GroundRule>),
    /// A rule with a coverage counter.
    Counted(Counter, Box<GroundRule>),
    /// A rule that only a machine can execute.
    Machine,
}

/// A program over finite ranges, without calls and bound variables.
#[derive(Clone, Debug)]
pub struct GroundProgram {
    /// The locations that rules update, in ascending order of their slots. A machine-executed step may update others.
    pub variables: Vec<StateVariable>,
    /// The input locations that rules or conditions read.
    pub inputs: Vec<InputVariable>,
    /// The main rule.
    pub rule: GroundRule,
    /// The terms added to the program from outside, by their numbers.
    pub conditions: Vec<GroundTerm>,
    /// Number of coverage counters.
    pub counters: usize,
}
