//! The flow of values through terms.

use super::{Denotation, EscapeUse, Frame, InputFlow, MAX_LISTED, Point, integers};
use asmotion_lang::Value;
use asmotion_lang::ir::{Arithmetic, Binder, Collection, Comparison, Origin, Term, TermNode};
use asmotion_lang::stdlib::{Builtin, BuiltinContext};

impl InputFlow<'_> {
    /// Returns what a term can denote.
    pub(super) fn term(&mut self, term: &Term) -> Denotation {
        stacker::maybe_grow(64 * 1024, 1024 * 1024, || self.term_here(term))
    }

    fn term_here(&mut self, term: &Term) -> Denotation {
        match &*term.node {
            TermNode::Constant(Value::Undef) | TermNode::Unbound => Denotation::nothing(),
            TermNode::Constant(value) => Denotation::listed([value.clone()]),
            TermNode::Local(local) => self.at(Point::Variable(self.frame, *local)),
            TermNode::Agent => Denotation::any(),
            TermNode::Slot(function, _) => self.location(*function, term.origin),
            TermNode::Location(function, arguments) => {
                self.need_all(arguments, &EscapeUse::Argument(*function));
                self.location(*function, term.origin)
            }
            TermNode::Call(body, arguments) => {
                self.call(Frame::Body(*body), arguments);
                self.at(Point::Result(*body))
            }
            TermNode::Cached(_, term) | TermNode::Watched(term) | TermNode::Pre(term) => {
                self.term(term)
            }
            TermNode::Builtin(builtin, arguments) => self.builtin(builtin, arguments, term.origin),
            TermNode::Equal(left, right) => {
                self.compare(left, right, false, term.origin);
                Denotation::any()
            }
            TermNode::Compare(
                Comparison::Lt | Comparison::Le | Comparison::Gt | Comparison::Ge,
                left,
                right,
            ) => {
                self.compare(left, right, true, term.origin);
                Denotation::any()
            }
            TermNode::Arithmetic(operation, left, right) => {
                self.arithmetic(*operation, left, right)
            }
            TermNode::If(guard, then, otherwise) => {
                self.need(guard, &EscapeUse::Other);
                let then = self.term(then);
                then.or(self.term(otherwise))
            }
            TermNode::Switch(subject, cases, otherwise) => {
                let mut flow = self.term(otherwise);
                for (case, value) in cases {
                    self.compare(subject, case, false, case.origin);
                    flow = flow.or(self.term(value));
                }
                flow
            }
            TermNode::Let(bindings, body) => {
                for (local, term) in bindings {
                    let flow = self.term(term);
                    self.variable(*local, flow);
                }
                self.term(body)
            }
            TermNode::Logic(_, left, right) => {
                self.need(left, &EscapeUse::Other);
                self.need(right, &EscapeUse::Other);
                Denotation::any()
            }
            TermNode::Tuple(terms) | TermNode::Listed(_, terms) => {
                self.need_all(terms, &EscapeUse::Other);
                Denotation::any()
            }
            TermNode::Not(term)
            | TermNode::Component(term, _)
            | TermNode::Program(term)
            | TermNode::Name(term)
            | TermNode::Named(_, term) => {
                self.need(term, &EscapeUse::Other);
                Denotation::any()
            }
            TermNode::Quantified(_, binders, condition) => {
                self.bind_all(binders);
                self.need_all(condition, &EscapeUse::Other);
                Denotation::any()
            }
            TermNode::Interval(_, from, to, step) => {
                self.need_all([from, to].into_iter().chain(step), &EscapeUse::Other);
                Denotation::any()
            }
            TermNode::Collect(_, binders, guard, item) => {
                self.bind_all(binders);
                self.need_all(guard.iter().chain([item]), &EscapeUse::Other);
                Denotation::any()
            }
            TermNode::Map(pairs) => {
                let terms = pairs.iter().flat_map(|(key, value)| [key, value]);
                self.need_all(terms, &EscapeUse::Other);
                Denotation::any()
            }
            TermNode::CollectMap(binders, guard, key, value) => {
                self.bind_all(binders);
                self.need_all(guard.iter().chain([key, value]), &EscapeUse::Other);
                Denotation::any()
            }
            TermNode::Extent(_) => Denotation::any(),
        }
    }

    pub(super) fn need_all<'t>(
        &mut self,
        terms: impl IntoIterator<Item = &'t Term>,
        usage: &EscapeUse,
    ) {
        for term in terms {
            self.need(term, usage);
        }
    }

    pub(super) fn bind_all(&mut self, binders: &[Binder]) {
        for binder in binders {
            self.bind(binder.local, &binder.range);
        }
    }

    /// Returns what the elements of a collection can be.
    pub(super) fn elements(&mut self, term: &Term) -> Denotation {
        let node = &*term.node;
        if let TermNode::Cached(_, term) | TermNode::Watched(term) | TermNode::Pre(term) = node {
            return self.elements(term);
        }
        if let TermNode::Constant(Value::Set(items)) = node {
            return Denotation::listed(items.iter().cloned());
        }
        if let TermNode::Constant(Value::Seq(items)) = node {
            return Denotation::listed(items.iter().cloned());
        }
        if let TermNode::Listed(collection, items) = node {
            let mut flow = Denotation::nothing();
            for (index, item) in items.iter().enumerate() {
                flow = flow.or(self.term(item));
                for other in items.iter().take(index) {
                    self.collected(*collection, other, item);
                }
            }
            return flow;
        }
        if let TermNode::Interval(_, from, to, None) = node {
            let from = self.need(from, &EscapeUse::Other);
            let to = self.need(to, &EscapeUse::Other);
            return interval(&from, &to);
        }
        if let TermNode::Collect(collection, binders, guard, item) = node {
            self.bind_all(binders);
            self.need_all(guard, &EscapeUse::Other);
            self.collected(*collection, item, item);
            return self.term(item);
        }
        if let TermNode::Extent(shape) = node {
            return self.extent(shape);
        }
        if let TermNode::If(guard, then, otherwise) = node {
            self.need(guard, &EscapeUse::Other);
            let then = self.elements(then);
            return then.or(self.elements(otherwise));
        }
        self.need(term, &EscapeUse::Other);
        Denotation::any()
    }

    /// Two terms become elements of a collection. Equal elements of a set are one element, so that their equality decides how often
    /// a variable takes their value.
    fn collected(&mut self, collection: Collection, one: &Term, other: &Term) {
        match collection {
            Collection::Seq => {}
            Collection::Set | Collection::Bag => self.compare(one, other, false, other.origin),
        }
    }

    /// The application of a library function.
    fn builtin(
        &mut self,
        builtin: &'static Builtin,
        arguments: &[Term],
        origin: Origin,
    ) -> Denotation {
        if let [left, right] = arguments {
            let is_order = ["lt", "le", "gt", "ge"].contains(&builtin.name);
            if is_order || ["eq", "neq"].contains(&builtin.name) {
                self.compare(left, right, is_order, origin);
                return Denotation::any();
            }
        }
        if ["isDef", "isUndef"].contains(&builtin.name) {
            // no input is undef
            for argument in arguments {
                self.term(argument);
            }
            return Denotation::any();
        }
        let mut flows = Vec::new();
        for argument in arguments {
            flows.push(self.need(argument, &EscapeUse::Operand(builtin.name)));
        }
        self.results(builtin, &flows)
    }

    /// Returns the results of a function of numbers for all combinations of listed arguments.
    fn results(&self, builtin: &Builtin, arguments: &[Denotation]) -> Denotation {
        let mut rows: Vec<Vec<Value>> = vec![Vec::new()];
        for argument in arguments {
            let Some(values) = argument
                .values
                .as_ref()
                .filter(|_| argument.inputs.is_empty())
            else {
                return Denotation::any();
            };
            if !values.iter().all(is_number) || rows.len() * values.len() > MAX_LISTED {
                return Denotation::any();
            }
            let longer = rows.iter().flat_map(|row| {
                values.iter().map(|value| {
                    let mut row = row.clone();
                    row.push(value.clone());
                    row
                })
            });
            rows = longer.collect();
        }
        // without arguments, a function depends on something else, such as the time
        if arguments.is_empty() || builtin.prints() || builtin.name.starts_with("random") {
            return Denotation::any();
        }
        let names = self.machine.naming();
        let mut results = Vec::new();
        for row in rows {
            let mut context = BuiltinContext {
                names: &names,
                now_ns: 0,
                printed: &mut Vec::new(),
            };
            match (builtin.body)(&row, &mut context) {
                Ok(value) if is_number(&value) => results.push(value),
                // a step that fails has no result
                Ok(Value::Undef) | Err(_) => {}
                Ok(_) => return Denotation::any(),
            }
        }
        Denotation::listed(results)
    }

    fn arithmetic(&mut self, operation: Arithmetic, left: &Term, right: &Term) -> Denotation {
        let sign = match operation {
            Arithmetic::Plus => "+",
            Arithmetic::Minus => "-",
            Arithmetic::Mult => "*",
            Arithmetic::Mod => "mod",
        };
        let left = self.need(left, &EscapeUse::Operand(sign));
        let right = self.need(right, &EscapeUse::Operand(sign));
        let are_inputs = !(left.inputs.is_empty() && right.inputs.is_empty());
        let (Some(left), Some(right), false) = (left.values, right.values, are_inputs) else {
            return Denotation::any();
        };
        if left.len() * right.len() > MAX_LISTED * MAX_LISTED / 16 {
            return Denotation::any();
        }
        let pairs = left
            .iter()
            .flat_map(|left| right.iter().map(move |right| (left, right)));
        let results = pairs.filter_map(|pair| {
            let (Value::Int(left), Value::Int(right)) = pair else {
                return None;
            };
            // an overflow is a fault, and a step that fails has no result
            match operation {
                Arithmetic::Plus => left.checked_add(*right),
                Arithmetic::Minus => left.checked_sub(*right),
                Arithmetic::Mult => left.checked_mul(*right),
                Arithmetic::Mod if *right == 0 => None,
                Arithmetic::Mod => Some(left.wrapping_rem(*right)),
            }
        });
        Denotation::listed(results.map(Value::Int))
    }
}

fn is_number(value: &Value) -> bool {
    matches!(value, Value::Int(_) | Value::Real(_))
}

/// Returns the integers from the least first bound to the greatest second one.
fn interval(from: &Denotation, to: &Denotation) -> Denotation {
    let integer = |value: Option<&Value>| match value {
        Some(Value::Int(number)) => Some(*number),
        Some(_) | None => None,
    };
    let (Some(from), Some(to)) = (&from.values, &to.values) else {
        return Denotation::any();
    };
    let all_integers = from.iter().chain(to).all(|it| matches!(it, Value::Int(_)));
    match (integer(from.first()), integer(to.last())) {
        (Some(low), Some(high)) if all_integers => integers(low, high),
        // without a bound there is no element
        _ if all_integers => Denotation::nothing(),
        _ => Denotation::any(),
    }
}
