//! Native code: the second back end, for the part of a program that machines spend their time on.
//!
//! The main rule, with the macros it calls built in, becomes one function. It does what needs scalars
//! only: integers, truth values and atoms in registers, locations of known axes read in place, updates
//! that are the first of their slot. The closures stay the reference. Wherever anything else comes up,
//! an undef, an overflow, a second update of a location, native code takes a *detour*: the closure of
//! the rule or guard at hand does it again from its beginning, and finds the value, the fault or the
//! clash as it always would. That is the same, because terms can be evaluated twice: they change
//! nothing, and what was asked of the environment holds for the whole step. So a step is the same
//! whichever back end does it.

mod emit;
mod frame;
mod known;
mod location;
mod memory;
mod rule;
mod sequence;
mod term;
mod truth;

use crate::compile::{Compiler, RuleCode, TermCode, TruthCode};
use crate::run::{Run, Stopped};
use asmotion_ir::{Program, RoutineId};
use cranelift_codegen::settings::{self, Configurable};
use cranelift_frontend::{FunctionBuilder, FunctionBuilderContext};
use cranelift_jit::{JITBuilder, JITModule};
use cranelift_module::{Linkage, Module, default_libcall_names};
use emit::Emitter;
use frame::{Entry, Frame};

/// A main rule as native code.
pub(crate) struct Native {
    entry: Entry,
    /// What is done by closures.
    detours: Vec<Detour>,
    /// How many locals there are, those of the macros built in included.
    locals: u32,
    /// Where the code is.
    _memory: memory::Memory,
}

/// A way around native code.
pub(crate) enum Detour {
    Rule(RuleCode),
    Truth(TruthCode),
    Term(TermCode),
}

impl Native {
    /// Compiles the main rule; `None` where there is none, where the program runs
    /// as in other tools, or where there is no native code for the processor.
    pub fn of(program: &Program) -> Option<Self> {
        let main = program.main.filter(|_| !program.compatible)?;
        let mut module = module()?;
        let compiled = compile(program, main, &mut module);
        // the module's memory is freed whatever became of it
        let memory = memory::Memory::new(module);
        let (function, detours, locals) = compiled?;
        Some(Self {
            entry: memory.entry(function)?,
            detours,
            locals,
            _memory: memory,
        })
    }

    /// Runs the main rule.
    #[inline]
    pub fn run(&self, run: &mut Run<'_>) -> Result<(), Stopped> {
        Frame::enter(run, self.entry, &self.detours, self.locals as usize)
    }
}

fn module() -> Option<JITModule> {
    if cfg!(target_endian = "big") || cfg!(not(target_pointer_width = "64")) {
        return None;
    }
    let mut flags = settings::builder();
    flags.set("use_colocated_libcalls", "false").ok()?;
    flags.set("is_pic", "false").ok()?;
    flags.set("opt_level", "speed").ok()?;
    flags
        .set(
            "enable_verifier",
            if cfg!(debug_assertions) {
                "true"
            } else {
                "false"
            },
        )
        .ok()?;
    let isa = cranelift_native::builder().ok()?;
    let isa = isa.finish(settings::Flags::new(flags)).ok()?;
    let builder = JITBuilder::with_isa(isa, default_libcall_names());
    Some(JITModule::new(builder))
}

/// The function, what it leaves to closures, and how many locals it needs.
fn compile(
    program: &Program,
    main: RoutineId,
    module: &mut JITModule,
) -> Option<(cranelift_module::FuncId, Vec<Detour>, u32)> {
    let signature = emit::entry_signature(module);
    let function = module
        .declare_function("main", Linkage::Local, &signature)
        .ok()?;
    let mut context = module.make_context();
    context.func.signature = signature;
    let mut scratch = FunctionBuilderContext::new();
    let compiler = Compiler::of(program);
    let builder = FunctionBuilder::new(&mut context.func, &mut scratch);
    let emitter = Emitter::new(program, &compiler, builder, module);
    let (detours, locals) = emitter.main(main, module.target_config());
    module.define_function(function, &mut context).ok()?;
    module.finalize_definitions().ok()?;
    Some((function, detours, locals))
}
