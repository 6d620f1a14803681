//! The tree of a file, as written: names are text, types are not known, every node has its span.
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

/// Nodes may nest this deep; beyond it the parser reports an error and puts `Invalid`.
pub const MAX_DEPTH: u32 = 400;

/// A name and where it stands. Variables keep their `$`, rules their `r_`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NameText {
    /// The text.
    pub text: Arc<str>,
    /// Where it stands.
    pub span: Span,
}

/// One file: `asm` or `module`.
#[derive(Clone, Debug)]
pub struct File {
    /// `asyncr` in front.
    pub asyncr: bool,
    /// `module` instead of `asm`.
    pub module: bool,
    /// The name after `asm` or `module`; `None` in an empty file.
    pub name: Option<NameText>,
    /// The imports, in order.
    pub imports: Vec<Import>,
    /// What the file lets others see; `None` without an `export` clause.
    pub export: Option<Export>,
    /// Domains declared in the signature, in order.
    pub domains: Vec<Domain>,
    /// Functions declared in the signature, in order.
    pub functions: Vec<Function>,
    /// `domain D = …` in the definitions.
    pub domain_definitions: Vec<DomainDefinition>,
    /// `function f(…) = …` in the definitions.
    pub function_definitions: Vec<FunctionDefinition>,
    /// Rules, the main rule excluded.
    pub rules: Vec<RuleDeclaration>,
    /// Invariants, constraints, fairness and temporal properties, in order.
    pub properties: Vec<Property>,
    /// The main rule.
    pub main: Option<RuleDeclaration>,
    /// The initial states.
    pub inits: Vec<Init>,
    /// `//@…` comments, in order; each belongs to the declaration that follows it.
    pub annotations: Vec<Annotation>,
    /// What could not be read: names that are declared there are not known.
    pub unread: Vec<Span>,
}

/// `import path (names)`.
#[derive(Clone, Debug)]
pub struct Import {
    /// The path as written, without quotes.
    pub path: NameText,
    /// The names asked for; `None` for all.
    pub names: Option<Vec<NameText>>,
}

/// `export * ` or `export names`.
#[derive(Clone, Debug)]
pub struct Export {
    /// The names; `None` for `*`.
    pub names: Option<Vec<NameText>>,
    /// The whole clause.
    pub span: Span,
}

/// A `//@Name(arguments)` comment of the SCA-ASM dialect.
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
    /// Its name; the printed form for a structured domain declared without one.
    pub name: NameText,
    /// What it is.
    pub kind: DomainKind,
    /// `dynamic` in front.
    pub dynamic: bool,
    /// The whole declaration.
    pub span: Span,
}

/// What a declared domain is.
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
    /// A structured domain standing alone in the signature.
    Structured(Type),
}

/// A domain where it is used.
#[derive(Clone, Debug)]
pub struct Type {
    /// What it is.
    pub kind: TypeKind,
    /// Where it stands.
    pub span: Span,
}

/// The forms of a domain in use.
#[derive(Clone, Debug)]
pub enum TypeKind {
    /// A domain by name.
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
    /// Its name.
    pub name: NameText,
    /// Who may write it.
    pub kind: FunctionKind,
    /// The domain; `None` for a function without arguments.
    pub domain: Option<Type>,
    /// The codomain.
    pub codomain: Type,
    /// The whole declaration.
    pub span: Span,
}

/// Who may write a function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FunctionKind {
    /// Nobody: fixed by definition or built in.
    Static,
    /// Nobody: computed from others.
    Derived,
    /// The environment.
    Monitored,
    /// The rules.
    Controlled,
    /// Both.
    Shared,
    /// The rules; read by the environment.
    Out,
    /// The turbo rule that declares it.
    Local,
}

/// `$x in D`.
#[derive(Clone, Debug)]
pub struct Parameter {
    /// The variable, with its `$`.
    pub name: NameText,
    /// Its domain.
    pub domain: Type,
}

/// `domain D = term`, in the definitions or in an initial state.
#[derive(Clone, Debug)]
pub struct DomainDefinition {
    /// The domain.
    pub name: NameText,
    /// Its elements.
    pub body: Term,
}

/// `function f($x in D) = term`, in the definitions or in an initial state.
#[derive(Clone, Debug)]
pub struct FunctionDefinition {
    /// The function.
    pub name: NameText,
    /// Its parameters.
    pub parameters: Vec<Parameter>,
    /// Its value.
    pub body: Term,
}

impl FunctionDefinition {
    /// Whether it says that a constant is itself, as in `function a = a`.
    pub fn is_circular(&self) -> bool {
        match &*self.body.kind {
            TermKind::Apply { name, arguments } => {
                self.parameters.is_empty() && arguments.is_empty() && name.text == self.name.text
            }
            _ => false,
        }
    }
}

/// `rule r_x($a in D) = …`.
#[derive(Clone, Debug)]
pub struct RuleDeclaration {
    /// Its name.
    pub name: NameText,
    /// `turbo` in front.
    pub turbo: bool,
    /// Its parameters.
    pub parameters: Vec<Parameter>,
    /// The domain of a turbo rule's result.
    pub result: Option<Type>,
    /// Its body.
    pub body: Rule,
    /// From the first keyword to the end of the body.
    pub span: Span,
}

/// What is said of the states and runs.
#[derive(Clone, Debug)]
pub struct Property {
    /// Its name, where it has one.
    pub name: Option<NameText>,
    /// What it is.
    pub kind: PropertyKind,
    /// The whole property.
    pub span: Span,
}

/// The forms of a property.
#[derive(Clone, Debug)]
pub enum PropertyKind {
    /// `invariant over …: term`.
    Invariant {
        /// What it speaks about; only the names are checked.
        over: Vec<Over>,
        /// What holds in every state.
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

/// One name after `over`.
#[derive(Clone, Debug)]
pub struct Over {
    /// The domain, function or rule.
    pub name: NameText,
    /// The domain that picks an overload.
    pub domain: Option<Type>,
}

/// `init name: …`.
#[derive(Clone, Debug)]
pub struct Init {
    /// Its name.
    pub name: NameText,
    /// `default` in front.
    pub default: bool,
    /// `domain D = …`.
    pub domains: Vec<DomainDefinition>,
    /// `function f(…) = …`.
    pub functions: Vec<FunctionDefinition>,
    /// `agent D: r_x[]`.
    pub agents: Vec<AgentInit>,
}

/// `agent D: r_x[…]`.
#[derive(Clone, Debug)]
pub struct AgentInit {
    /// The domain of the agents.
    pub domain: NameText,
    /// Their program.
    pub rule: NameText,
    /// Its arguments.
    pub arguments: Vec<Term>,
}
