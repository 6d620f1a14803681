//! The model: what a specification declares and defines, by id.

use crate::addition::{AddedRule, AddedTerm};
use crate::scope::Scope;
use crate::types::{TypeId, TypeTable};
use asmotion_diagnostics::Span;
use asmotion_syntax::ast;
use asmotion_value::{Atom, RuleId, Value};
use std::sync::Arc;

pub use crate::id::{DomainId, FunctionId};

pub use ast::{Collection, FunctionKind, Quantifier};

/// A variable of one [`Body`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct VarId(pub u32);

/// A specification, whole: the main file and all modules it imports.
#[derive(Debug)]
pub struct Model {
    /// The name after `asm`.
    pub name: Arc<str>,
    /// The types in use.
    pub types: TypeTable,
    /// All domains, in order of declaration, libraries first.
    pub domains: Vec<Domain>,
    /// All functions, likewise.
    pub functions: Vec<Function>,
    /// All rules, likewise.
    pub rules: Vec<Rule>,
    /// Enumeration literals and abstract constants; those of one domain stand side by side.
    pub atoms: Vec<AtomInfo>,
    /// The main rule; a module has none.
    pub main: Option<RuleId>,
    /// Which program the agents of a domain run.
    pub programs: Vec<AgentProgram>,
    /// What must hold in every state.
    pub invariants: Vec<Invariant>,
    /// Temporal properties and fairness, for the verifier.
    pub properties: Vec<TemporalProperty>,
    /// The functions with a meaning of their own.
    pub reserved: Reserved,
    /// Whether it runs as the reference tools run it.
    pub compatible: bool,
    /// Terms and rules from outside.
    pub added: Added,
    /// The names that are seen from outside.
    pub(crate) scope: Scope,
}

/// The functions that the machine itself gives a meaning.
#[derive(Clone, Copy, Debug)]
pub struct Reserved {
    /// `self: Agent`
    pub self_: Option<FunctionId>,
    /// `program: Agent -> Rule`
    pub program: Option<FunctionId>,
    /// `result: Any`
    pub result: Option<FunctionId>,
    /// Holds the variables that rules assign: by the number of the run of the rule that binds them,
    /// and their number in it.
    pub variables: FunctionId,
}

/// A domain.
#[derive(Debug)]
pub struct Domain {
    /// Its name.
    pub name: Arc<str>,
    /// What it is.
    pub kind: DomainKind,
    /// `dynamic` in front.
    pub dynamic: bool,
    /// Its elements, from the definitions or the initial state.
    pub definition: Option<Expression>,
    /// Where it is declared.
    pub span: Span,
}

/// What a domain is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DomainKind {
    /// `anydomain`
    Any,
    /// `basic domain`: stands for a basic type.
    Basic,
    /// `abstract domain`
    Abstract,
    /// `enum domain`: its literals are atoms side by side.
    Enum {
        /// The first literal.
        first: Atom,
        /// How many there are.
        count: u32,
    },
    /// `subsetof`
    Concrete {
        /// The domain it is a subset of.
        base: TypeId,
    },
}

/// An enumeration literal or an abstract constant.
#[derive(Debug)]
pub struct AtomInfo {
    /// Its name.
    pub name: Arc<str>,
    /// Its domain.
    pub domain: DomainId,
    /// Where it is declared.
    pub span: Span,
}

/// A function.
#[derive(Debug)]
pub struct Function {
    /// Its name.
    pub name: Arc<str>,
    /// Who may write it.
    pub kind: FunctionKind,
    /// The domains of its arguments; a `Prod` domain is one argument a component.
    pub parameters: Vec<TypeId>,
    /// Its codomain.
    pub codomain: TypeId,
    /// What computes it.
    pub meaning: Meaning,
    /// Its value in the initial state.
    pub initial: Option<Body<Term>>,
    /// Where it is declared: its name.
    pub span: Span,
    /// The whole declaration, from the word that says who may write it.
    pub declaration: Span,
    /// Whether it is declared in a standard library.
    pub library: bool,
    /// For a `local` function, the variable of its rule that holds the number of the run: the first
    /// argument of all its locations, which nobody writes down.
    pub run: Option<VarId>,
    /// Whether it is annotated `//@Backref`: who sent the message at hand.
    pub is_client: bool,
}

