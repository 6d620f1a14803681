//! Compiles the main rule of a program to a native function.

use crate::clash::analysed;
use crate::detour::Detour;
use crate::direct_code::DirectCode;
use crate::direct_frame::{DirectEntry, DirectFrame};
use crate::emit::{EmittedRule, Emitter, entry_signature};
use crate::frame::{NativeEntry, NativeFrame};
use crate::limits::{FEW_RULES, MAX_RULES};
use crate::memory::CodeMemory;
use crate::value_facts::ValueFacts;
use asmotion_ir::{DomainId, Program, RoutineId};
use asmotion_machine::back_end::{
    Compiler, DirectResult, DirectRule, DirectStep, NativeCompiler, NativeRule, NoNativeCode,
    RuleStopped, StepContext,
};
use asmotion_value::Value;
use cranelift_codegen::settings::{self, Configurable};
use cranelift_frontend::{FunctionBuilder, FunctionBuilderContext};
use cranelift_jit::{JITBuilder, JITModule};
use cranelift_module::{FuncId, Linkage, Module, default_libcall_names};
use std::sync::Arc;

/// Compiles main rules with Cranelift, for the processor of the running process.
#[derive(Clone, Copy, Debug, Default)]
pub struct Cranelift;

impl NativeCompiler for Cranelift {
    fn compile_direct(&self, program: &Program, slots: &[Value]) -> Option<Box<dyn DirectRule>> {
        compile_direct(program, slots)
    }

    fn compile(&self, program: &Program) -> Result<Box<dyn NativeRule>, NoNativeCode> {
        if program.compatible {
            return Err(NoNativeCode::Compatible);
        }
        let main = program.main.ok_or(NoNativeCode::NoMainRule)?;
        let mut module = module(analysed(program, main).rules).ok_or(NoNativeCode::Processor)?;
        let compiled = emitted(program, main, &mut module, |_| {}, |_| true);
        // takes ownership first, so that the module's memory is freed on every path
        let memory = CodeMemory::new(module);
        let (function, rule) = compiled.ok_or(NoNativeCode::TooLarge)?;
        Ok(Box::new(MainRule {
            entry: memory.entry(function).ok_or(NoNativeCode::Processor)?,
            detours: rule.detours,
            locals: rule.locals,
            _memory: memory,
        }))
    }
}

/// A main rule as native code.
struct MainRule {
    entry: NativeEntry,
    /// The closures for everything that native code does not handle.
    detours: Vec<Detour>,
    /// Number of locals, including those of inlined macros.
    locals: u32,
    /// Owns the code that `entry` points to.
    _memory: CodeMemory,
}

impl NativeRule for MainRule {
    #[inline]
    fn run(&self, run: &mut StepContext<'_>) -> Result<(), RuleStopped> {
        NativeFrame::enter(run, self.entry, &self.detours, self.locals as usize)
    }
}

/// A direct rule with its code.
struct DirectMainRule {
    entry: DirectEntry,
    /// Greatest possible number of updates.
    updates: usize,
    /// The extended domains whose elements the rule enumerates.
    extents: Vec<DomainId>,
    facts: Arc<ValueFacts>,
    /// Owns the code that `entry` points to.
    _memory: CodeMemory,
}

impl DirectRule for DirectMainRule {
    #[inline]
    fn collect(&self, step: &mut DirectStep<'_>) -> DirectResult {
        DirectFrame::enter(step, self.entry, self.updates, &self.extents)
    }

    fn fits(&self, slots: &[Value]) -> bool {
        self.facts.hold(slots)
    }
}

/// Compiles the main rule for direct steps; `None` if they would not be sound, or useless.
fn compile_direct(program: &Program, slots: &[Value]) -> Option<Box<dyn DirectRule>> {
    let main = program.main?;
    let assumes = program.invariants.iter().any(|invariant| invariant.assumes);
    if program.compatible || program.messages.is_some() || assumes {
        return None;
    }
    let analysis = analysed(program, main);
    if analysis.rules >= MAX_RULES {
        return None;
    }
    let mut module = module(analysis.rules)?;
    let facts = Arc::new(ValueFacts::of(program, slots));
    let mut updates = None;
    let function = emitted(
        program,
        main,
        &mut module,
        |emitter| emitter.set_direct(analysis.free, facts.clone()),
        |rule| {
            updates = rule.direct.as_ref().and_then(DirectCode::updates);
            rule.is_whole && updates.is_some()
        },
    );
    let memory = CodeMemory::new(module);
    let (function, rule) = function?;
    Some(Box::new(DirectMainRule {
        extents: rule.direct?.extents,
        entry: memory.direct_entry(function)?,
        updates: updates?,
        facts,
        _memory: memory,
    }))
}

/// Creates an empty module for this processor. Native code accesses values by their layout in
/// memory, which is defined for little-endian machines with 64-bit pointers only.
///
/// A function with many rules is not optimised, which takes a third of the compilation and saves a twentieth of a step.
fn module(rules: usize) -> Option<JITModule> {
    if cfg!(target_endian = "big") || cfg!(not(target_pointer_width = "64")) {
        return None;
    }
    let verifies = if cfg!(debug_assertions) {
        "true"
    } else {
        "false"
    };
    let level = if rules < FEW_RULES { "speed" } else { "none" };
    let mut flags = settings::builder();
    flags.set("use_colocated_libcalls", "false").ok()?;
    flags.set("is_pic", "false").ok()?;
    flags.set("opt_level", level).ok()?;
    flags.set("enable_verifier", verifies).ok()?;
    let isa = cranelift_native::builder().ok()?;
    let isa = isa.finish(settings::Flags::new(flags)).ok()?;
    let builder = JITBuilder::with_isa(isa, default_libcall_names());
    Some(JITModule::new(builder))
}

/// Generates a main rule and compiles it if it is accepted. Returns the function and the rest of the rule.
fn emitted(
    program: &Program,
    main: RoutineId,
    module: &mut JITModule,
    prepare: impl FnOnce(&mut Emitter<'_>),
    accept: impl FnOnce(&EmittedRule) -> bool,
) -> Option<(FuncId, EmittedRule)> {
    let signature = entry_signature(module);
    let function = module
        .declare_function("main", Linkage::Local, &signature)
        .ok()?;
    let mut context = module.make_context();
    context.func.signature = signature;
    let mut scratch = FunctionBuilderContext::new();
    let compiler = Compiler::of(program);
    let builder = FunctionBuilder::new(&mut context.func, &mut scratch);
    let mut emitter = Emitter::new(program, &compiler, builder, module);
    prepare(&mut emitter);
    let rule = emitter.main(main, module.target_config());
    if !accept(&rule) {
        return None;
    }
    module.define_function(function, &mut context).ok()?;
    module.finalize_definitions().ok()?;
    Some((function, rule))
}
