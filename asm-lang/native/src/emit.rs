//! The function under construction: blocks, memory, ways out.

use crate::detour::Detour;
use crate::frame::{at, out, place};
use asmotion_ir::{IntegerInterval, Local, Program, RoutineId, Rule, Term, ValueKind};
use asmotion_machine::back_end::Compiler;
use asmotion_value::layout;
use cranelift_codegen::ir::condcodes::IntCC;
use cranelift_codegen::ir::types::{I8, I32, I64};
use cranelift_codegen::ir::{
    self as clif, AbiParam, AliasRegionData, Block, InstBuilder, MemFlagsData, SigRef, Type,
};
use cranelift_codegen::isa::{CallConv, TargetFrontendConfig};
use cranelift_frontend::FunctionBuilder;
use cranelift_jit::JITModule;
use cranelift_module::Module;

/// A value of the function under construction.
pub(crate) type Ssa = clif::Value;

/// Programs are built into one function as long as it has no more rules than this.
const MAX_RULES: u32 = 20_000;

/// An integer in a register, and what is known about it.
#[derive(Clone, Copy)]
pub(crate) struct NativeInt {
    pub value: Ssa,
    pub interval: IntegerInterval,
    /// The value is this one and a constant.
    pub root: (Ssa, i64),
}

impl NativeInt {
    pub fn new(value: Ssa, interval: IntegerInterval) -> Self {
        Self {
            value,
            interval,
            root: (value, 0),
        }
    }
}

/// An atom in a register.
#[derive(Clone, Copy)]
pub(crate) struct AtomCode {
    pub value: Ssa,
    /// The first atom it may be, and how many there are.
    pub among: Option<(u32, u32)>,
}

/// What is known about a variable.
#[derive(Clone, Copy)]
pub(crate) enum KnownValue {
    Nothing,
    Int(NativeInt),
    Bool(Ssa),
    Atom(AtomCode),
    /// It lies among the locals of the run.
    Memory(ValueKind),
}

/// The routine that is being built in.
#[derive(Clone)]
pub(crate) struct EmitScope {
    /// Where its locals begin.
    pub base: u32,
    /// How many there are.
    pub size: u32,
    /// How deep it is called.
    pub depth: u32,
    pub locals: Vec<KnownValue>,
    /// The agent, once a native rule has set it.
    pub agent: Option<AtomCode>,
}

/// Where updates go.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum UpdateMode {
    /// Into the update set of the step.
    Step,
    /// Into a set within it.
    Layer,
    /// Into the set of a sequence, and to the state at once.
    Sequence,
}

/// Where code goes that meets what it does not do itself.
#[derive(Clone, Copy)]
struct Bail {
    block: Block,
    used: bool,
}

/// A function outside.
#[derive(Clone, Copy)]
pub(crate) struct HostFunction {
    address: i64,
    signature: SigRef,
}

/// The functions outside, see [`out`].
pub(crate) struct Calls {
    pub rule: HostFunction,
    pub layered: HostFunction,
    pub guard: HostFunction,
    pub truth: HostFunction,
    pub term: HostFunction,
    pub bind: HostFunction,
    pub spill: HostFunction,
    pub way: HostFunction,
    pub choose: HostFunction,
    pub endless: HostFunction,
    pub open: HostFunction,
    pub apply: HostFunction,
    pub restore: HostFunction,
    pub write: HostFunction,
    pub write_through: HostFunction,
}

/// Memory that does not overlap.
#[derive(Clone, Copy)]
pub(crate) struct Regions {
    pub frame: MemFlagsData,
    pub run: MemFlagsData,
    pub slots: MemFlagsData,
    pub updates: MemFlagsData,
    /// How many updates there are.
    pub length: MemFlagsData,
    pub locals: MemFlagsData,
}

/// Writes one function.
pub(crate) struct Emitter<'a> {
    pub program: &'a Program,
    compiler: &'a Compiler<'a>,
    pub builder: FunctionBuilder<'a>,
    pub calls: Calls,
    pub memory: Regions,
    pub frame: Ssa,
    /// Where a rule goes that stopped.
    pub exit: Block,
    bail: Bail,
    pub scope: EmitScope,
    pub mode: UpdateMode,
    pub loops: Vec<crate::rule::Loops>,
    /// The routines that are being built in, the outermost first.
    pub inlined: Vec<RoutineId>,
    /// How many rules may still be built in.
    room: u32,
    detours: Vec<Detour>,
    locals: u32,
}

/// The signature of [`crate::frame::NativeEntry`].
pub(crate) fn entry_signature(module: &JITModule) -> clif::Signature {
    let mut signature = module.make_signature();
    signature.params.push(AbiParam::new(I64));
    signature.returns.push(AbiParam::new(I8));
    signature
}

