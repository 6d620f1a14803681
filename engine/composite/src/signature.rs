//! What a composite must know of an `.asm` file: its functions. The language crates stay outside.

use asmotion_diagnostics::{Report, Sources, Span};

/// Opens specifications.
pub trait Specifications {
    /// The signature of the specification at `path`, which is as the loader resolved it. Its text
    /// is added to `sources`, so that findings can point into it.
    ///
    /// `Ok(None)` where specifications cannot be opened here: their bindings are then believed.
    ///
    /// # Errors
    /// What is wrong with the specification.
    fn open(&self, path: &str, sources: &mut Sources)
    -> Result<Option<Box<dyn Signature>>, Report>;
}

/// Opens nothing: bindings are believed.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoSpecifications;

impl Specifications for NoSpecifications {
    fn open(&self, _: &str, _: &mut Sources) -> Result<Option<Box<dyn Signature>>, Report> {
        Ok(None)
    }
}

/// The functions of a specification.
pub trait Signature {
    /// All functions that are declared, libraries left out.
    fn functions(&self) -> Vec<FunctionInfo>;

    /// The function of this name.
    fn function(&self, name: &str) -> Option<FunctionInfo> {
        self.functions()
            .into_iter()
            .find(|function| function.name == name)
    }

    /// The first operation of a partner for whose answer the specification waits, and where it does.
    fn awaits(&self, partner: &str) -> Option<(String, Span)> {
        let _ = partner;
        None
    }

    /// What the annotations of SCA-ASM say of its services and references; nothing where there are none.
    fn annotations(&self) -> Annotations {
        Annotations::default()
    }

    /// The main rule and its place.
    fn main_rule(&self) -> Option<(String, Span)>;
}

/// The component type that stands in a specification: `//@Reference`, `//@MainService`, `//@Provided`,
/// `//@Service`, `//@Required`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Annotations {
    /// Functions under `//@Reference`, each with the domain of the partner it leads to.
    pub references: Vec<Annotated>,
    /// Modules under `//@MainService` or `//@Provided`, which are imported.
    pub provided: Vec<Annotated>,
}

/// Something that is annotated.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Annotated {
    /// The function, or the module.
    pub name: String,
    /// The last part of the interface: the domain of the partner, or the module.
    pub interface: String,
    /// Where it stands.
    pub declared: Span,
}

/// A function of a specification.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FunctionInfo {
    /// Its name.
    pub name: String,
    /// Who may write it.
    pub kind: FunctionKind,
    /// Its domain as written; empty for a function without arguments.
    pub domain: String,
    /// What its values are.
    pub codomain: Codomain,
    /// Where it is declared.
    pub declared: Span,
}

/// Who may write a function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FunctionKind {
    /// The environment.
    Monitored,
    /// The environment and the specification.
    Shared,
    /// The specification, for the environment to read.
    Out,
    /// The specification.
    Controlled,
    /// Nobody.
    Static,
    /// Nobody: it follows from the others.
    Derived,
    /// One rule, for itself.
    Local,
}

impl FunctionKind {
    /// The keyword.
    pub fn word(self) -> &'static str {
        match self {
            Self::Monitored => "monitored",
            Self::Shared => "shared",
            Self::Out => "out",
            Self::Controlled => "controlled",
            Self::Static => "static",
            Self::Derived => "derived",
            Self::Local => "local",
        }
    }
}

/// What the values of a function are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Codomain {
    /// Truth values.
    Boolean,
    /// Whole numbers: `Integer`, `Natural` and their subsets.
    Integer,
    /// Numbers.
    Real,
    /// Texts.
    Text,
    /// The literals of an enum domain.
    Enum {
        /// The domain.
        name: String,
        /// Its literals in order.
        literals: Vec<String>,
        /// Where it is declared.
        declared: Option<Span>,
    },
    /// Anything else, as written.
    Other(String),
}

impl Codomain {
    /// Its name, for people.
    pub fn name(&self) -> &str {
        match self {
            Self::Boolean => "Boolean",
            Self::Integer => "Integer",
            Self::Real => "Real",
            Self::Text => "String",
            Self::Enum { name, .. } | Self::Other(name) => name,
        }
    }
}
