//! The model: the declarations and definitions of a specification, linked by ids.

use crate::addition::{AddedRule, AddedTerm};
use crate::scope::Scope;
use crate::types::{TypeId, TypeTable};
use asmotion_diagnostics::Span;
use asmotion_syntax::ast;
use asmotion_value::{Atom, RuleId, Value};
use std::sync::Arc;

pub use crate::id::{DomainId, FunctionId};

pub use ast::{Collection, FunctionKind, Quantifier};

/// A variable of one [`Body`]: an index into its `variables`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct VarId(pub u32);

/// A complete specification: the main file and all modules it imports.
#[derive(Debug)]
pub struct Model {
    /// Name after the keyword `asm` or `module` of the main file.
    pub name: Arc<str>,
    /// All types that occur, indexed by [`TypeId`].
    pub types: TypeTable,
    /// All domains, indexed by [`DomainId`]; imported files first, in order of declaration.
    pub domains: Vec<Domain>,
    /// All functions, indexed by [`FunctionId`], in the same order.
    pub functions: Vec<Function>,
    /// All rules, indexed by [`RuleId`], in the same order.
    pub rules: Vec<Rule>,
    /// Enumeration literals and abstract constants, indexed by [`Atom`]; those of one domain have
    /// consecutive numbers.
    pub atoms: Vec<AtomInfo>,
    /// The main rule; `None` for a module.
    pub main: Option<RuleId>,
    /// The programs of agents, from the initial state.
    pub programs: Vec<AgentProgram>,
    /// Conditions that must hold in every state.
    pub invariants: Vec<Invariant>,
    /// Temporal properties, fairness constraints and constraints; of these, runs check only constraints that read inputs.
    pub properties: Vec<TemporalProperty>,
    /// The functions that the machine itself interprets.
    pub reserved: Reserved,
    /// `true` to run as the reference tools do (`--compat asmeta`).
    pub compatible: bool,
    /// Terms and rules added after analysis.
    pub added: Added,
    /// The names visible to added terms and rules.
    pub(crate) scope: Scope,
}

/// The functions that the machine itself interprets. `None` if the specification does not declare
/// or import the function.
#[derive(Clone, Copy, Debug)]
pub struct Reserved {
    /// `self: Agent`, the agent that is running.
    pub self_: Option<FunctionId>,
    /// `program: Agent -> Rule`, the rule that an agent runs.
    pub program: Option<FunctionId>,
    /// `result: Any`, the location of the value that a turbo rule returns.
    pub result: Option<FunctionId>,
    /// The function whose locations hold variables that rules assign. Arguments: the number of the
    /// run of the rule that binds the variable, and the variable's number in it.
    pub variables: FunctionId,
}

/// A declared domain, the ASM book's *universe*.
#[derive(Debug)]
pub struct Domain {
    /// Declared name, for output; references use ids.
    pub name: Arc<str>,
    /// Form of the declaration.
    pub kind: DomainKind,
    /// `true` if declared `dynamic`.
    pub dynamic: bool,
    /// A term for the set of its elements, from the definitions or the initial state. `None` if the
    /// elements follow from the kind of domain.
    pub definition: Option<Expression>,
    /// Span of the name in its declaration.
    pub span: Span,
}

/// The form of a domain's declaration.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DomainKind {
    /// `anydomain`: a type variable in the signatures of functions.
    Any,
    /// `basic domain`: stands for a basic type.
    Basic,
    /// `abstract domain`: its elements are constants and those that `extend` adds.
    Abstract,
    /// `enum domain`: its literals are atoms with consecutive numbers.
    Enum {
        /// Atom of the first literal in source order.
        first: Atom,
        /// Number of literals, at least 1.
        count: u32,
    },
    /// `subsetof`: a concrete domain.
    Concrete {
        /// The type that it is a subset of.
        base: TypeId,
    },
}

impl DomainKind {
    /// The type that a concrete domain is a subset of; `None` for the other kinds.
    pub fn base(&self) -> Option<TypeId> {
        match self {
            Self::Concrete { base } => Some(*base),
            Self::Any | Self::Basic | Self::Abstract | Self::Enum { .. } => None,
        }
    }
}