fn calls(builder: &mut FunctionBuilder<'_>, convention: CallConv) -> Calls {
    let mut call = |address: usize, parameters: &[Type], result: Option<Type>| {
        let mut signature = clif::Signature::new(convention);
        signature.params.push(AbiParam::new(I64));
        let parameters = parameters.iter().copied().map(AbiParam::new);
        signature.params.extend(parameters);
        signature.returns.extend(result.map(AbiParam::new));
        HostFunction {
            address: address as i64,
            signature: builder.import_signature(signature),
        }
    };
    Calls {
        rule: call(out::rule as *const () as usize, &[I32, I64], Some(I8)),
        layered: call(out::layered as *const () as usize, &[I32, I64], Some(I8)),
        guard: call(out::guard as *const () as usize, &[I32, I64, I32], Some(I8)),
        truth: call(out::truth as *const () as usize, &[I32, I64], Some(I8)),
        term: call(out::term as *const () as usize, &[I32, I64], None),
        bind: call(out::bind as *const () as usize, &[I32, I64, I32], Some(I8)),
        spill: call(out::spill as *const () as usize, &[I32, I32, I64], None),
        way: call(out::way as *const () as usize, &[I32], Some(I8)),
        choose: call(out::choose as *const () as usize, &[I64, I32], Some(I64)),
        endless: call(out::endless as *const () as usize, &[I32, I32, I64], None),
        open: call(out::open as *const () as usize, &[], None),
        apply: call(out::apply as *const () as usize, &[], Some(I8)),
        restore: call(out::restore as *const () as usize, &[], Some(I8)),
        write: call(out::write as *const () as usize, &[I32, I32], None),
        write_through: call(out::write_through as *const () as usize, &[I32, I32], None),
    }
}

fn regions(builder: &mut FunctionBuilder<'_>) -> Regions {
    let mut next = 0;
    let mut region = |description: &'static str| {
        let data = AliasRegionData {
            user_id: next,
            description: description.into(),
        };
        next += 1;
        let region = builder.func.dfg.alias_regions.insert(data);
        MemFlagsData::trusted().with_alias_region(Some(region))
    };
    Regions {
        frame: region("frame"),
        run: region("run"),
        slots: region("slots"),
        updates: region("updates"),
        length: region("length"),
        locals: region("locals"),
    }
}

impl<'a> Emitter<'a> {
    pub fn new(
        program: &'a Program,
        compiler: &'a Compiler<'a>,
        mut builder: FunctionBuilder<'a>,
        module: &JITModule,
    ) -> Self {
        let entry = builder.create_block();
        builder.append_block_params_for_function_params(entry);
        builder.switch_to_block(entry);
        let frame = builder.block_params(entry)[0];
        let exit = builder.create_block();
        builder.set_cold_block(exit);
        let calls = calls(&mut builder, module.isa().default_call_conv());
        let memory = regions(&mut builder);
        Self {
            program,
            compiler,
            builder,
            calls,
            memory,
            frame,
            exit,
            bail: Bail {
                block: exit,
                used: false,
            },
            scope: EmitScope {
                base: 0,
                size: 0,
                depth: 0,
                locals: Vec::new(),
                agent: None,
            },
            mode: UpdateMode::Step,
            loops: Vec::new(),
            inlined: Vec::new(),
            room: MAX_RULES,
            detours: Vec::new(),
            locals: 0,
        }
    }

    /// The whole function: the main rule, then the ways to its end.
    pub fn main(mut self, main: RoutineId, config: TargetFrontendConfig) -> (Vec<Detour>, u32) {
        let routine = &self.program.routines[main.0 as usize];
        self.enter(main, Vec::new());
        self.rule(&routine.code);
        let done = self.number(I8, 0);
        self.builder.ins().return_(&[done]);
        self.begin(self.exit);
        let stopped = self.number(I8, 1);
        self.builder.ins().return_(&[stopped]);
        self.builder.seal_all_blocks();
        self.builder.finalize(config);
        (self.detours, self.locals)
    }

    /// Begins the frame of a routine; gives the one around it.
    pub fn enter(&mut self, routine: RoutineId, mut arguments: Vec<KnownValue>) -> EmitScope {
        let size = self.program.routines[routine.0 as usize].locals;
        arguments.resize(size as usize, KnownValue::Nothing);
        let base = self.inner_base();
        self.locals = self.locals.max(base + size);
        self.inlined.push(routine);
        let scope = EmitScope {
            base,
            size,
            depth: self.inlined.len() as u32 - 1,
            locals: arguments,
            agent: self.scope.agent,
        };
        std::mem::replace(&mut self.scope, scope)
    }

