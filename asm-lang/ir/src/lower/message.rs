//! Messages of specifications that import CommonBehavior: the functions and literals that the
//! machine needs, and a check of sent messages against the interfaces of their receivers.

use super::facts::walk;
use crate::codes::a040::UnknownOperation;
use crate::codes::a041::MessageMismatch;
use crate::id::FunctionId;
use crate::program::Messages;
use asmotion_diagnostics::{Diagnostic, Finding, Report, Span};
use asmotion_hir::{Domain, Function, FunctionKind, Model, RuleKind, Term, TermKind, Type, TypeId};
use asmotion_value::{Atom, Value};

/// An application of a message rule of the library to a named operation.
#[derive(Clone, Copy, Debug)]
pub struct MessageUse<'a> {
    /// The side of the communication that the rule is on.
    pub role: MessageRole,
    /// The partner agent, the rule's first argument.
    pub partner: &'a Term,
    /// Name of the operation as written, for example `r_plan(Agent,Goal)`.
    pub operation: &'a str,
    /// Span of that name.
    pub at: Span,
    /// The data sent, if any.
    pub data: Option<&'a Term>,
    /// The location that receives the reply, if any.
    pub reply: Option<&'a Term>,
    /// `true` if the rule sends a reply.
    pub is_reply: bool,
}

/// The side of a communication that a message rule is on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MessageRole {
    /// `r_wsend`, `r_wcall`, `r_wsendreceive`, `r_wcancel`: the partner provides the operation.
    Ask,
    /// `r_wreceive`, `r_wreply`: the agent itself provides the operation.
    Serve,
}

/// Lists the places where the rules of the specification apply a message rule to a literal
/// operation name.
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
        // no check of data: the agent serves an operation of its own
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
        is_reply: matches!(rule, "r_wreply" | "r_wreplay"),
    })
}

/// Reports operations that a partner does not provide, and data that they do not accept.
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

/// The operations of a domain of agents: the out functions declared in the same file that take such
/// an agent as their first argument.
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
            let ty = self.model.types.get(data.ty);
            let parts = if let Type::Prod(parts) = ty
                && asked.len() > 1
            {
                parts.clone()
            } else {
                vec![data.ty]
            };
            let fits = parts.len() == asked.len()
                && parts
                    .iter()
                    .zip(asked)
                    .all(|(&part, &asked)| self.fits(asked, part));
            if !fits && !asked.is_empty() {
                let operations: Vec<String> =
                    asked.iter().map(|&ty| self.model.show_type(ty)).collect();
                let what = format!("`{name}` takes {}", operations.join(", "));
                report.push(self.misfit(what, data, operation));
            }
        }
        let answers = !matches!(self.model.types.get(operation.codomain), Type::Rule);
        if let (Some(reply), true) = (used.reply, answers)
            && !self.fits(reply.ty, operation.codomain)
        {
            let answer = self.model.show_type(operation.codomain);
            report.push(self.misfit(format!("`{name}` returns {answer}"), reply, operation));
        }
    }

    fn fits(&self, expected: TypeId, actual: TypeId) -> bool {
        self.model
            .types
            .compatible(expected, actual, &self.model.domains)
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

/// Collects the status function and the literals of the message library; `None` if it is not
/// imported.
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