/// An enumeration literal or an abstract constant.
#[derive(Debug)]
pub struct AtomInfo {
    /// Name as shown in traces and messages.
    pub name: Arc<str>,
    /// The domain that it is an element of.
    pub domain: DomainId,
    /// Span of the name in its declaration.
    pub span: Span,
}

/// A declared function: its signature and the source of its values.
#[derive(Debug)]
pub struct Function {
    /// Declared name; overloads share it.
    pub name: Arc<str>,
    /// Kind of the function, which determines who may update it.
    pub kind: FunctionKind,
    /// Types of its arguments; a `Prod` domain contributes one for each component.
    pub parameters: Vec<TypeId>,
    /// Type of its values.
    pub codomain: TypeId,
    /// Source of its values.
    pub meaning: Meaning,
    /// Values in the initial state; `None` stands for undef everywhere.
    pub initial: Option<Body<Term>>,
    /// Span of the name in its declaration.
    pub span: Span,
    /// Span of the whole declaration, from the keyword for the kind.
    pub declaration: Span,
    /// `true` if declared in a standard library.
    pub library: bool,
    /// For a `local` function, the variable that holds the number of the run of its rule. That
    /// number is the implicit first argument of each of its locations.
    pub run: Option<VarId>,
    /// `true` if annotated `//@Backref`: its value is the sender of the request that the agent is
    /// serving.
    pub is_client: bool,
}

/// The source of a function's values.
#[derive(Debug)]
pub enum Meaning {
    /// The state: controlled, monitored, shared and out functions.
    State,
    /// A term: static and derived functions.
    Defined(Body<Term>),
    /// An implementation in the standard library.
    Builtin(&'static asmotion_stdlib::Builtin),
    /// An element of an abstract domain.
    Constant(Atom),
    /// The machine (`self`, `program`).
    Machine,
    /// None: a static function without a definition is undef everywhere.
    Missing,
}

/// A term or rule with the variables bound in it. The first variables are the parameters.
#[derive(Debug)]
pub struct Body<T> {
    /// Number of parameters, at most the number of variables.
    pub parameters: usize,
    /// All variables bound anywhere in it, indexed by [`VarId`].
    pub variables: Vec<Variable>,
    /// The term or rule itself.
    pub root: T,
}

/// A term whose only variables are bound in it.
pub type Expression = Body<Term>;

/// A logical variable.
#[derive(Clone, Debug)]
pub struct Variable {
    /// Name, including the `$`; empty for a variable that the analysis introduced.
    pub name: Arc<str>,
    /// Type of its values.
    pub ty: TypeId,
    /// Span of the name where it is bound.
    pub span: Span,
}

/// A declared rule, macro or turbo.
#[derive(Debug)]
pub struct Rule {
    /// Declared name, with its prefix `r_`.
    pub name: Arc<str>,
    /// `true` for a turbo rule, which takes arguments by value and may return a result; a macro
    /// takes them by name.
    pub turbo: bool,
    /// Types of its parameters.
    pub parameters: Vec<TypeId>,
    /// Type of a turbo rule's result; `None` if it has none.
    pub result: Option<TypeId>,
    /// Its body; `None` if it had errors.
    pub body: Option<Body<RuleTerm>>,
    /// Span of the name in its declaration.
    pub span: Span,
    /// `true` if declared in a standard library.
    pub library: bool,
    /// For a message rule of the library (`r_wsend`, …), the action that the machine performs
    /// instead of the body.
    pub act: Option<asmotion_stdlib::MessageAction>,
}

/// The program of the agents of a domain: `agent D: r_x[…]` in the initial state.
#[derive(Debug)]
pub struct AgentProgram {
    /// Domain whose elements are the agents.
    pub domain: DomainId,
    /// The rule that each agent runs, its program.
    pub rule: RuleId,
    /// Arguments of the rule.
    pub arguments: Vec<Expression>,
}

/// A condition that must hold in every state.
#[derive(Debug)]
pub struct Invariant {
    /// Declared name; the text of the condition if it has none.
    pub name: Arc<str>,
    /// A term of type Boolean.
    pub condition: Expression,
    /// Span of the declaration.
    pub span: Span,
}

/// A temporal property or a fairness constraint.
#[derive(Debug)]
pub struct TemporalProperty {
    /// Declared name, if it has one.
    pub name: Option<Arc<str>>,
    /// Text of its first formula.
    pub text: Arc<str>,
    /// The keyword that introduces it.
    pub logic: PropertyLogic,
    /// The formulas: two for `COMPASSION`, otherwise one.
    pub formulas: Vec<Expression>,
    /// Span of the declaration.
    pub span: Span,
}

/// The kind of a property, named after its keyword.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PropertyLogic {
    /// `CTLSPEC`
    Ctl,
    /// `LTLSPEC`
    Ltl,
    /// `INVAR`: restricts the states and inputs that a verifier considers.
    Constraint,
    /// `JUSTICE`: holds infinitely often.
    Justice,
    /// `COMPASSION`: if the first formula holds infinitely often, so does the second.
    Compassion,
}

