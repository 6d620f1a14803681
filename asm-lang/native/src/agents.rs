//! Generates code for agents and their programs, and for domains that rules extend.

use crate::atoms::{AtomRange, is_subset, routine_of};
use crate::bound_range::{BoundRange, Counting, total};
use crate::direct_frame;
use crate::emit::{AtomCode, Emitter, KnownValue, Ssa};
use crate::frame::at;
use asmotion_ir::{DomainId, Local, MAX_CREATED, RoutineId, Rule, Term, TermNode};
use cranelift_codegen::ir::condcodes::IntCC;
use cranelift_codegen::ir::types::{I32, I64};
use cranelift_codegen::ir::{Block, InstBuilder};

impl Emitter<'_> {
    /// Returns `true` if native code can enumerate a domain that rules extend.
    pub fn has_extent(&self, domain: DomainId) -> bool {
        let is_extended = self.program.domains[domain.0 as usize].is_extended;
        let direct = self.direct.as_ref().filter(|_| is_extended);
        direct.is_some_and(|direct| direct.may_use_extent(domain))
    }

    /// Generates a loop over the elements of a domain; see [`Emitter::round`]. Gives up if there are too many.
    pub fn extent_round(
        &mut self,
        (local, domain): (Local, DomainId),
        inner: &[BoundRange],
        counting: Counting,
        body: &mut dyn FnMut(&mut Self, Block),
    ) {
        let Some((elements, count)) = self.extent(domain) else {
            self.gives_up();
            return;
        };
        let many = self.compare(IntCC::UnsignedGreaterThan, count, i64::from(MAX_CREATED));
        self.bail_if(many);
        let (head, next, done) = (self.block(), self.block(), self.block());
        let index = self.builder.append_block_param(head, I64);
        let none = self.number(I64, 0);
        self.advance_updates();
        self.builder
            .ins()
            .brif(count, head, &[none.into()], done, &[]);
        self.begin_loop(head);
        let bytes = self.builder.ins().imul_imm_s(index, at::VALUE_SIZE);
        let element = self.builder.ins().iadd(elements, bytes);
        let value = self.load(self.memory.extents, I32, element, at::PAYLOAD);
        let outer = self.scope.locals[local as usize];
        self.scope.locals[local as usize] = KnownValue::Atom(AtomCode {
            value,
            among: Some(AtomRange::Domain(domain)),
        });
        if let Some(loops) = self.loops.last_mut() {
            loops.rounds.push((index, total(inner)));
        }
        self.repeated(u64::from(MAX_CREATED), |this| {
            if inner.is_empty() {
                body(this, next);
            } else {
                this.round(inner, counting, body);
                this.jump(next);
            }
        });
        if let Some(loops) = self.loops.last_mut() {
            loops.rounds.pop();
        }
        self.scope.locals[local as usize] = outer;
        self.begin(next);
        let successor = self.builder.ins().iadd_imm_s(index, 1);
        let is_last = self.builder.ins().icmp(IntCC::Equal, successor, count);
        self.builder
            .ins()
            .brif(is_last, done, &[], head, &[successor.into()]);
        self.begin(done);
    }

    /// Loads the address and the number of the elements of a domain.
    fn extent(&mut self, domain: DomainId) -> Option<(Ssa, Ssa)> {
        let index = self.direct.as_mut()?.extent(domain)?;
        let [elements, count] = direct_frame::extent_offsets(index);
        let table = self.field(I64, direct_frame::EXTENTS);
        let elements = self.load(self.memory.extents, I64, table, elements);
        Some((elements, self.load(self.memory.extents, I64, table, count)))
    }

    /// Leaves for the detour if an atom is not an element of a domain, which has these constants.
    pub fn check_atom(&mut self, domain: DomainId, first: u32, count: u32, atom: AtomCode) {
        let declared = self.program.atom_domains.len();
        let is_element = match atom.among {
            Some(AtomRange::Domain(of)) => is_subset(self.program, of, domain),
            Some(among @ AtomRange::Atoms(..)) => among.is_within(first, count),
            None => false,
        };
        if is_element {
            return;
        }
        let above = self.builder.ins().iadd_imm_s(atom.value, -i64::from(first));
        let outside = self.compare(IntCC::UnsignedGreaterThanOrEqual, above, i64::from(count));
        // if all created elements are created for subsets, they belong to the domain
        let mut domains = (0..).map(DomainId).zip(&self.program.domains);
        let owns_created = self.program.domains[domain.0 as usize].is_extended
            && domains.all(|(id, of)| !of.is_created_for || is_subset(self.program, id, domain));
        if !owns_created {
            return self.bail_if(outside);
        }
        let is_declared = self.compare(IntCC::UnsignedLessThan, atom.value, declared as i64);
        let outside = self.builder.ins().band(outside, is_declared);
        self.bail_if(outside);
    }

    /// Generates code for the program of an agent, if all agents in question have the same one.
    pub fn run_agent(&mut self, rule: &Rule, agent: &Term, arguments: &[Term]) {
        let Some((agent, routine)) = self.one_program(agent).filter(|_| arguments.is_empty())
        else {
            return self.rule_outside(rule);
        };
        let called = &self.program.routines[routine.0 as usize];
        let native = |this: &mut Self| {
            this.count_call();
            let before = this.direct.is_none().then(|| this.set_agent(agent));
            let outer = this.enter(routine, Vec::new());
            this.scope.agent = Some(agent);
            this.rule(&called.code);
            this.leave(outer);
            if let Some(before) = before {
                this.reset_agent(before);
            }
        };
        self.straight_unit(false, native, |this| this.rule_outside(rule));
    }

    /// Stores the running agent where closures find it, and returns the previous one. That is an atom or undef, so it can
    /// be saved and restored as raw words.
    fn set_agent(&mut self, agent: AtomCode) -> [Ssa; 2] {
        let run = self.run();
        let before =
            [0, at::PAYLOAD].map(|offset| self.load(self.memory.run, I64, run, at::AGENT + offset));
        self.store_scalar(self.memory.run, run, at::AGENT, KnownValue::Atom(agent));
        before
    }

    fn reset_agent(&mut self, before: [Ssa; 2]) {
        let run = self.run();
        for (word, offset) in before.into_iter().zip([0, at::PAYLOAD]) {
            self.store(self.memory.run, word, run, at::AGENT + offset);
        }
    }

    /// Returns the agent, in a register, and the only routine that can be its program.
    fn one_program(&self, agent: &Term) -> Option<(AtomCode, RoutineId)> {
        let TermNode::Local(local) = &*agent.node else {
            return None;
        };
        let Some(KnownValue::Atom(agent)) = self.scope.locals.get(*local as usize) else {
            return None;
        };
        let routine = routine_of(self.program, agent.among?)?;
        let called = &self.program.routines[routine.0 as usize];
        (called.arguments == 0 && self.may_build_in(routine)).then_some((*agent, routine))
    }
}
