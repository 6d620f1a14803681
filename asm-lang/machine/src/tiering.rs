//! The implementation of a machine's steps: closures at first, native code once that pays off.

use crate::back_end::BackEnd;
use crate::background;
use crate::machine::Machine;
use crate::run::code::{CompiledProgram, NativeCompiler, NoNativeCode};
use asmotion_ir::Program;
use asmotion_value::Value;
use std::sync::atomic::Ordering;

/// Amount of work after which compiling the main rule to native code pays off; see `STEP` in [`crate::machine`].
const WARM: u64 = 10_000;

/// Additional amount of work for each rule of the program.
const WARM_RULE: u64 = 50;

/// The compilation of a main rule to native code.
struct Compilation<'a> {
    program: &'a Program,
    code: &'a CompiledProgram,
    compiler: Option<&'static dyn NativeCompiler>,
    /// Slots of the state from which direct steps start.
    slots: &'a [Value],
}

impl Compilation<'_> {
    /// Returns `true` if there is a direct rule; compiles it unless that was tried before.
    fn direct(&self) -> bool {
        let compile = || self.compiler?.compile_direct(self.program, self.slots);
        self.code.direct.get_or_init(compile).is_some()
    }

    /// Compiles the main rule to native code with detours, unless it is already compiled.
    fn detours(&self) -> Result<(), NoNativeCode> {
        let compile = || match self.compiler {
            Some(compiler) => compiler.compile(self.program),
            None => Err(NoNativeCode::NotBuilt),
        };
        match self.code.native.get_or_init(compile) {
            Ok(_) => Ok(()),
            Err(reason) => Err(*reason),
        }
    }
}

impl Machine {
    /// Sets the compiler to native code. Without one, closures execute all steps.
    pub fn set_native_compiler(&mut self, compiler: &'static dyn NativeCompiler) {
        self.native_compiler = Some(compiler);
    }

    /// Notes that the state was changed other than by a step.
    pub(crate) fn changed_outside(&mut self) {
        self.direct.is_ready = false;
        self.scratch.is_direct = false;
    }

    /// Selects the implementation of future steps. [`BackEnd::Native`] compiles immediately.
    ///
    /// # Errors
    /// Native code is not available; closures execute the same steps.
    pub fn set_back_end(&mut self, back_end: BackEnd) -> Result<(), NoNativeCode> {
        self.back_end = back_end;
        self.direct.is_ready = false;
        if back_end == BackEnd::Native && !self.compilation().direct() {
            return self.compilation().detours();
        }
        Ok(())
    }

    /// Returns the implementation of the next step: closures or native code.
    pub fn back_end(&self) -> BackEnd {
        if self.has_direct() || self.has_detours() {
            BackEnd::Native
        } else {
            BackEnd::Closures
        }
    }

    /// Returns `true` if native code with detours executes the next step.
    pub(crate) fn is_native(&self) -> bool {
        (self.direct.is_refused || !self.has_direct()) && self.has_detours()
    }

    /// Returns `true` if there is a direct rule. It is compiled now, or in the background once enough work was done.
    fn has_direct(&self) -> bool {
        match self.back_end {
            BackEnd::Closures => false,
            BackEnd::Native => self.compilation().direct(),
            BackEnd::Auto => match self.code.direct.get() {
                Some(direct) => direct.is_some(),
                None => {
                    self.compile_in_background(0, |it| {
                        let _ = it.direct();
                    });
                    false
                }
            },
        }
    }

    /// Returns `true` if there is native code with detours, compiled like a direct rule.
    fn has_detours(&self) -> bool {
        let is_needed = self.direct.is_refused || matches!(self.code.direct.get(), Some(None));
        match self.back_end {
            BackEnd::Closures => false,
            BackEnd::Native => self.compilation().detours().is_ok(),
            BackEnd::Auto => match self.code.native.get() {
                Some(native) => native.is_ok(),
                None => {
                    if is_needed {
                        self.compile_in_background(1, |it| {
                            let _ = it.detours();
                        });
                    }
                    false
                }
            },
        }
    }

    fn compilation(&self) -> Compilation<'_> {
        Compilation {
            program: &self.program,
            code: &self.code,
            compiler: self.native_compiler,
            slots: &self.state.store.slots,
        }
    }

    /// Compiles in another thread, once, after enough work was done. The next step after its end uses the result, which makes no
    /// difference to the step.
    fn compile_in_background(&self, index: usize, compile: fn(&Compilation<'_>)) {
        let is_worth_it = self.work >= WARM + WARM_RULE * self.code.rules;
        let Some(compiler) = self.native_compiler.filter(|_| is_worth_it) else {
            return;
        };
        if self.code.is_compiling[index].swap(true, Ordering::Relaxed) {
            return;
        }
        let (program, code) = (self.program.clone(), self.code.clone());
        let slots = self.state.store.slots.clone();
        background::run(Box::new(move || {
            compile(&Compilation {
                program: &program,
                code: &code,
                compiler: Some(compiler),
                slots: &slots,
            });
        }));
    }

    /// Returns `true` if the direct rule can be tried for the next step; compiles it once enough work was done.
    pub(crate) fn is_direct(&mut self) -> bool {
        let is_begun = self.is_complete && (self.steps > 0 || !self.program.needs_inputs());
        if !is_begun || self.direct.is_refused || !self.has_direct() {
            return false;
        }
        if let Some(Some(rule)) = self.code.direct.get() {
            self.direct.is_ready = rule.fits(&self.state.store.slots);
        }
        if !self.direct.is_ready {
            self.direct.tried += 1;
            self.direct.miss();
        }
        self.direct.is_ready
    }
}
