//! Spellings of integer literals in the number domain that their place requires.

use crate::codes::a006::Respelt;
use crate::model::{FunctionId, Term, TermKind};
use crate::resolver::Resolver;
use crate::types::{Type, TypeId};
use asmotion_value::Value;

impl Resolver<'_> {
    /// Suggests the spelling of integer arguments in the number domains of the parameters, or, if
    /// there are several candidates, of one in the number domain of the other arguments.
    pub fn respelt(
        &self,
        candidates: &[FunctionId],
        arguments: &[Term],
        roots: &[String],
    ) -> Vec<Respelt> {
        if let [candidate] = candidates {
            return self.respelt_for(*candidate, arguments).unwrap_or_default();
        }
        let mut others = roots.iter().filter(|root| *root != "Integer");
        let domain = others.find_map(|root| Respelt::domain(root));
        let mut arguments = arguments.iter();
        let first = domain
            .and_then(|domain| arguments.find_map(|argument| self.respelt_as(argument, domain)));
        first.into_iter().collect()
    }

    /// Returns the spellings with which all arguments fit a function, if there are any.
    fn respelt_for(&self, function: FunctionId, arguments: &[Term]) -> Option<Vec<Respelt>> {
        let parameters = &self.declared.functions[function.0 as usize].parameters;
        if parameters.len() != arguments.len() {
            return None;
        }
        let pairs = parameters.iter().zip(arguments);
        let unfit = pairs.filter(|(parameter, term)| !self.compatible(**parameter, term.ty));
        let respelt: Option<Vec<_>> = unfit
            .map(|(&parameter, argument)| self.respelt_into(argument, parameter))
            .collect();
        Some(respelt?.concat())
    }

    /// Returns the spelling of an integer literal, possibly behind a minus sign, in a number domain.
    pub fn respelt_as(&self, term: &Term, domain: &'static str) -> Option<Respelt> {
        let negated = self.negated_literal(term);
        let (literal, negative) = (negated.unwrap_or(term), negated.is_some());
        let TermKind::Value(Value::Int(number @ 0..)) = *literal.kind else {
            return None;
        };
        let text = match domain {
            "Real" => format!("{number}.0"),
            "Natural" if !negative => format!("{number}n"),
            "Integer" => number.to_string(),
            _ => return None,
        };
        Some(Respelt {
            at: literal.span,
            domain,
            text,
        })
    }

    /// Returns `t` of `-t`.
    fn negated_literal<'t>(&self, term: &'t Term) -> Option<&'t Term> {
        let TermKind::Apply(function, arguments) = &*term.kind else {
            return None;
        };
        let function = &self.declared.functions[function.0 as usize];
        let [operand] = arguments.as_slice() else {
            return None;
        };
        (&*function.name == "minus" && function.library).then_some(operand)
    }

    /// Returns the spellings of integer literals with which a term has the expected type: of the term, of the elements of a
    /// tuple or collection, or in the branches of a conditional term. `None` if there are none.
    pub fn respelt_into(&self, term: &Term, expected: TypeId) -> Option<Vec<Respelt>> {
        if self.compatible(expected, term.ty) {
            return Some(Vec::new());
        }
        let types = &self.declared.types;
        let root = types.root(expected, &self.declared.domains);
        let domain = Respelt::domain(&self.show(root));
        if let Some(literal) = domain.and_then(|domain| self.respelt_as(term, domain)) {
            return Some(vec![literal]);
        }
        let actual = types.root(term.ty, &self.declared.domains);
        let parts: Vec<(&Term, TypeId)> = if let TermKind::If(_, then, otherwise) = &*term.kind {
            let branches = [then].into_iter().chain(otherwise);
            branches.map(|branch| (branch, expected)).collect()
        } else if let (TermKind::Tuple(items), Type::Prod(parts)) = (&*term.kind, types.get(root)) {
            if items.len() != parts.len() {
                return None;
            }
            items.iter().zip(parts.iter().copied()).collect()
        } else if let TermKind::Listed(_, items) = &*term.kind
            && let (Type::Seq(_), Type::Seq(element))
            | (Type::Powerset(_), Type::Powerset(element))
            | (Type::Bag(_), Type::Bag(element)) = (types.get(actual), types.get(root))
        {
            items.iter().map(|item| (item, *element)).collect()
        } else {
            return None;
        };
        let parts = parts.into_iter();
        let respelt: Option<Vec<_>> = parts
            .map(|(part, expected)| self.respelt_into(part, expected))
            .collect();
        Some(respelt?.concat())
    }
}
