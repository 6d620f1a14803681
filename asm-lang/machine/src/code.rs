//! Compiled programs: closures for everything, and native code for the main rule where there is some.

use crate::packed::Layout;
use crate::run::{KleeneTruth, RuleStopped, StepContext};
use asmotion_ir::{DomainId, Origin, Program};
use asmotion_value::Value;
use std::fmt;
use std::sync::OnceLock;

/// A term as a closure that gives its value.
pub type TermCode = Box<dyn Fn(&mut StepContext<'_>) -> Value + Send + Sync>;
/// A truth-valued term as a closure.
pub type TruthCode = Box<dyn Fn(&mut StepContext<'_>) -> KleeneTruth + Send + Sync>;
/// A rule as a closure that collects its updates.
pub type RuleCode = Box<dyn Fn(&mut StepContext<'_>) -> Result<(), RuleStopped> + Send + Sync>;

/// Code with a frame of locals of its own.
pub(crate) struct Compiled<T> {
    pub locals: u32,
    pub arguments: u32,
    pub code: T,
    pub origin: Origin,
    pub open: bool,
}

/// A compiled program.
pub(crate) struct CompiledProgram {
    pub bodies: Vec<Compiled<TermCode>>,
    pub routines: Vec<Compiled<RuleCode>>,
    /// For each domain the domains its elements belong to, beginning with itself.
    pub supers: Vec<Vec<DomainId>>,
    /// How states of the program are packed.
    pub layout: Layout,
    /// The main rule as native code. Set when a machine first wants it, and never again: machines
    /// cloned from one another share it.
    pub native: OnceLock<Result<Box<dyn NativeRule>, NoNativeCode>>,
}

/// Compiles main rules to native code. The machine knows this trait alone: the crate that implements
/// it stands above the machine, so that a build without it contains no code generator.
pub trait NativeCompiler: Send + Sync + fmt::Debug {
    /// Compiles the main rule of a program.
    ///
    /// # Errors
    /// There is no native code for this program or this processor. The machine then keeps to its
    /// closures, which do the same steps.
    fn compile(&self, program: &Program) -> Result<Box<dyn NativeRule>, NoNativeCode>;
}

/// A main rule as native code. It may do less than the closures, but nothing else: whatever it cannot
/// do by itself it leaves to the closure of the rule, guard or term at hand.
pub trait NativeRule: Send + Sync {
    /// Runs the main rule at the beginning of a step.
    ///
    /// # Errors
    /// The rule stopped; the run holds the fault.
    fn run(&self, run: &mut StepContext<'_>) -> Result<(), RuleStopped>;
}

/// Why closures do the steps of a machine that was asked for native code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoNativeCode {
    /// This build has no code generator: the cargo feature `native` is off.
    NotBuilt,
    /// The program is a module: it has no main rule.
    NoMainRule,
    /// The program runs in compatibility mode, for which there are only closures.
    Compatible,
    /// The code generator does not know this processor.
    Processor,
    /// The main rule is too large for the code generator.
    TooLarge,
}

impl fmt::Display for NoNativeCode {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        to.write_str(match self {
            Self::NotBuilt => "this build has no native back end (cargo feature `native`)",
            Self::NoMainRule => "a module has no main rule to compile",
            Self::Compatible => "there is no native code for compatibility mode",
            Self::Processor => "there is no native code for this processor",
            Self::TooLarge => "the main rule is too large for native code",
        })
    }
}

impl std::error::Error for NoNativeCode {}