/// What computes a function.
#[derive(Debug)]
pub enum Meaning {
    /// The state: controlled, monitored, shared and out functions.
    State,
    /// A term: static and derived functions.
    Defined(Body<Term>),
    /// The standard library.
    Builtin(&'static asmotion_stdlib::Builtin),
    /// An element of an abstract domain.
    Constant(Atom),
    /// The machine (`self`, `program`).
    Machine,
    /// Nothing: static without definition; its value is undef.
    Missing,
}

/// A term or rule with the variables bound in it; its parameters are the first variables.
#[derive(Debug)]
pub struct Body<T> {
    /// How many of the variables are parameters.
    pub parameters: usize,
    /// All variables bound anywhere in it, by [`VarId`].
    pub variables: Vec<Variable>,
    /// The term or rule.
    pub root: T,
}

/// A closed term with the variables bound in it.
pub type Expression = Body<Term>;

/// A logical variable.
#[derive(Clone, Debug)]
pub struct Variable {
    /// Its name, with the `$`.
    pub name: Arc<str>,
    /// Its type.
    pub ty: TypeId,
    /// Where it is bound.
    pub span: Span,
}

/// A rule declaration.
#[derive(Debug)]
pub struct Rule {
    /// Its name.
    pub name: Arc<str>,
    /// Turbo rules take values and may return one; macros take terms.
    pub turbo: bool,
    /// The domains of its parameters.
    pub parameters: Vec<TypeId>,
    /// The domain of its result.
    pub result: Option<TypeId>,
    /// Its body; `None` where it had errors.
    pub body: Option<Body<RuleTerm>>,
    /// Where it is declared: its name.
    pub span: Span,
    /// Whether it is declared in a standard library.
    pub library: bool,
    /// What the machine does in its place.
    pub act: Option<asmotion_stdlib::MessageAction>,
}

/// `agent D: r_x[…]`.
#[derive(Debug)]
pub struct AgentProgram {
    /// The agents.
    pub domain: DomainId,
    /// What they run.
    pub rule: RuleId,
    /// Its arguments.
    pub arguments: Vec<Expression>,
}

/// An invariant.
#[derive(Debug)]
pub struct Invariant {
    /// Its name, or the text of the condition.
    pub name: Arc<str>,
    /// The condition.
    pub condition: Expression,
    /// Where it stands.
    pub span: Span,
}

/// A temporal property or a fairness constraint.
#[derive(Debug)]
pub struct TemporalProperty {
    /// Its name, where it has one.
    pub name: Option<Arc<str>>,
    /// Which logic.
    pub logic: PropertyLogic,
    /// The formulas (two for `COMPASSION`).
    pub formulas: Vec<Expression>,
    /// Where it stands.
    pub span: Span,
}

/// What kind of property.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PropertyLogic {
    /// `CTLSPEC`
    Ctl,
    /// `LTLSPEC`
    Ltl,
    /// `INVAR`
    Constraint,
    /// `JUSTICE`
    Justice,
    /// `COMPASSION`
    Compassion,
}

/// A typed term.
#[derive(Clone, Debug)]
pub struct Term {
    /// What it is.
    pub kind: Box<TermKind>,
    /// Its type.
    pub ty: TypeId,
    /// Where it stands.
    pub span: Span,
}

/// The forms of a typed term. Operators are applications of standard functions.
#[derive(Clone, Debug)]
pub enum TermKind {
    /// A constant value.
    Value(Value),
    /// A variable.
    Variable(VarId),
    /// A function applied; as many arguments as it has parameters.
    Apply(FunctionId, Vec<Term>),
    /// A function applied to one tuple that holds all its arguments.
    Spread(FunctionId, Term),
    /// `(t1, …)`
    Tuple(Vec<Term>),
    /// `if`
    If(Term, Term, Option<Term>),
    /// `switch`
    Switch(Term, Vec<(Term, Term)>, Option<Term>),
    /// `let`
    Let(Vec<(VarId, Term)>, Term),
    /// `(forall …)`, `(exists …)`
    Quantified(Quantifier, Vec<Binder>, Option<Term>),
    /// Listed elements.
    Listed(Collection, Vec<Term>),
    /// `from : to, step`
    Interval(Collection, Term, Term, Option<Term>),
    /// Binders, guard, item.
    Comprehension(Collection, Vec<Binder>, Option<Term>, Term),
    /// `{k -> v}`
    Map(Vec<(Term, Term)>),
    /// Binders, guard, key, value.
    MapComprehension(Vec<Binder>, Option<Term>, Term, Term),
    /// `<<r_x>>`
    Rule(RuleId),
    /// A domain as the set of its elements.
    Extent(TypeId),
    /// `person!1`: the element that `extend` gave this name, undef before.
    Element(DomainId, Arc<str>),
    /// A variable outside the rule or term that binds it: there is no value to be had.
    Unbound,
    /// An error was reported.
    Invalid,
}

/// `$x in range`.
#[derive(Clone, Debug)]
pub struct Binder {
    /// The variable.
    pub variable: VarId,
    /// Its range: a set, sequence or bag.
    pub range: Term,
}

/// A resolved rule.
#[derive(Clone, Debug)]
pub struct RuleTerm {
    /// What it is.
    pub kind: Box<RuleKind>,
    /// Where it stands.
    pub span: Span,
}