    /// Where the locals of a routine begin that is called here.
    pub fn inner_base(&self) -> u32 {
        self.scope.base + self.scope.size
    }

    /// Makes sure that this local is there when native code runs.
    pub fn reserve_locals(&mut self, end: u32) {
        self.locals = self.locals.max(end);
    }

    /// Whether one more rule may be built in.
    pub fn has_room(&mut self) -> bool {
        self.room = self.room.saturating_sub(1);
        self.room > 0
    }

    pub fn block(&mut self) -> Block {
        self.builder.create_block()
    }

    pub fn cold_block(&mut self) -> Block {
        let block = self.builder.create_block();
        self.builder.set_cold_block(block);
        block
    }

    pub fn begin(&mut self, block: Block) {
        self.builder.switch_to_block(block);
    }

    pub fn jump(&mut self, to: Block) {
        self.builder.ins().jump(to, &[]);
    }

    pub fn jump_with(&mut self, to: Block, value: Ssa) {
        self.builder.ins().jump(to, &[value.into()]);
    }

    pub fn branch(&mut self, condition: Ssa, yes: Block, no: Block) {
        self.builder.ins().brif(condition, yes, &[], no, &[]);
    }

    pub fn number(&mut self, ty: Type, number: i64) -> Ssa {
        self.builder.ins().iconst(ty, number)
    }

    pub fn compare(&mut self, condition: IntCC, left: Ssa, right: i64) -> Ssa {
        self.builder.ins().icmp_imm_s(condition, left, right)
    }

    pub fn load(&mut self, memory: MemFlagsData, ty: Type, at: Ssa, offset: i32) -> Ssa {
        self.builder.ins().load(ty, memory, at, offset)
    }

    pub fn store(&mut self, memory: MemFlagsData, value: Ssa, at: Ssa, offset: i32) {
        self.builder.ins().store(memory, value, at, offset);
    }

    /// A field of the frame.
    pub fn field(&mut self, ty: Type, offset: i32) -> Ssa {
        self.load(self.memory.frame, ty, self.frame, offset)
    }

    /// Where the run is.
    pub fn run(&mut self) -> Ssa {
        self.field(I64, at::RUN)
    }

    pub fn call(&mut self, call: HostFunction, arguments: &[Ssa]) -> Option<Ssa> {
        let mut all = vec![self.frame];
        all.extend_from_slice(arguments);
        let address = self.number(I64, call.address);
        let ins = self.builder.ins();
        let call = ins.call_indirect(call.signature, address, &all);
        self.builder.inst_results(call).first().copied()
    }

    /// Takes the detour of the unit at hand if the condition holds.
    pub fn bail_if(&mut self, condition: Ssa) {
        self.bail.used = true;
        let next = self.block();
        self.branch(condition, self.bail.block, next);
        self.begin(next);
    }

    /// Takes the detour of the unit at hand.
    pub fn bail(&mut self) {
        self.bail.used = true;
        self.jump(self.bail.block);
    }

    /// Code that may be begun anew by a detour: up to where it bails out it has changed nothing, but
    /// counted bindings if it `counts`. `native` ends where the unit is done, or elsewhere if it says
    /// so by giving no block to go on in; so does `detour`.
    pub fn unit(
        &mut self,
        counts: bool,
        native: impl FnOnce(&mut Self),
        detour: impl FnOnce(&mut Self),
        done: Option<Block>,
    ) {
        let before = counts.then(|| self.bindings());
        let known = self.scope.locals.clone();
        let bail = Bail {
            block: self.cold_block(),
            used: false,
        };
        let outer = std::mem::replace(&mut self.bail, bail);
        native(self);
        let bail = std::mem::replace(&mut self.bail, outer);
        // what was bound within is out of scope
        self.scope.locals = known;
        if let Some(done) = done {
            self.jump(done);
        }
        if bail.used {
            self.begin(bail.block);
            if let Some(before) = before {
                self.set_bindings(before);
            }
            detour(self);
            if let Some(done) = done {
                self.jump(done);
            }
        }
        if let Some(done) = done {
            self.begin(done);
        }
    }

    pub fn bindings(&mut self) -> Ssa {
        let run = self.run();
        self.load(self.memory.run, I32, run, at::BINDINGS)
    }

    pub fn set_bindings(&mut self, bindings: Ssa) {
        let run = self.run();
        self.store(self.memory.run, bindings, run, at::BINDINGS);
    }

