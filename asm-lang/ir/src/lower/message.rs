//! Messages: what a specification that imports CommonBehavior tells about them with, and whether those
//! it sends are those that its partners know.

use super::facts::walk;
use crate::codes::a040::UnknownOperation;
use crate::codes::a041::MessageMismatch;
use crate::program::{FunctionId, Messages};
use asmotion_diagnostics::{Diagnostic, Finding, Report, Span};
use asmotion_hir::{Domain, Function, FunctionKind, Model, RuleKind, Term, TermKind, Type, TypeId};
use asmotion_value::{Atom, Value};

/// A rule of the library applied: who it speaks to about what.
#[derive(Clone, Copy, Debug)]
pub struct MessageUse<'a> {
    /// What it does.
    pub role: MessageRole,
    /// The partner.
    pub partner: &'a Term,
    /// The operation, as it is spelt.
    pub operation: &'a str,
    /// Where that stands.
    pub at: Span,
    /// What is said.
    pub data: Option<&'a Term>,
    /// Where it is put what the partner says.
    pub reply: Option<&'a Term>,
}

/// What a rule of the library does with a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MessageRole {
    /// `r_wsend`, `r_wcall`, `r_wsendreceive`, `r_wcancel`: the partner has the operation.
    Ask,
    /// `r_wreceive`, `r_wreply`: the agent itself has it.
    Serve,
}

/// Where the specification itself applies a rule of the library to an operation that it names.
pub fn message_uses(model: &Model) -> Vec<MessageUse<'_>> {
    let mut uses = Vec::new();
    for rule in model.rules.iter().filter(|rule| !rule.library) {
        if let Some(body) = &rule.body {
            walk(&body.root, &mut |rule| {
                if let RuleKind::Call(callee, arguments) = &*rule.kind
                    && model.rule(*callee).library
                {
                    uses.extend(message_use(&model.rule(*callee).name, arguments));
                }
            });
        }
    }
    uses
}

fn message_use<'a>(rule: &str, arguments: &'a [Term]) -> Option<MessageUse<'a>> {
    let [partner, operation, rest @ ..] = arguments else {
        return None;
    };
    let (role, data, reply) = match (rule, rest) {
        ("r_wsend", rest) => (MessageRole::Ask, rest.first(), None),
        ("r_wcancel", _) => (MessageRole::Ask, None, None),
        ("r_wcall", [data, _, reply]) | ("r_wsendreceive", [data, reply]) => {
            (MessageRole::Ask, Some(data), Some(reply))
        }
        ("r_wsendreceive", [reply]) => (MessageRole::Ask, None, Some(reply)),
        // what an agent is asked and answers, it knows from itself
        ("r_wreceive" | "r_wreply" | "r_wreplay", _) => (MessageRole::Serve, None, None),
        _ => return None,
    };
    let TermKind::Value(Value::Text(text)) = &*operation.kind else {
        return None;
    };
    Some(MessageUse {
        role,
        partner,
        operation: text.as_str(),
        at: operation.span,
        data,
        reply,
    })
}

/// Operations that partners do not have, and data that these do not take.
pub(super) fn check(model: &Model, report: &mut Report) {
    for used in message_uses(model) {
        if used.role == MessageRole::Serve {
            continue;
        }
        if let Some(interface) = AgentInterface::of(model, used.partner.ty) {
            interface.check(&used, report);
        }
    }
}

/// What a domain of agents can do: the out functions that are declared where it is, for an agent each.
struct AgentInterface<'a> {
    model: &'a Model,
    domain: &'a Domain,
    operations: Vec<&'a Function>,
}

impl<'a> AgentInterface<'a> {
    fn of(model: &'a Model, partner: TypeId) -> Option<Self> {
        let Type::Domain(id) = model.types.get(partner) else {
            return None;
        };
        let domain = model.domain(*id);
        let functions = model.functions.iter().filter(|function| {
            function.kind == FunctionKind::Out
                && !function.library
                && function.span.file == domain.span.file
                && function
                    .parameters
                    .first()
                    .is_some_and(|&first| model.types.compatible(first, partner, &model.domains))
        });
        let operations: Vec<_> = functions.collect();
        (!operations.is_empty()).then_some(Self {
            model,
            domain,
            operations,
        })
    }

