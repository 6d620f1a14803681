//! The function under construction: blocks, memory accesses and exits.

use crate::atoms::AtomRange;
use crate::detour::Detour;
use crate::direct_code::DirectCode;
use crate::direct_frame;
use crate::frame::{at, out, pack_call_position};
use crate::limits::MAX_RULES;
use asmotion_ir::{BodyId, IntegerInterval, Local, Program, RoutineId, Rule, Term, ValueKind};
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

/// A value of the function under construction, in static single assignment form.
pub(crate) type Ssa = clif::Value;

/// The enclosing loops of a quantifier, `choose` or `forall`.
pub(crate) struct Loops {
    /// Number of bindings before the loops; `None` if they are counted one by one.
    pub before: Option<Ssa>,
    /// For each loop, the number of completed iterations and of bindings in each iteration.
    pub rounds: Vec<(Ssa, u64)>,
}

/// An integer in a register, with its known bounds.
#[derive(Clone, Copy)]
pub(crate) struct NativeInt {
    pub value: Ssa,
    pub interval: IntegerInterval,
    /// The value as the sum of another value and a constant.
    pub root: (Ssa, i64),
    /// `true` if the bounds follow from the program alone, not from facts about the state.
    pub is_proven: bool,
}

impl NativeInt {
    pub fn new(value: Ssa, interval: IntegerInterval) -> Self {
        Self {
            value,
            interval,
            root: (value, 0),
            is_proven: true,
        }
    }

    /// Returns the value if the program alone determines it.
    pub fn constant(&self) -> Option<i64> {
        let IntegerInterval { low, high } = self.interval;
        (self.is_proven && low == high).then_some(low)
    }
}

/// An atom in a register.
#[derive(Clone, Copy)]
pub(crate) struct AtomCode {
    pub value: Ssa,
    /// The atoms it belongs to, if known.
    pub among: Option<AtomRange>,
}

/// Compile-time knowledge about a variable.
#[derive(Clone, Copy)]
pub(crate) enum KnownValue {
    Nothing,
    Int(NativeInt),
    Bool(Ssa),
    Atom(AtomCode),
    /// The value is in memory, among the locals of the step.
    Memory(ValueKind),
}

/// The innermost inlined routine.
#[derive(Clone)]
pub(crate) struct EmitScope {
    /// Index of its first local.
    pub base: u32,
    /// Number of its locals.
    pub size: u32,
    /// Nesting depth of its call.
    pub depth: u32,
    pub locals: Vec<KnownValue>,
    /// The running agent, if native code has set it.
    pub agent: Option<AtomCode>,
}

/// The destination of updates.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum UpdateMode {
    /// The update set of the step.
    Step,
    /// A layer within a sequence.
    Layer,
    /// The set of a sequence, applied to the state immediately.
    Sequence,
}

/// The exit of the current unit, to its detour.
#[derive(Clone, Copy)]
struct Bail {
    block: Block,
    used: bool,
}

/// A function of the host that native code calls.
#[derive(Clone, Copy)]
pub(crate) struct HostFunction {
    pub address: i64,
    signature: SigRef,
}

/// The host functions, see [`out`].
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
    /// Of a direct rule only.
    pub decide: HostFunction,
    pub endless: HostFunction,
    pub open: HostFunction,
    pub apply: HostFunction,
    pub restore: HostFunction,
    pub write: HostFunction,
    pub write_through: HostFunction,
}

/// Alias regions: accesses to different ones do not overlap, which lets Cranelift reorder them.
#[derive(Clone, Copy)]
pub(crate) struct Regions {
    pub frame: MemFlagsData,
    pub run: MemFlagsData,
    pub slots: MemFlagsData,
    pub updates: MemFlagsData,
    /// Lengths of the lists, separate because they change with every update.
    pub length: MemFlagsData,
    pub locals: MemFlagsData,
    pub counters: MemFlagsData,
    /// Elements of domains, which do not change during a step.
    pub extents: MemFlagsData,
}