    /// Where closures find their locals, and how deep they are called.
    pub fn place(&mut self) -> Ssa {
        let place = place(self.scope.base, self.scope.depth);
        self.number(I64, place)
    }

    /// Puts the variables where closures look for them.
    fn spill(&mut self) {
        for local in 0..self.scope.locals.len() {
            let known = self.scope.locals[local];
            if let Some((tag, payload)) = self.word(known) {
                let local = self.number(I32, i64::from(self.scope.base) + local as i64);
                let tag = self.number(I32, i64::from(tag));
                self.call(self.calls.spill, &[local, tag, payload]);
            }
        }
    }

    /// A scalar as its tag and a payload of 64 bits.
    pub fn word(&mut self, known: KnownValue) -> Option<(u8, Ssa)> {
        match known {
            KnownValue::Nothing | KnownValue::Memory(_) => None,
            KnownValue::Int(int) => Some((layout::INT, int.value)),
            KnownValue::Bool(truth) => Some((layout::BOOL, self.builder.ins().uextend(I64, truth))),
            KnownValue::Atom(atom) => {
                Some((layout::ATOM, self.builder.ins().uextend(I64, atom.value)))
            }
        }
    }

    fn detour(&mut self, detour: Detour) -> [Ssa; 2] {
        self.spill();
        self.detours.push(detour);
        let index = self.number(I32, self.detours.len() as i64 - 1);
        [index, self.place()]
    }

    /// Leaves a rule to its closure.
    pub fn rule_outside(&mut self, rule: &Rule) {
        let code = self.compiler.rule(rule);
        let [index, place] = self.detour(Detour::Rule(code));
        let call = match self.mode {
            UpdateMode::Step | UpdateMode::Layer => self.calls.rule,
            UpdateMode::Sequence => self.calls.layered,
        };
        if let Some(done) = self.call(call, &[index, place]) {
            let stopped = self.compare(IntCC::Equal, done, 1);
            self.stop_if(stopped);
        }
    }

    /// Leaves a guard to its closure.
    pub fn guard_outside(&mut self, guard: &Term, yes: Block, no: Block) {
        let code = self.compiler.truth(guard);
        let [index, place] = self.detour(Detour::Truth(code));
        let origin = self.number(I32, i64::from(guard.origin.0));
        let call = self.calls.guard;
        if let Some(holds) = self.call(call, &[index, place, origin]) {
            let stopped = self.compare(IntCC::Equal, holds, 2);
            self.stop_if(stopped);
            self.branch(holds, yes, no);
        }
    }

    /// A truth value by its closure; undef and faults are left to the detour of the unit.
    pub fn truth_outside(&mut self, term: &Term, yes: Block, no: Block) {
        let code = self.compiler.truth(term);
        let [index, place] = self.detour(Detour::Truth(code));
        if let Some(holds) = self.call(self.calls.truth, &[index, place]) {
            let open = self.compare(IntCC::Equal, holds, 2);
            self.bail_if(open);
            self.branch(holds, yes, no);
        }
    }

    /// A scalar by its closure; undef and faults are left to the detour of the unit.
    pub fn term_outside(&mut self, term: &Term, tag: u8, ty: Type) -> Ssa {
        let code = self.compiler.term(term);
        let arguments = self.detour(Detour::Term(code));
        self.call(self.calls.term, &arguments);
        self.expect(self.memory.frame, self.frame, at::ANSWER, tag, ty)
    }

    /// Evaluates a term by its closure into a local; faults are left to the detour of the unit.
    pub fn bind_outside(&mut self, term: &Term, local: u32) {
        let code = self.compiler.term(term);
        let [index, place] = self.detour(Detour::Term(code));
        let local = self.number(I32, i64::from(local));
        if let Some(failed) = self.call(self.calls.bind, &[index, place, local]) {
            self.bail_if(failed);
        }
    }

    /// The payload of a value in memory that has this tag.
    pub fn expect(&mut self, memory: MemFlagsData, at: Ssa, offset: i32, tag: u8, ty: Type) -> Ssa {
        let found = self.load(memory, I8, at, offset);
        let other = self.compare(IntCC::NotEqual, found, i64::from(tag));
        self.bail_if(other);
        self.load(memory, ty, at, offset + at::PAYLOAD)
    }

    /// Ends the step if the condition holds: the fault is noted.
    pub fn stop_if(&mut self, condition: Ssa) {
        let next = self.block();
        self.branch(condition, self.exit, next);
        self.begin(next);
    }

    /// Where a local of the scope lies, as an offset to the locals.
    pub fn local_offset(&self, local: Local) -> i32 {
        (i64::from(self.scope.base + local) * at::VALUE_SIZE) as i32
    }
}
