//! Terms and rules as a machine executes them.

use crate::cover::Counter;
use crate::program::{BodyId, DomainId, FunctionId, Local, Origin, RoutineId, Slot, ValueShape};
use asmotion_stdlib::MessageAction;
use asmotion_value::Value;

pub use asmotion_hir::{Collection, Quantifier};

/// Code with a frame of its own.
#[derive(Debug)]
pub struct Body<T> {
    /// How many locals are arguments; they come first.
    pub arguments: u32,
    /// How many locals there are.
    pub locals: u32,
    /// The code.
    pub code: T,
    /// Where it is declared.
    pub origin: Origin,
    /// Whether the types of its arguments or result leave open how large a value may grow.
    pub open: bool,
}

/// What a term's value is, where that is known before it runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ValueKind {
    /// A truth value or undef.
    Bool,
    /// An integer or undef.
    Int,
    /// A real number or undef.
    Real,
    /// An atom or undef.
    Atom,
    /// Anything.
    Other,
}

/// A term.
#[derive(Clone, Debug)]
pub struct Term {
    /// What it is.
    pub node: Box<TermNode>,
    /// What its value is.
    pub kind: ValueKind,
    /// Where it stands.
    pub origin: Origin,
}

/// The forms of a term.
#[derive(Clone, Debug)]
pub enum TermNode {
    /// A constant.
    Constant(Value),
    /// A variable.
    Local(Local),
    /// The agent that runs.
    Agent,
    /// The location of a known slot.
    Slot(FunctionId, Slot),
    /// A location whose arguments are computed.
    Location(FunctionId, Vec<Term>),
    /// A definition applied.
    Call(BodyId, Vec<Term>),
    /// A closed static term, evaluated once.
    Cached(u32, Term),
    /// A library function applied.
    Builtin(&'static asmotion_stdlib::Builtin, Vec<Term>),
    /// A connective; strong Kleene.
    Logic(Connective, Term, Term),
    /// `not`
    Not(Term),
    /// `=`; total, `undef = undef`.
    Equal(Term, Term),
    /// `<` and its kin on two integers.
    Compare(Comparison, Term, Term),
    /// `+` and its kin on two integers.
    Arithmetic(Arithmetic, Term, Term),
    /// A tuple.
    Tuple(Vec<Term>),
    /// A component of a tuple, from 0.
    Component(Term, u32),
    /// `if`
    If(Term, Term, Term),
    /// `switch`: subject, cases, otherwise
    Switch(Term, Vec<(Term, Term)>, Term),
    /// `let`
    Let(Vec<(Local, Term)>, Term),
    /// `forall`, `exists`, `exists unique`
    Quantified(Quantifier, Vec<Binder>, Option<Term>),
    /// Listed elements.
    Listed(Collection, Vec<Term>),
    /// From, to, step.
    Interval(Collection, Term, Term, Option<Term>),
    /// Binders, guard, item.
    Collect(Collection, Vec<Binder>, Option<Term>, Term),
    /// Listed pairs.
    Map(Vec<(Term, Term)>),
    /// Binders, guard, key, value.
    CollectMap(Vec<Binder>, Option<Term>, Term, Term),
    /// All values of a shape, as a set.
    Extent(ValueShape),
    /// A variable that is not bound here: a fault.
    Unbound,
    /// The program of an agent.
    Program(Term),
    /// A term in the state before the step, whatever a sequence has written since.
    Pre(Term),
    /// A term whose value is noted. Lowering makes none: a machine puts them in to find out what a
    /// failed step saw.
    Watched(Term),
    /// The name of an element, as a text.
    Name(Term),
    /// The element of a domain that has a name.
    Named(DomainId, Term),
}

/// The binary connectives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Connective {
    /// `and`
    And,
    /// `or`
    Or,
    /// `xor`
    Xor,
    /// `implies`
    Implies,
    /// `iff`
    Iff,
}

/// The order relations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Comparison {
    /// `<`
    Lt,
    /// `<=`
    Le,
    /// `>`
    Gt,
    /// `>=`
    Ge,
}

