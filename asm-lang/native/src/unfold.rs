//! Unfolds definitions in direct rules: the value of an application of a derived or static function is that of its body, and
//! the value of `let` is that of its term.

use crate::emit::{EmitScope, Emitter, KnownValue};
use crate::limits::MAX_INLINED;
use asmotion_ir::{Term, TermNode};

impl Emitter<'_> {
    /// In a direct rule, generates the arguments of a definition or the variables of `let`, and then the value by `value`.
    /// Returns `None`, and generates nothing, if the term is not of this form or not supported.
    pub fn unfolded<T>(
        &mut self,
        term: &Term,
        value: impl FnOnce(&mut Self, &Term) -> T,
    ) -> Option<T> {
        self.direct.as_ref()?;
        if let TermNode::Call(body, arguments) = &*term.node {
            let called = self.program.bodies.get(body.0 as usize)?;
            let is_supported = !called.open
                && called.arguments as usize == arguments.len()
                && arguments.iter().all(|argument| self.is_native(argument))
                && !self.unfolding.contains(body)
                && self.unfolding.len() < MAX_INLINED
                && self.has_room();
            if !is_supported {
                return None;
            }
            let arguments = arguments.iter().map(|argument| self.scalar(argument));
            let mut locals: Vec<KnownValue> = arguments.collect();
            locals.resize(called.locals as usize, KnownValue::Nothing);
            self.counts_call();
            let scope = EmitScope {
                base: self.inner_base(),
                size: called.locals,
                depth: self.scope.depth + 1,
                locals,
                agent: self.scope.agent,
            };
            let outer = std::mem::replace(&mut self.scope, scope);
            self.unfolding.push(*body);
            let result = value(self, &called.code);
            self.unfolding.pop();
            self.scope = outer;
            return Some(result);
        }
        if let TermNode::Let(bindings, body) = &*term.node {
            if !bindings.iter().all(|(_, term)| self.is_native(term)) {
                return None;
            }
            let outer = self.scope.locals.clone();
            for (local, term) in bindings {
                let known = self.scalar(term);
                if let Some(place) = self.scope.locals.get_mut(*local as usize) {
                    *place = known;
                }
            }
            let result = value(self, body);
            self.scope.locals = outer;
            return Some(result);
        }
        if let TermNode::Cached(_, constant) = &*term.node {
            return Some(value(self, constant));
        }
        None
    }
}