    fn check(&self, used: &MessageUse<'_>, report: &mut Report) {
        let name = asmotion_stdlib::operation(used.operation);
        let mut known = self.operations.iter();
        let Some(operation) = known.find(|known| asmotion_stdlib::operation(&known.name) == name)
        else {
            report.push(self.unknown(used, name));
            return;
        };
        if let (Some(data), [_, asked @ ..]) = (used.data, operation.parameters.as_slice()) {
            let parts = match self.model.types.get(data.ty) {
                Type::Prod(parts) if asked.len() > 1 => parts.clone(),
                _ => vec![data.ty],
            };
            let fits = parts.len() == asked.len()
                && parts
                    .iter()
                    .zip(asked)
                    .all(|(&part, &asked)| self.fits(asked, part));
            if !fits && !asked.is_empty() {
                let asked: Vec<String> = asked.iter().map(|&ty| self.model.show_type(ty)).collect();
                let what = format!("`{name}` is asked with {}", asked.join(", "));
                report.push(self.misfit(what, data, operation));
            }
        }
        let answers = !matches!(self.model.types.get(operation.codomain), Type::Rule);
        if let (Some(reply), true) = (used.reply, answers)
            && !self.fits(reply.ty, operation.codomain)
        {
            let answer = self.model.show_type(operation.codomain);
            report.push(self.misfit(format!("`{name}` answers with {answer}"), reply, operation));
        }
    }

    fn fits(&self, wanted: TypeId, actual: TypeId) -> bool {
        self.model
            .types
            .compatible(wanted, actual, &self.model.domains)
    }

    fn unknown(&self, used: &MessageUse<'_>, name: &str) -> Diagnostic {
        UnknownOperation {
            domain: self.domain.name.clone(),
            name: name.to_owned(),
            at: used.at,
            declared: self.domain.span,
            known: self
                .operations
                .iter()
                .map(|known| known.name.clone())
                .collect(),
        }
        .diagnostic()
    }

    fn misfit(&self, expectation: String, term: &Term, operation: &Function) -> Diagnostic {
        MessageMismatch {
            expectation,
            actual: self.model.show_type(term.ty),
            at: term.span,
            declared: operation.span,
        }
        .diagnostic()
    }
}

/// The status of agents and the literals of the library, if it is imported.
pub(super) fn messages(model: &Model) -> Option<Messages> {
    let literal = |function: &str, name: &str| {
        let (_, function) = library_function(model, function)?;
        let Type::Domain(domain) = model.types.get(function.codomain) else {
            return None;
        };
        let mut atoms = (0..).zip(&model.atoms);
        let found = atoms.find(|(_, atom)| atom.domain == *domain && &*atom.name == name);
        found.map(|(index, _)| Value::Atom(Atom(index)))
    };
    let (status, _) = library_function(model, "status")?;
    Some(Messages {
        status,
        ready: literal("status", "READY")?,
        blocked: literal("status", "BLOCKED")?,
        available: literal("communicatorStatus", "AVAILABLE")?,
        unavailable: literal("communicatorStatus", "UNAVAILABLE")?,
        timeout: literal("callFault", "CALL_TIMEOUT")?,
        no_provider: literal("callFault", "CALL_UNAVAILABLE")?,
        failed: literal("callFault", "CALL_FAILED")?,
        cancelled: literal("callFault", "CALL_CANCELLED")?,
    })
}

fn library_function<'a>(
    model: &'a Model,
    name: &str,
) -> Option<(FunctionId, &'a asmotion_hir::Function)> {
    let mut functions = (0..).zip(&model.functions);
    let found = functions.find(|(_, function)| function.library && &*function.name == name);
    found.map(|(index, function)| (FunctionId(index), function))
}