/// Integer operations; a result beyond 64 bits is a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arithmetic {
    /// `+`
    Plus,
    /// `-`
    Minus,
    /// `*`
    Mult,
    /// `mod`: the sign is the dividend's.
    Mod,
}

/// A variable and what it ranges over.
#[derive(Clone, Debug)]
pub struct Binder {
    /// The variable.
    pub local: Local,
    /// Its range.
    pub range: BinderRange,
    /// Where the range stands.
    pub origin: Origin,
}

/// What a variable ranges over, in ascending order.
#[derive(Clone, Debug)]
pub enum BinderRange {
    /// Integers, bounds included.
    Ints(i64, i64),
    /// Atoms from the first, so many.
    Atoms(u32, u32),
    /// `false`, `true`
    Bools,
    /// The elements a domain has at the time.
    Domain(DomainId),
    /// The elements of a collection.
    Elements(Term),
}

/// The numbers that `choose` draws from where a domain has no end and the guard is `true`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Endless {
    /// The 2³² integers next to 0, in the order 0, 1, −1, 2, −2, …
    Integer,
    /// The first 2³² natural numbers.
    Natural,
    /// The 2⁵³ multiples of 2⁻⁵³ from 0 on, 1 left out.
    Real,
}

/// What an update writes.
#[derive(Clone, Debug)]
pub enum AssignTarget {
    /// A location of a known slot.
    Slot(FunctionId, Slot),
    /// A location whose arguments are computed.
    Location(FunctionId, Vec<Term>),
    /// A variable, overwritten at once: as the reference does it.
    Local(Local),
}

/// A rule.
#[derive(Clone, Debug)]
pub struct Rule {
    /// What it is.
    pub node: Box<RuleNode>,
    /// Where it stands.
    pub origin: Origin,
}

/// The forms of a rule.
#[derive(Clone, Debug)]
pub enum RuleNode {
    /// Nothing.
    Skip,
    /// `place := value`
    Update(AssignTarget, Term),
    /// `place <- routine(…)`; without a place, the result is dropped.
    Assign(Option<AssignTarget>, RoutineId, Vec<Term>),
    /// A routine with its arguments.
    Call(RoutineId, Vec<Term>),
    /// A rule value with its arguments.
    Run(Term, Vec<Term>),
    /// The program of an agent, which is `self` meanwhile.
    RunAgent(Term, Vec<Term>),
    /// At once.
    Par(Vec<Rule>),
    /// One after the other.
    Seq(Vec<Rule>),
    /// Guard, then, else.
    If(Term, Rule, Rule),
    /// Subject, cases, otherwise.
    Switch(Term, Vec<(Term, Rule)>, Rule),
    /// Binders, guard, body, ifnone.
    Choose(Vec<Binder>, Option<Term>, Rule, Rule),
    /// Binders, guard, body.
    Forall(Vec<Binder>, Option<Term>, Rule),
    /// Bindings, body.
    Let(Vec<(Local, Term)>, Rule),
    /// Domain, variables, body.
    Extend(DomainId, Vec<Local>, Rule),
    /// A rule that is noted while it runs; see [`TermNode::Watched`].
    Watched(Rule),
    /// Guard, body: until the guard fails, or the body changes nothing if that is an end too.
    While {
        /// What must hold; without, nothing must.
        guard: Option<Term>,
        /// What is repeated.
        body: Rule,
        /// Whether the loop ends where the body changes nothing.
        until_idle: bool,
    },
    /// Local state: its locations have the number of the run as their first argument, and are
    /// forgotten when it ends.
    Local {
        /// Holds the number of the run.
        run: Local,
        /// What gives the locations their first values, at once.
        initial: Vec<Rule>,
        /// What is done with them.
        body: Rule,
    },
    /// A number of a domain without end for each variable, then the body.
    Draw(Vec<(Local, Endless, Origin)>, Rule),
    /// A rule that is counted.
    Counted(Counter, Rule),
    /// What an agent does with messages.
    Act(MessageAction, Vec<Term>),
}
