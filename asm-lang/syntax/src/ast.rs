//! The syntax tree of a file: names are text, types are unknown, every node has its span.
//!
//! One file a family, named like the files of the later stages: [`term`], [`rule`], [`scenario`]; the
//! sections of a file stand here.

pub mod rule;
pub mod scenario;
pub mod term;

pub use rule::{Assignee, Rule, RuleKind, SwitchRule};
pub use scenario::{
    Pick, PickedRule, Scenario, ScenarioBlock, ScenarioCommand, ScenarioCommandKind,
    ScenarioInvariant,
};
pub use term::{
    Binder, ChainLink, Collection, Comprehension, Interval, Literal, Operator, Quantifier, Term,
    TermKind,
};

use asmotion_diagnostics::Span;
use std::sync::Arc;

/// Limit for the nesting of nodes. A node beyond it is reported and replaced by `Invalid`.
pub const MAX_DEPTH: u32 = 400;

/// A name with its span. Variables include their `$`, rules their `r_`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NameText {
    /// The name as written.
    pub text: Arc<str>,
    /// Span of the name.
    pub span: Span,
}

/// The contents of one file, an `asm` or a `module`.
#[derive(Clone, Debug)]
pub struct File {
    /// `true` with the keyword `asyncr`.
    pub asyncr: bool,
    /// `true` for a `module`, `false` for an `asm`.
    pub module: bool,
    /// The name after `asm` or `module`; `None` if the heading is missing.
    pub name: Option<NameText>,
    /// The imports, in source order.
    pub imports: Vec<Import>,
    /// The exported names; `None` without an `export` clause.
    pub export: Option<Export>,
    /// Domains declared in the signature, in source order.
    pub domains: Vec<Domain>,
    /// Functions declared in the signature, in source order.
    pub functions: Vec<Function>,
    /// `domain D = …` in the definitions, in source order.
    pub domain_definitions: Vec<DomainDefinition>,
    /// `function f(…) = …` in the definitions, in source order.
    pub function_definitions: Vec<FunctionDefinition>,
    /// Rule declarations except the main rule, in source order.
    pub rules: Vec<RuleDeclaration>,
    /// Invariants, constraints, fairness and temporal properties, in source order.
    pub properties: Vec<Property>,
    /// The main rule; `None` in a module.
    pub main: Option<RuleDeclaration>,
    /// The initial states, in source order.
    pub inits: Vec<Init>,
    /// `//@…` comments, in source order; each annotates the declaration that follows it.
    pub annotations: Vec<Annotation>,
    /// Spans that could not be parsed. Names declared in them are unknown, so later stages suppress
    /// findings about such names.
    pub unread: Vec<Span>,
}

/// An import: `import path (names)`.
#[derive(Clone, Debug)]
pub struct Import {
    /// The path as written, without quotes.
    pub path: NameText,
    /// The names to import; `None` for all.
    pub names: Option<Vec<NameText>>,
}

/// An export clause: `export *` or `export names`.
#[derive(Clone, Debug)]
pub struct Export {
    /// The exported names; `None` for `*`.
    pub names: Option<Vec<NameText>>,
    /// Span of the clause.
    pub span: Span,
}

/// An annotation of the SCA-ASM dialect: `//@Name(arguments)`.
#[derive(Clone, Debug)]
pub struct Annotation {
    /// The word after `@`, as in `Required`.
    pub name: NameText,
    /// The rest of the line, trimmed.
    pub rest: String,
}

/// A domain declared in the signature.
#[derive(Clone, Debug)]
pub struct Domain {
    /// Declared name; for a structured domain without one, its text.
    pub name: NameText,
    /// Form of the declaration.
    pub kind: DomainKind,
    /// `true` with the keyword `dynamic`.
    pub dynamic: bool,
    /// Span of the declaration.
    pub span: Span,
}

/// The form of a domain's declaration.
#[derive(Clone, Debug)]
pub enum DomainKind {
    /// `domain D subsetof T`.
    Concrete(Type),
    /// `anydomain D`.
    Any,
    /// `basic domain Integer`.
    Basic,
    /// `abstract domain D`.
    Abstract,
    /// `enum domain D = {A | B}`.
    Enum(Vec<NameText>),
    /// A structured domain without a name of its own.
    Structured(Type),
}

/// A domain in use, as opposed to its declaration.
#[derive(Clone, Debug)]
pub struct Type {
    /// Form of the domain.
    pub kind: TypeKind,
    /// Span of the domain.
    pub span: Span,
}

/// The forms of a domain in use.
#[derive(Clone, Debug)]
pub enum TypeKind {
    /// A domain referred to by name.
    Named(Arc<str>),
    /// `Rule` or `Rule(D1, …)`.
    Rule(Vec<Type>),
    /// `Prod(D1, D2, …)`.
    Prod(Vec<Type>),
    /// `Seq(D)`.
    Seq(Box<Type>),
    /// `Powerset(D)`.
    Powerset(Box<Type>),
    /// `Bag(D)`.
    Bag(Box<Type>),
    /// `Map(D1, D2)`.
    Map(Box<Type>, Box<Type>),
}