/// A resolved term with its type.
#[derive(Clone, Debug)]
pub struct Term {
    /// Form of the term, with its subterms.
    pub kind: Box<TermKind>,
    /// Type of its values.
    pub ty: TypeId,
    /// Span of the term in its file.
    pub span: Span,
}

/// The forms of a typed term. Operators are applications of standard functions.
#[derive(Clone, Debug)]
pub enum TermKind {
    /// A constant value.
    Value(Value),
    /// The value of a variable.
    Variable(VarId),
    /// A function applied to one argument for each parameter.
    Apply(FunctionId, Vec<Term>),
    /// A function applied to a single tuple that holds all its arguments.
    Spread(FunctionId, Term),
    /// `(t1, …)`
    Tuple(Vec<Term>),
    /// `if`
    If(Term, Term, Option<Term>),
    /// `switch`
    Switch(Term, Vec<(Term, Term)>, Option<Term>),
    /// `let`: the variables with their values, and the term in which they are visible.
    Let(Vec<(VarId, Term)>, Term),
    /// `(forall …)`, `(exists …)`: quantifier, binders and condition.
    Quantified(Quantifier, Vec<Binder>, Option<Term>),
    /// A collection of listed elements.
    Listed(Collection, Vec<Term>),
    /// `from : to, step`: a collection given by its bounds.
    Interval(Collection, Term, Term, Option<Term>),
    /// Collection by comprehension: binders, guard, element.
    Comprehension(Collection, Vec<Binder>, Option<Term>, Term),
    /// `{k -> v}`: a map of listed entries.
    Map(Vec<(Term, Term)>),
    /// Map by comprehension: binders, guard, key, value.
    MapComprehension(Vec<Binder>, Option<Term>, Term, Term),
    /// `<<r_x>>`: a rule as a value.
    Rule(RuleId),
    /// A domain as a term: the set of its elements.
    Extent(TypeId),
    /// `person!1`: the element of this name that `extend` created; undef until it has.
    Element(DomainId, Arc<str>),
    /// A variable outside the rule or term that binds it, for which evaluation has no value.
    Unbound,
    /// Placeholder for a term with an error, which was reported.
    Invalid,
}

impl TermKind {
    /// The function that the term applies; `None` for every other form.
    pub fn function(&self) -> Option<FunctionId> {
        if let Self::Apply(function, _) | Self::Spread(function, _) = self {
            Some(*function)
        } else {
            None
        }
    }

    /// The function that the term applies and its arguments, of which there is one if they stand in a
    /// tuple; `None` for every other form.
    pub fn into_application(self) -> Option<(FunctionId, Vec<Term>)> {
        if let Self::Apply(function, arguments) = self {
            Some((function, arguments))
        } else if let Self::Spread(function, tuple) = self {
            Some((function, vec![tuple]))
        } else {
            None
        }
    }
}

/// A binder `$x in range` of a quantifier, comprehension, `choose` or `forall`.
#[derive(Clone, Debug)]
pub struct Binder {
    /// The variable that ranges over the elements.
    pub variable: VarId,
    /// The range: a set, sequence or bag.
    pub range: Term,
}

