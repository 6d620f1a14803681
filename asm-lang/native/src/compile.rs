//! From a program to native code.

use crate::detour::Detour;
use crate::emit::{Emitter, entry_signature};
use crate::frame::{NativeEntry, NativeFrame};
use crate::memory::CodeMemory;
use asmotion_ir::{Program, RoutineId};
use asmotion_machine::back_end::{
    Compiler, NativeCompiler, NativeRule, NoNativeCode, RuleStopped, StepContext,
};
use cranelift_codegen::settings::{self, Configurable};
use cranelift_frontend::{FunctionBuilder, FunctionBuilderContext};
use cranelift_jit::{JITBuilder, JITModule};
use cranelift_module::{FuncId, Linkage, Module, default_libcall_names};

/// Compiles main rules with Cranelift, for the processor that the program runs on.
#[derive(Clone, Copy, Debug, Default)]
pub struct Cranelift;

impl NativeCompiler for Cranelift {
    fn compile(&self, program: &Program) -> Result<Box<dyn NativeRule>, NoNativeCode> {
        if program.compatible {
            return Err(NoNativeCode::Compatible);
        }
        let main = program.main.ok_or(NoNativeCode::NoMainRule)?;
        let mut module = module().ok_or(NoNativeCode::Processor)?;
        let compiled = compile(program, main, &mut module);
        // the module's memory is freed, whatever became of it
        let memory = CodeMemory::new(module);
        let (function, detours, locals) = compiled.ok_or(NoNativeCode::TooLarge)?;
        Ok(Box::new(MainRule {
            entry: memory.entry(function).ok_or(NoNativeCode::Processor)?,
            detours,
            locals,
            _memory: memory,
        }))
    }
}

/// A main rule as native code.
struct MainRule {
    entry: NativeEntry,
    /// What is done by closures.
    detours: Vec<Detour>,
    /// How many locals there are, those of the macros built in included.
    locals: u32,
    /// Where the code is.
    _memory: CodeMemory,
}

impl NativeRule for MainRule {
    #[inline]
    fn run(&self, run: &mut StepContext<'_>) -> Result<(), RuleStopped> {
        NativeFrame::enter(run, self.entry, &self.detours, self.locals as usize)
    }
}

/// An empty module for this processor. Native code reads values by their layout in memory, which is
/// that of little-endian machines with pointers of 64 bits.
fn module() -> Option<JITModule> {
    if cfg!(target_endian = "big") || cfg!(not(target_pointer_width = "64")) {
        return None;
    }
    let verifies = match cfg!(debug_assertions) {
        true => "true",
        false => "false",
    };
    let mut flags = settings::builder();
    flags.set("use_colocated_libcalls", "false").ok()?;
    flags.set("is_pic", "false").ok()?;
    flags.set("opt_level", "speed").ok()?;
    flags.set("enable_verifier", verifies).ok()?;
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
) -> Option<(FuncId, Vec<Detour>, u32)> {
    let signature = entry_signature(module);
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