/// The parts of a generated rule other than its code.
pub(crate) struct EmittedRule {
    pub detours: Vec<Detour>,
    /// Number of locals, including those of inlined macros.
    pub locals: u32,
    pub direct: Option<DirectCode>,
    /// `true` if no macro was left out because the function would be too large.
    pub is_whole: bool,
}

/// Generates one function.
pub(crate) struct Emitter<'a> {
    pub program: &'a Program,
    compiler: &'a Compiler<'a>,
    pub builder: FunctionBuilder<'a>,
    pub calls: Calls,
    pub memory: Regions,
    pub frame: Ssa,
    /// The exit for a rule that stopped with a fault.
    pub exit: Block,
    bail: Bail,
    pub scope: EmitScope,
    pub mode: UpdateMode,
    pub loops: Vec<Loops>,
    /// The routines that are being inlined, outermost first.
    pub inlined: Vec<RoutineId>,
    /// The definitions that are being unfolded, outermost first.
    pub unfolding: Vec<BodyId>,
    /// Number of rules that may still be generated; macros beyond it are not inlined.
    room: u32,
    detours: Vec<Detour>,
    locals: u32,
    /// State of a direct rule; `None` for code with detours.
    pub direct: Option<DirectCode>,
    /// Number of rules around the current one that execute it only under a condition.
    pub conditions: u32,
    /// The block at which the next rule ends with a jump, in a direct rule; `None` if it continues with the code that follows.
    pub end: Option<Block>,
}