/// A resolved rule, the counterpart of a typed term.
#[derive(Clone, Debug)]
pub struct RuleTerm {
    /// Form of the rule, with its parts.
    pub kind: Box<RuleKind>,
    /// Span of the rule in its file.
    pub span: Span,
}

/// The left-hand side of an update.
#[derive(Clone, Debug)]
pub enum UpdateTarget {
    /// A location: a function and its arguments.
    Location(FunctionId, Vec<Term>),
    /// A variable: a macro parameter that stands for a location, or a local variable of the rule
    /// that binds it.
    Variable(VarId),
}

/// The forms of a resolved rule.
#[derive(Clone, Debug)]
pub enum RuleKind {
    /// `skip`
    Skip,
    /// `target := value`
    Update(UpdateTarget, Term),
    /// `target <- r_x(…)`: an update to the result of a turbo rule.
    Assign(UpdateTarget, RuleId, Vec<Term>),
    /// `r_x[…]` or `r_x(…)`; the declaration of the rule decides how arguments are passed.
    Call(RuleId, Vec<Term>),
    /// A term whose value is a rule, with the arguments for that rule.
    Run(Term, Vec<Term>),
    /// `par`: all rules in the same state.
    Par(Vec<RuleTerm>),
    /// `seq`: each rule in the state that the previous one produced.
    Seq(Vec<RuleTerm>),
    /// `if`
    If(Term, RuleTerm, Option<RuleTerm>),
    /// `switch`
    Switch(Term, Vec<(Term, RuleTerm)>, Option<RuleTerm>),
    /// `choose`: binders, guard, body, `ifnone` rule.
    Choose(Vec<Binder>, Option<Term>, RuleTerm, Option<RuleTerm>),
    /// `forall`: binders, guard, body.
    Forall(Vec<Binder>, Option<Term>, RuleTerm),
    /// `let`: the variables with their values, and the rule in which they are visible.
    Let(Vec<(VarId, Term)>, RuleTerm),
    /// `extend`: the domain, the variables for its new elements, and the body.
    Extend(DomainId, Vec<VarId>, RuleTerm),
    /// `while`: repeats until the guard fails or the body yields no update.
    While(Term, RuleTerm),
    /// `whilerec`: repeats until the guard fails.
    WhileRec(Term, RuleTerm),
    /// `iterate`: repeats until the body yields no update.
    Iterate(RuleTerm),
    /// `local f: D [R] S`: functions that exist while the rule runs.
    Local(LocalFunctions),
    /// Placeholder for a rule with an error, which was reported.
    Invalid,
}

/// Functions that are local to a run of a rule. The first argument of all their locations is the
/// number of the run, which separates nested runs.
#[derive(Clone, Debug)]
pub struct LocalFunctions {
    /// The variable that holds the number of the run.
    pub run: VarId,
    /// The rules that initialise the functions.
    pub initial: Vec<RuleTerm>,
    /// The rule in which the functions are visible.
    pub body: RuleTerm,
}

impl Model {
    /// Returns a domain of this model.
    pub fn domain(&self, id: DomainId) -> &Domain {
        &self.domains[id.0 as usize]
    }

    /// Returns a function of this model.
    pub fn function(&self, id: FunctionId) -> &Function {
        &self.functions[id.0 as usize]
    }

    /// Returns a rule of this model.
    pub fn rule(&self, id: RuleId) -> &Rule {
        &self.rules[id.0 as usize]
    }

    /// Iterates over the functions outside the standard libraries, in order of declaration.
    pub fn own_functions(&self) -> impl Iterator<Item = (FunctionId, &Function)> {
        let all = self.functions.iter().enumerate();
        all.filter(|(_, function)| !function.library)
            .map(|(index, function)| (FunctionId(index as u32), function))
    }

    /// Returns `true` if a function declares an operation of a service (SCA-ASM): an out function
    /// whose first argument is an agent, in a specification that imports the message library.
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
}

/// Terms and rules added to a model after its analysis.
#[derive(Debug, Default)]
pub struct Added {
    /// The terms, indexed by [`AddedTerm`].
    pub terms: Vec<Expression>,
    /// The rules, indexed by [`AddedRule`].
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

/// Returns the keyword for a kind of function.
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