/// A function declared in the signature.
#[derive(Clone, Debug)]
pub struct Function {
    /// Declared name.
    pub name: NameText,
    /// Kind, from the keyword.
    pub kind: FunctionKind,
    /// Domain of the arguments; `None` for a function without arguments.
    pub domain: Option<Type>,
    /// Domain of the values.
    pub codomain: Type,
    /// Span of the declaration.
    pub span: Span,
}

/// The kind of a function, which determines who may update it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FunctionKind {
    /// Never updated: fixed by its definition or built in.
    Static,
    /// Never updated: computed from other functions.
    Derived,
    /// Updated by the environment.
    Monitored,
    /// Updated by rules only; the environment neither sets nor observes it.
    Controlled,
    /// Updated by rules and by the environment.
    Shared,
    /// Updated by rules, observed by the environment.
    Out,
    /// Updated by the rule that declares it, and local to it.
    Local,
}

/// A parameter: `$x in D`.
#[derive(Clone, Debug)]
pub struct Parameter {
    /// Variable, including its `$`.
    pub name: NameText,
    /// Domain of the parameter.
    pub domain: Type,
}

/// `domain D = term`, in the definitions or in an initial state.
#[derive(Clone, Debug)]
pub struct DomainDefinition {
    /// Name of the domain.
    pub name: NameText,
    /// Term for the set of its elements.
    pub body: Term,
}

/// `function f($x in D) = term`, in the definitions or in an initial state.
#[derive(Clone, Debug)]
pub struct FunctionDefinition {
    /// Name of the function.
    pub name: NameText,
    /// Parameters; their domains select the overload.
    pub parameters: Vec<Parameter>,
    /// Term for its value.
    pub body: Term,
}

impl FunctionDefinition {
    /// Returns `true` if the definition has the form `function a = a`, which some models use to
    /// declare a constant.
    pub fn is_circular(&self) -> bool {
        let TermKind::Apply { name, arguments } = &*self.body.kind else {
            return false;
        };
        self.parameters.is_empty() && arguments.is_empty() && name.text == self.name.text
    }
}

/// A rule declaration: `rule r_x($a in D) = …`.
#[derive(Clone, Debug)]
pub struct RuleDeclaration {
    /// Declared name, including `r_`.
    pub name: NameText,
    /// `true` with the keyword `turbo`.
    pub turbo: bool,
    /// Parameters, in order.
    pub parameters: Vec<Parameter>,
    /// Domain of a turbo rule's result; `None` if not declared.
    pub result: Option<Type>,
    /// Body of the rule.
    pub body: Rule,
    /// From the first keyword to the end of the body.
    pub span: Span,
}

/// A property of states or runs.
#[derive(Clone, Debug)]
pub struct Property {
    /// Name, if it has one.
    pub name: Option<NameText>,
    /// Kind, with its formulas.
    pub kind: PropertyKind,
    /// Span of the property.
    pub span: Span,
}

/// The kinds of a property.
#[derive(Clone, Debug)]
pub enum PropertyKind {
    /// `invariant over …: term`.
    Invariant {
        /// Names after `over`, which are checked but have no further effect.
        over: Vec<Over>,
        /// Condition that holds in every state.
        body: Term,
    },
    /// `INVAR term`.
    Constraint(Term),
    /// `JUSTICE term`.
    Justice(Term),
    /// `COMPASSION(p, q)`.
    Compassion(Term, Term),
    /// `CTLSPEC term`.
    Ctl(Term),
    /// `LTLSPEC term`.
    Ltl(Term),
}

/// A name after `over`.
#[derive(Clone, Debug)]
pub struct Over {
    /// Name of a domain, function or rule.
    pub name: NameText,
    /// Domain that selects an overload; `None` if not given.
    pub domain: Option<Type>,
}

/// An initial state: `init name: …`.
#[derive(Clone, Debug)]
pub struct Init {
    /// Name of the initial state.
    pub name: NameText,
    /// `true` with the keyword `default`.
    pub default: bool,
    /// `domain D = …`, in source order.
    pub domains: Vec<DomainDefinition>,
    /// `function f(…) = …`, in source order.
    pub functions: Vec<FunctionDefinition>,
    /// `agent D: r_x[]`, in source order.
    pub agents: Vec<AgentInit>,
}

/// The program of agents in an initial state: `agent D: r_x[…]`.
#[derive(Clone, Debug)]
pub struct AgentInit {
    /// Domain of the agents.
    pub domain: NameText,
    /// Rule that they run.
    pub rule: NameText,
    /// Arguments of the rule.
    pub arguments: Vec<Term>,
}