/// What an update writes.
#[derive(Clone, Debug)]
pub enum UpdateTarget {
    /// A location.
    Location(FunctionId, Vec<Term>),
    /// A variable: a macro parameter that stands for a location, or one that is local state of the
    /// rule that binds it.
    Variable(VarId),
}

/// The forms of a resolved rule.
#[derive(Clone, Debug)]
pub enum RuleKind {
    /// `skip`
    Skip,
    /// `target := value`
    Update(UpdateTarget, Term),
    /// `target <- r_x(…)`
    Assign(UpdateTarget, RuleId, Vec<Term>),
    /// `r_x[…]`, `r_x(…)`: the declaration says whether arguments are terms or values.
    Call(RuleId, Vec<Term>),
    /// A term whose value is a rule.
    Run(Term, Vec<Term>),
    /// `par`
    Par(Vec<RuleTerm>),
    /// `seq`
    Seq(Vec<RuleTerm>),
    /// `if`
    If(Term, RuleTerm, Option<RuleTerm>),
    /// `switch`
    Switch(Term, Vec<(Term, RuleTerm)>, Option<RuleTerm>),
    /// `choose`: binders, guard, body, ifnone
    Choose(Vec<Binder>, Option<Term>, RuleTerm, Option<RuleTerm>),
    /// `forall`
    Forall(Vec<Binder>, Option<Term>, RuleTerm),
    /// `let`
    Let(Vec<(VarId, Term)>, RuleTerm),
    /// `extend`
    Extend(DomainId, Vec<VarId>, RuleTerm),
    /// `while`: until the guard fails or the body changes nothing
    While(Term, RuleTerm),
    /// `whilerec`: until the guard fails
    WhileRec(Term, RuleTerm),
    /// `iterate`: until the body changes nothing
    Iterate(RuleTerm),
    /// `local f: D [R] S`: functions that live as long as the rule runs
    Local(LocalFunctions),
    /// An error was reported.
    Invalid,
}

/// Functions that are local to a run of a rule. All their locations have the number of the run as
/// their first argument, so that runs within each other keep theirs apart.
#[derive(Clone, Debug)]
pub struct LocalFunctions {
    /// Holds the number of the run.
    pub run: VarId,
    /// What gives the functions their first values.
    pub initial: Vec<RuleTerm>,
    /// What is done with them.
    pub body: RuleTerm,
}

impl Model {
    /// A domain by id.
    pub fn domain(&self, id: DomainId) -> &Domain {
        &self.domains[id.0 as usize]
    }

    /// A function by id.
    pub fn function(&self, id: FunctionId) -> &Function {
        &self.functions[id.0 as usize]
    }

    /// A rule by id.
    pub fn rule(&self, id: RuleId) -> &Rule {
        &self.rules[id.0 as usize]
    }

    /// The functions a specification declares itself, libraries left out, in order.
    pub fn own_functions(&self) -> impl Iterator<Item = (FunctionId, &Function)> {
        let all = self.functions.iter().enumerate();
        all.filter(|(_, function)| !function.library)
            .map(|(index, function)| (FunctionId(index as u32), function))
    }

    /// Whether a function says what an agent can be asked: an out function of agents, in a specification
    /// with messages (SCA-ASM).
    pub fn is_operation(&self, function: &Function) -> bool {
        let is_agent = |&ty: &TypeId| {
            let root = self.types.root(ty, &self.domains);
            matches!(self.types.get(root), crate::types::Type::Domain(id) if &*self.domain(*id).name == "Agent")
        };
        let has_messages = || {
            let mut functions = self.functions.iter();
            functions.any(|known| known.library && &*known.name == "nextRequest")
        };
        function.kind == FunctionKind::Out
            && !function.library
            && function.parameters.first().is_some_and(is_agent)
            && has_messages()
    }

    /// A type as text, as in `Prod(Integer,Robot)`.
    pub fn show_type(&self, ty: TypeId) -> String {
        self.types.show(ty, &self.domains)
    }
}

/// What was added to a model.
#[derive(Debug, Default)]
pub struct Added {
    /// The terms.
    pub terms: Vec<Expression>,
    /// The rules.
    pub rules: Vec<Body<RuleTerm>>,
}

impl Added {
    pub(crate) fn term(&mut self, body: Expression) -> AddedTerm {
        self.terms.push(body);
        AddedTerm(self.terms.len() as u32 - 1)
    }

    pub(crate) fn rule(&mut self, body: Body<RuleTerm>) -> AddedRule {
        self.rules.push(body);
        AddedRule(self.rules.len() as u32 - 1)
    }
}

/// The word for a kind of function.
pub(crate) fn kind_name(kind: FunctionKind) -> &'static str {
    match kind {
        FunctionKind::Static => "static",
        FunctionKind::Derived => "derived",
        FunctionKind::Monitored => "monitored",
        FunctionKind::Controlled => "controlled",
        FunctionKind::Shared => "shared",
        FunctionKind::Out => "out",
        FunctionKind::Local => "local",
    }
}
