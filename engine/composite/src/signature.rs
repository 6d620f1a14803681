//! Interface to the functions declared in an `.asm` file; avoids a dependency on the language crates.

use std::collections::{BTreeMap, BTreeSet};

use asmotion_coordinator::{LocationArgument, LocationName};
use asmotion_diagnostics::{Report, Sources, Span};

/// Loader of specifications.
pub trait Specifications {
    /// Returns the signature of the specification at the resolved `path` and adds its text to `sources`.
    ///
    /// Returns `Ok(None)` if specifications are not supported; bindings are then not checked.
    ///
    /// # Errors
    ///
    /// The diagnostics of an invalid specification.
    fn open(&self, path: &str, sources: &mut Sources)
    -> Result<Option<Box<dyn Signature>>, Report>;
}

/// Loads no specifications; bindings are not checked.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoSpecifications;

impl Specifications for NoSpecifications {
    fn open(&self, _: &str, _: &mut Sources) -> Result<Option<Box<dyn Signature>>, Report> {
        Ok(None)
    }
}

/// The kinds of properties that a specification states.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StatedProperties {
    /// `CTLSPEC`
    pub ctl: bool,
    /// `LTLSPEC`
    pub ltl: bool,
    /// `invariant`
    pub invariants: bool,
}

/// Functions of a specification.
pub trait Signature {
    /// Returns the kinds of properties that the specification states; `None` if that is not known.
    fn stated_properties(&self) -> Option<StatedProperties> {
        None
    }

    /// Returns the warnings of the specification that concern its runs in a composite.
    fn warnings(&self) -> Report {
        Report::new()
    }

    /// Returns all declared functions except those of libraries.
    fn functions(&self) -> &[FunctionInfo];

    /// Returns the function of this name.
    fn function(&self, name: &str) -> Option<&FunctionInfo> {
        let mut functions = self.functions().iter();
        functions.find(|function| function.name == name)
    }

    /// Returns the type of a term; `None` if it is not known.
    ///
    /// # Errors
    ///
    /// The first error in the term, as text.
    fn term(&self, text: &str) -> Result<Option<Codomain>, String> {
        let _ = text;
        Ok(None)
    }

    /// Checks a rule in the scope of the specification.
    ///
    /// # Errors
    ///
    /// The first error in the rule, as text.
    fn rule(&self, text: &str) -> Result<(), String> {
        let _ = text;
        Ok(())
    }

    /// Returns the first operation of a partner whose reply the specification awaits, and the location of the call.
    fn awaits(&self, partner: &str) -> Option<(String, Span)> {
        let _ = partner;
        None
    }

    /// Returns whether the specification exchanges messages with partners, which need no bindings; `None` if it is not known.
    fn exchanges_messages(&self) -> Option<bool> {
        None
    }

    /// Returns the services and references annotated with SCA-ASM; empty without annotations.
    fn annotations(&self) -> Annotations {
        Annotations::default()
    }

    /// Returns the control states that rules enter and none leaves, except those that a comment `//@Final` names.
    fn states_without_exit(&self) -> &[EnteredState] {
        &[]
    }

    /// Returns the names of the functions that the specification or one of the terms reads; `None` if they are not known.
    fn read_functions(&self, terms: &[&str]) -> Option<BTreeSet<String>> {
        let _ = terms;
        None
    }

    /// Returns the literals with which the specification compares values, and which no function takes if the environment
    /// gives the functions in `inputs` only these literals. Literals that no input could make reachable are not among them.
    fn missing_literals(&self, inputs: &BTreeMap<String, BTreeSet<String>>) -> Vec<MissingLiteral> {
        let _ = inputs;
        Vec::new()
    }

    /// Makes the first step with these values of bound functions. If it fails because something is undef, returns the functions
    /// without whose values it does, by name, and the place of what needs them.
    fn undefined_at_start(&self, values: &BTreeMap<String, StartValue>) -> Vec<(String, Span)> {
        let _ = values;
        Vec::new()
    }

    /// Returns the name and location of the main rule.
    fn main_rule(&self) -> Option<(String, Span)>;
}

/// The value of a bound function before the first message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum StartValue {
    /// None.
    Undef,
    /// A truth value.
    Bool(bool),
    /// A number.
    Int(i64),
    /// The name of a literal, or a string.
    Text(String),
}

/// A literal that no input of the composite yields.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MissingLiteral {
    /// The literal.
    pub literal: String,
    /// Name of its enumeration.
    pub domain: String,
    /// Location of the first comparison with it.
    pub compared: Span,
}

/// A control state that a rule enters.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EnteredState {
    /// Name of the function with the control state.
    pub function: String,
    /// Literal of the state.
    pub state: String,
    /// Location of an update that enters it.
    pub entered: Span,
}

/// Component type declared by the annotations of a specification: `//@Reference`, `//@MainService`, `//@Provided`,
/// `//@Service`, `//@Required`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Annotations {
    /// Functions annotated with `//@Reference`, with the domain of the partner.
    pub references: Vec<Annotated>,
    /// Imported modules annotated with `//@MainService` or `//@Provided`.
    pub provided: Vec<Annotated>,
    /// Control states named by `//@Final`, in which a coordinator may stay.
    pub final_states: Vec<String>,
    /// Functions of a protocol annotated with `//@Port`.
    pub ports: Vec<AnnotatedPort>,
    /// Texts of `//@Echo` in a protocol, with their locations.
    pub echoes: Vec<(String, Span)>,
}