/// Returns the signature of [`crate::frame::NativeEntry`].
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
        decide: call(
            direct_frame::decide as *const () as usize,
            &[I32, I64, I32],
            Some(I64),
        ),
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
        counters: region("counters"),
        extents: region("extents"),
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
            unfolding: Vec::new(),
            room: MAX_RULES as u32,
            detours: Vec::new(),
            locals: 0,
            direct: None,
            conditions: 0,
            end: None,
        }
    }

    /// Generates the main rule and the exits.
    pub fn main(mut self, main: RoutineId, config: TargetFrontendConfig) -> EmittedRule {
        let routine = &self.program.routines[main.0 as usize];
        self.enter(main, Vec::new());
        self.rule(&routine.code);
        self.end_direct();
        let done = self.number(I8, 0);
        self.builder.ins().return_(&[done]);
        self.begin(self.exit);
        let stopped = self.number(I8, 1);
        self.builder.ins().return_(&[stopped]);
        self.builder.seal_all_blocks();
        self.builder.finalize(config);
        EmittedRule {
            detours: self.detours,
            locals: self.locals,
            direct: self.direct,
            is_whole: self.room > 0,
        }
    }

    /// Enters the frame of a routine, and returns the enclosing one.
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

    /// Returns the index of the first local of a routine called here.
    pub fn inner_base(&self) -> u32 {
        self.scope.base + self.scope.size
    }

    /// Ensures that locals up to `end` are allocated before native code runs.
    pub fn reserve_locals(&mut self, end: u32) {
        self.locals = self.locals.max(end);
    }

    /// Returns `true` if another rule may be inlined.
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

    /// Begins a block to which all jumps have been generated.
    pub fn begin(&mut self, block: Block) {
        debug_assert!(self.has_advanced(), "a jump did not advance the updates");
        self.proceed(block);
    }

    /// Begins a block to which only the code before leads.
    fn proceed(&mut self, block: Block) {
        self.builder.switch_to_block(block);
        self.builder.seal_block(block);
    }

    /// Begins a block to which later code jumps back.
    pub fn begin_loop(&mut self, head: Block) {
        self.builder.switch_to_block(head);
    }

    pub fn jump(&mut self, to: Block) {
        self.advance_updates();
        self.builder.ins().jump(to, &[]);
    }

    pub fn jump_with(&mut self, to: Block, value: Ssa) {
        self.advance_updates();
        self.builder.ins().jump(to, &[value.into()]);
    }

    pub fn branch(&mut self, condition: Ssa, yes: Block, no: Block) {
        self.advance_updates();
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

    /// Loads a field of the frame.
    pub fn field(&mut self, ty: Type, offset: i32) -> Ssa {
        self.load(self.memory.frame, ty, self.frame, offset)
    }

    /// Loads the pointer to the step context.
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

    /// Leaves the current unit for its detour if the condition holds.
    pub fn bail_if(&mut self, condition: Ssa) {
        self.bail.used = true;
        let next = self.block();
        // does not advance the updates: the exit needs no address, and the code that follows continues that before
        let bail = self.bail.block;
        self.builder.ins().brif(condition, bail, &[], next, &[]);
        self.proceed(next);
    }

    /// Leaves the current unit for its detour.
    pub fn bail(&mut self) {
        self.bail.used = true;
        self.jump(self.bail.block);
    }

    /// Generates a unit: native code that a detour can execute again from the beginning. Before it
    /// leaves for the detour, the code has no effect except on the counter of bindings, which is
    /// restored if `counts` is set. Both `native` and `detour` continue at `done`; if that is
    /// `None`, they choose their continuations themselves.
    pub fn unit(
        &mut self,
        counts: bool,
        native: impl FnOnce(&mut Self),
        detour: impl FnOnce(&mut Self),
        done: Option<Block>,
    ) {
        let known = self.scope.locals.clone();
        if self.direct.is_some() {
            native(self);
            self.scope.locals = known;
            if let Some(done) = done {
                self.jump(done);
                self.begin(done);
            }
            return;
        }
        let before = counts.then(|| self.bindings());
        let bail = Bail {
            block: self.cold_block(),
            used: false,
        };
        let outer = std::mem::replace(&mut self.bail, bail);
        native(self);
        let bail = std::mem::replace(&mut self.bail, outer);
        // variables bound in the unit are out of scope
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

    /// Generates a unit of code that continues only at its end.
    pub fn straight_unit(
        &mut self,
        counts: bool,
        native: impl FnOnce(&mut Self),
        detour: impl FnOnce(&mut Self),
    ) {
        let done = self.direct.is_none().then(|| self.block());
        self.unit(counts, native, detour, done);
    }

    pub fn bindings(&mut self) -> Ssa {
        let run = self.run();
        self.load(self.memory.run, I32, run, at::BINDINGS)
    }

    pub fn set_bindings(&mut self, bindings: Ssa) {
        let run = self.run();
        self.store(self.memory.run, bindings, run, at::BINDINGS);
    }

    /// Returns the frame and call depth for a host function, as an argument.
    pub fn call_position(&mut self) -> Ssa {
        let place = pack_call_position(self.scope.base, self.scope.depth);
        self.number(I64, place)
    }

    /// Stores the variables in memory, where closures expect them.
    fn spill(&mut self) {
        for local in 0..self.scope.locals.len() {
            let known = self.scope.locals[local];
            if let Some((tag, payload)) = self.tag_and_payload(known) {
                let local = self.number(I32, i64::from(self.scope.base) + local as i64);
                let tag = self.number(I32, i64::from(tag));
                self.call(self.calls.spill, &[local, tag, payload]);
            }
        }
    }

    /// Returns a scalar as its tag and its 64-bit payload.
    pub fn tag_and_payload(&mut self, known: KnownValue) -> Option<(u8, Ssa)> {
        match known {
            KnownValue::Nothing | KnownValue::Memory(_) => None,
            KnownValue::Int(int) => Some((layout::INT, int.value)),
            KnownValue::Bool(truth) => Some((layout::BOOL, self.extended(truth))),
            KnownValue::Atom(atom) => Some((layout::ATOM, self.extended(atom.value))),
        }
    }

    /// Returns a truth value or atom with 64 bits. A constant is one again, which needs no register to be stored.
    fn extended(&mut self, value: Ssa) -> Ssa {
        let dfg = &self.builder.func.dfg;
        let constant = if let clif::ValueDef::Result(instruction, _) = dfg.value_def(value)
            && let clif::InstructionData::UnaryImm {
                opcode: clif::Opcode::Iconst,
                imm,
            } = dfg.insts[instruction]
        {
            Some(imm.bits())
        } else {
            None
        };
        match (constant, dfg.value_type(value)) {
            (Some(bits), I8) => self.number(I64, bits & 0xff),
            (Some(bits), I32) => self.number(I64, bits & 0xffff_ffff),
            _ => self.builder.ins().uextend(I64, value),
        }
    }

    fn detour(&mut self, detour: Detour) -> [Ssa; 2] {
        self.spill();
        self.detours.push(detour);
        let index = self.number(I32, self.detours.len() as i64 - 1);
        [index, self.call_position()]
    }

    /// Generates a call to the closure of a rule.
    pub fn rule_outside(&mut self, rule: &Rule) {
        if self.gives_up() {
            return;
        }
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

    /// Generates a call to the closure of a guard.
    pub fn guard_outside(&mut self, guard: &Term, yes: Block, no: Block) {
        if self.gives_up() {
            return;
        }
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

    /// Generates a call to the closure of a Boolean term. Undef and faults are left to the detour
    /// of the current unit.
    pub fn truth_outside(&mut self, term: &Term, yes: Block, no: Block) {
        if self.gives_up() {
            return;
        }
        let code = self.compiler.truth(term);
        let [index, place] = self.detour(Detour::Truth(code));
        if let Some(holds) = self.call(self.calls.truth, &[index, place]) {
            let open = self.compare(IntCC::Equal, holds, 2);
            self.bail_if(open);
            self.branch(holds, yes, no);
        }
    }

    /// Generates a call to the closure of a term with scalar value. Undef and faults are left to
    /// the detour of the current unit.
    pub fn term_outside(&mut self, term: &Term, tag: u8, ty: Type) -> Ssa {
        if self.gives_up() {
            return self.number(ty, 0);
        }
        let code = self.compiler.term(term);
        let arguments = self.detour(Detour::Term(code));
        self.call(self.calls.term, &arguments);
        self.expect(self.memory.frame, self.frame, at::ANSWER, tag, ty)
    }

    /// Generates a call to the closure of a term that stores the value in a local. Faults are left
    /// to the detour of the current unit.
    pub fn bind_outside(&mut self, term: &Term, local: u32) {
        if self.gives_up() {
            return;
        }
        let code = self.compiler.term(term);
        let [index, place] = self.detour(Detour::Term(code));
        let local = self.number(I32, i64::from(local));
        if let Some(failed) = self.call(self.calls.bind, &[index, place, local]) {
            self.bail_if(failed);
        }
    }

    /// Loads the payload of a value in memory; leaves for the detour if its tag differs from `tag`.
    pub fn expect(&mut self, memory: MemFlagsData, at: Ssa, offset: i32, tag: u8, ty: Type) -> Ssa {
        let found = self.load(memory, I8, at, offset);
        let other = self.compare(IntCC::NotEqual, found, i64::from(tag));
        self.bail_if(other);
        self.load(memory, ty, at, offset + at::PAYLOAD)
    }

    /// Ends the step if the condition holds. The fault has already been recorded.
    pub fn stop_if(&mut self, condition: Ssa) {
        let next = self.block();
        self.branch(condition, self.exit, next);
        self.begin(next);
    }

    /// Returns the offset in bytes of a local in the scope.
    pub fn local_offset(&self, local: Local) -> i32 {
        (i64::from(self.scope.base + local) * at::VALUE_SIZE) as i32
    }
}
