//! Compiled programs: closures for everything, optionally with native code for the main rule.

use crate::direct::DirectRule;
use crate::packed::Layout;
use crate::run::{KleeneTruth, RuleStopped, StepContext};
use asmotion_ir::{DomainId, Origin, Program};
use asmotion_value::Value;
use std::fmt;
use std::sync::OnceLock;
use std::sync::atomic::AtomicBool;

/// A compiled term: a closure that returns its value.
pub type TermCode = Box<dyn Fn(&mut StepContext<'_>) -> Value + Send + Sync>;
/// A compiled term of type Boolean: a closure that returns its truth value.
pub type TruthCode = Box<dyn Fn(&mut StepContext<'_>) -> KleeneTruth + Send + Sync>;
/// A compiled rule: a closure that adds its updates to the innermost set.
pub type RuleCode = Box<dyn Fn(&mut StepContext<'_>) -> Result<(), RuleStopped> + Send + Sync>;

/// Compiled code with a frame of its own.
pub(crate) struct Compiled<T> {
    pub locals: u32,
    pub arguments: u32,
    pub code: T,
    pub origin: Origin,
    pub open: bool,
}

/// A program compiled to closures.
pub(crate) struct CompiledProgram {
    pub bodies: Vec<Compiled<TermCode>>,
    pub routines: Vec<Compiled<RuleCode>>,
    /// For each domain, the domain itself and all domains it is a subset of.
    pub supers: Vec<Vec<DomainId>>,
    /// Encoding of the program's states.
    pub layout: Layout,
    /// The main rule as native code. Initialised at most once, when a machine first needs it, and
    /// shared by the machines cloned from each other.
    pub native: OnceLock<Result<Box<dyn NativeRule>, NoNativeCode>>,
    /// The main rule as native code for whole steps; `None` if it is not suitable.
    pub direct: OnceLock<Option<Box<dyn DirectRule>>>,
    /// `true` once a thread compiles the main rule: for direct steps, and with detours.
    pub is_compiling: [AtomicBool; 2],
    /// Number of rules.
    pub rules: u64,
}

/// Compiles main rules to native code. The implementing crate depends on the machine, which only
/// knows this trait, so a build without that crate contains no code generator.
pub trait NativeCompiler: Send + Sync + fmt::Debug {
    /// Compiles the main rule of a program.
    ///
    /// # Errors
    /// The program or the processor is not supported. The machine then uses closures, which execute
    /// the same steps.
    fn compile(&self, program: &Program) -> Result<Box<dyn NativeRule>, NoNativeCode>;

    /// Compiles the main rule of a program for direct steps from a state with these slots; `None` if it is not suitable for
    /// them.
    fn compile_direct(&self, program: &Program, slots: &[Value]) -> Option<Box<dyn DirectRule>>;
}

/// A main rule as native code. It may leave any part of the rule to the closure of that part, but
/// must not behave differently.
pub trait NativeRule: Send + Sync {
    /// Runs the main rule at the start of a step.
    ///
    /// # Errors
    /// The rule stopped; the context holds the fault.
    fn run(&self, run: &mut StepContext<'_>) -> Result<(), RuleStopped>;
}

/// The reason that a machine uses closures although native code was requested.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoNativeCode {
    /// The build has no code generator: the cargo feature `native` is off.
    NotBuilt,
    /// The program is a module, which has no main rule.
    NoMainRule,
    /// The program runs in compatibility mode, which only closures support.
    Compatible,
    /// The code generator does not support this processor.
    Processor,
    /// The main rule exceeds the size limit of the code generator.
    TooLarge,
}

impl fmt::Display for NoNativeCode {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        to.write_str(match self {
            Self::NotBuilt => "this build has no native back end (cargo feature `native`)",
            Self::NoMainRule => "a module has no main rule to compile",
            Self::Compatible => "native code does not support compatibility mode",
            Self::Processor => "native code does not support this processor",
            Self::TooLarge => "the main rule is too large for native code",
        })
    }
}

impl std::error::Error for NoNativeCode {}