/// A function of a protocol with the port or operation that it stands for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AnnotatedPort {
    /// Name of the function.
    pub function: String,
    /// Port or operation, with a field, as written.
    pub end: String,
    /// Source location of the annotation.
    pub at: Span,
}

/// An annotated function or module.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Annotated {
    /// Function or module name.
    pub name: String,
    /// Last segment of the interface name: the domain of the partner or the module.
    pub interface: String,
    /// Source location of the declaration.
    pub declared: Span,
}

/// A function of a specification.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FunctionInfo {
    /// Name of the function.
    pub name: String,
    /// Kind, which determines who may write it.
    pub kind: FunctionKind,
    /// Domain as written; empty for a function without arguments.
    pub domain: String,
    /// Parameters; empty for a function without arguments.
    pub parameters: Vec<ParameterInfo>,
    /// Type of the values.
    pub codomain: Codomain,
    /// Source location of the declaration.
    pub declared: Span,
}

impl FunctionInfo {
    /// Returns an example of a binding to a topic: of the first of the locations, or of all locations if there are none.
    pub fn binding_example(&self, locations: &[String]) -> String {
        if let Some(first) = locations.first() {
            return format!("\"{first}\" = {{ topic = \"…\" }}");
        }
        // a pattern needs the elements of each domain
        if self.parameters.iter().any(|it| it.elements.is_none()) {
            return format!("\"{}(…)\" = {{ topic = \"…\" }}", self.name);
        }
        let pattern = self.pattern();
        match pattern.variables().next() {
            None => format!("{} = {{ topic = \"…\" }}", self.name),
            Some(first) => format!("\"{pattern}\" = {{ topic = \"${first}/…\" }}"),
        }
    }

    /// Returns the location that stands for all locations of the function: `wants($r)` for `wants: Robot -> Boolean`.
    pub fn pattern(&self) -> LocationName {
        let variables = self.parameters.iter().enumerate().map(|(at, parameter)| {
            let first = parameter
                .name
                .chars()
                .next()
                .filter(char::is_ascii_alphabetic);
            let first = first.unwrap_or('x').to_ascii_lowercase();
            let mut before = self.parameters.iter().take(at);
            let is_taken = before.any(|it| it.name.to_lowercase().starts_with(first));
            LocationArgument::Variable(if is_taken {
                format!("{first}{}", at + 1)
            } else {
                first.to_string()
            })
        });
        LocationName {
            function: self.name.clone(),
            arguments: variables.collect(),
        }
    }
}

/// A parameter of a function.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ParameterInfo {
    /// Domain as written.
    pub name: String,
    /// Type of the arguments.
    pub domain: Codomain,
    /// Names of the elements in ascending order; `None` if the domain is not finite, too large, or not known before the
    /// run.
    pub elements: Option<Vec<String>>,
}

/// Kind of a function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FunctionKind {
    /// Written by the environment.
    Monitored,
    /// Written by the environment and the specification.
    Shared,
    /// Written by the specification and read by the environment.
    Out,
    /// Written by the specification.
    Controlled,
    /// Constant.
    Static,
    /// Computed from other functions.
    Derived,
    /// Local to a rule.
    Local,
}

impl FunctionKind {
    /// Returns the keyword.
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

/// Type of the values of a function.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Codomain {
    /// Boolean values.
    Boolean,
    /// Integers: `Integer`, `Natural` and their subsets.
    Integer,
    /// Real numbers.
    Real,
    /// Strings.
    Text,
    /// Literals of an enumeration.
    Enum {
        /// Name of the domain.
        name: String,
        /// Literals in declaration order.
        literals: Vec<String>,
        /// Source location of the declaration; `None` for library domains.
        declared: Option<Span>,
    },
    /// Sequences, sets and bags.
    List {
        /// The domain as written.
        name: String,
        /// Codomain of the elements.
        item: Box<Codomain>,
    },
    /// Tuples.
    Tuple {
        /// The domain as written.
        name: String,
        /// Codomains of the components.
        items: Vec<Codomain>,
    },
    /// Maps, whose keys are the names of fields.
    Map {
        /// The domain as written.
        name: String,
        /// Codomain of the keys.
        key: Box<Codomain>,
        /// Codomain of the values.
        item: Box<Codomain>,
    },
    /// Single characters.
    Character,
    /// Elements of an abstract domain, which texts name.
    Abstract(String),
    /// Any other domain, as written.
    Other(String),
}

impl Codomain {
    /// Returns the name for use in messages.
    pub fn name(&self) -> &str {
        match self {
            Self::Boolean => "Boolean",
            Self::Integer => "Integer",
            Self::Real => "Real",
            Self::Text => "String",
            Self::Character => "Char",
            Self::Enum { name, .. }
            | Self::List { name, .. }
            | Self::Tuple { name, .. }
            | Self::Map { name, .. }
            | Self::Abstract(name)
            | Self::Other(name) => name,
        }
    }
}
