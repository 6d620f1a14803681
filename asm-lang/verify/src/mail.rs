//! Messages of a system: who exchanges them with whom, and the alternatives of partners that are not part of the system.

use crate::codes::m005::UnknownContent;
use crate::inputs::MAX_VALUES;
use crate::system::{MessageLink, SystemSpecification, VerifiedMachine};
use asmotion_diagnostics::{Finding, Span};
use asmotion_lang::hir::{Model, TermKind, Type};
use asmotion_lang::ir::{FunctionKind, MessageRole, message_uses};
use asmotion_lang::simulate::{Script, ScriptedAnswer};
use asmotion_lang::stdlib::operation as operation_name;
use asmotion_lang::{Machine, Report, Value};

/// The transport of messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MessageModel {
    /// `true` if a message can be lost.
    pub is_lossy: bool,
    /// `true` if a message can arrive any number of steps later. Messages of one sender to one receiver arrive in order. Otherwise
    /// a message arrives before the next step of its receiver.
    pub is_delayed: bool,
    /// Number of messages that can wait for a machine.
    pub mailbox: usize,
}

impl Default for MessageModel {
    fn default() -> Self {
        Self {
            is_lossy: false,
            is_delayed: false,
            mailbox: 4,
        }
    }
}

/// The contents of messages from outside, in place of those of the domain.
#[derive(Clone, Debug)]
pub struct ContentValues {
    /// Index of the machine that receives them.
    pub machine: usize,
    /// The partner that replies; `None` for requests from outside.
    pub partner: Option<Value>,
    /// Name of the operation.
    pub operation: String,
    /// Possible contents, in the order in which they are tried.
    pub values: Vec<Value>,
}

impl ContentValues {
    /// Describes the contents, as in `planner.plan in {0, 1}`.
    pub(crate) fn describe(&self, machine: &Machine) -> String {
        let naming = machine.naming();
        let values = self.values.iter();
        let values: Vec<String> = values.map(|it| it.show(&naming).to_string()).collect();
        let partner = self.partner.as_ref();
        let partner = partner.map_or_else(String::new, |it| format!("{}.", it.show(&naming)));
        format!("{partner}{} in {{{}}}", self.operation, values.join(", "))
    }
}

/// An operation that a machine requests from a partner.
#[derive(Clone, Debug)]
pub(crate) struct AskedOperation {
    pub partner: Value,
    pub operation: String,
    /// The machine that the partner is; `None` if it is not part of the system.
    pub provider: Option<usize>,
    /// Possible replies of a partner that is not part of the system; empty if none is awaited.
    pub replies: Vec<Value>,
}

/// An operation that a machine provides.
#[derive(Clone, Debug)]
pub(crate) struct ServedOperation {
    pub operation: String,
    /// `true` if the machine replies to it.
    pub is_answered: bool,
    /// Possible contents of requests from outside; empty if there are none.
    pub requests: Vec<Value>,
}

/// The messages that a machine exchanges.
#[derive(Clone, Debug, Default)]
pub(crate) struct MachineMessages {
    pub asked: Vec<AskedOperation>,
    pub served: Vec<ServedOperation>,
    /// Agents that stand for partners outside the specification.
    pub partners: Vec<Value>,
    /// `true` if the specification imports the library for messages.
    pub is_used: bool,
}

impl MachineMessages {
    /// Returns the request for an operation of a partner.
    pub fn asked(&self, partner: &Value, operation: &str) -> Option<&AskedOperation> {
        let mut asked = self.asked.iter();
        asked.find(|it| it.partner == *partner && it.operation == operation)
    }

    /// Returns `true` if the machine may reply to an operation.
    pub fn is_answered(&self, operation: &str) -> bool {
        let mut served = self.served.iter();
        let known = served.find(|it| it.operation == operation);
        known.is_none_or(|it| it.is_answered)
    }
}

/// The messages of all machines.
#[derive(Clone, Debug, Default)]
pub(crate) struct MessagePlan {
    pub model: MessageModel,
    pub machines: Vec<MachineMessages>,
    /// Replies of partners that a script plays. There is one machine then.
    pub scripted: Vec<ScriptedAnswer>,
}

impl MessagePlan {
    /// Returns `true` if a machine exchanges messages.
    pub fn is_used(&self) -> bool {
        self.machines.iter().any(|it| it.is_used)
    }

    /// Returns the index of the scripted reply of a partner to an operation.
    pub fn answer(&self, partner: &Value, operation: &str) -> Option<usize> {
        let mut scripted = self.scripted.iter();
        scripted.position(|it| it.partner == *partner && it.operation == operation)
    }

    /// Describes what is assumed of messages.
    pub fn assumptions(&self) -> Vec<String> {
        let mut assumed = Vec::new();
        if !self.is_used() {
            return assumed;
        }
        let lost = if self.model.is_lossy {
            "can be lost"
        } else {
            "are not lost"
        };
        let late = if self.model.is_delayed {
            "arrive any number of steps later"
        } else {
            "arrive before the next step of their receiver"
        };
        assumed.push(format!("messages {lost} and {late}"));
        for answer in &self.scripted {
            assumed.push(format!(
                "`{}` is answered as the script says",
                answer.operation
            ));
        }
        let mut served = self.machines.iter().flat_map(|it| &it.served);
        if served.any(|it| !it.requests.is_empty()) {
            let bound = self.model.mailbox;
            assumed.push(format!(
                "requests from outside come while fewer than {bound} messages wait"
            ));
        }
        assumed
    }

    /// Finds the partners of all machines.
    ///
    /// # Errors
    /// The contents of messages from outside cannot be enumerated: the machine, and a report.
    pub fn of(
        system: &SystemSpecification,
        machines: &[Machine],
        model: MessageModel,
        contents: &[ContentValues],
        script: Option<&Script>,
    ) -> Result<Self, (usize, Report)> {
        let scripted = script.map(Script::answers).unwrap_or_default();
        let mut plan = Self {
            model,
            machines: Vec::new(),
            scripted: scripted.to_vec(),
        };
        let links = links_by_name(system);
        for (index, known) in system.machines.iter().enumerate() {
            let Some(machine) = machines.get(index) else {
                continue;
            };
            let own = MailReader {
                index,
                known,
                machine,
                links: &links,
                contents,
                scripted,
                is_open: system.ignores_names.then(|| system.open.contains(&index)),
                report: Report::new(),
            };
            let (messages, report) = own.messages();
            if report.has_errors() {
                return Err((index, report.finish()));
            }
            plan.machines.push(messages);
        }
        Ok(plan)
    }
}

/// The operations that a specification requests, with the agents that stand for the partners.
fn asked_operations(known: &VerifiedMachine) -> Vec<(Value, String)> {
    let model = &known.specification.model;
    let uses = message_uses(model);
    let asked = uses.iter().filter(|used| used.role == MessageRole::Ask);
    let outside = asked.filter_map(|used| {
        let TermKind::Value(partner @ Value::Atom(_)) = &*used.partner.kind else {
            return None;
        };
        let Type::Domain(domain) = model.types.get(used.partner.ty) else {
            return None;
        };
        // an agent with a program is part of the specification
        let is_agent = model.programs.iter().any(|it| it.domain == *domain);
        (!is_agent).then(|| (partner.clone(), operation_name(used.operation).to_owned()))
    });
    outside.collect()
}

fn serves(model: &Model, operation: &str) -> bool {
    let uses = message_uses(model);
    let mut served = uses.iter().filter(|used| used.role == MessageRole::Serve);
    served.any(|used| operation_name(used.operation) == operation && !is_of_partner(used.partner))
}

/// Returns `true` if messages come from a declared partner: they are its replies.
fn is_of_partner(partner: &asmotion_lang::hir::Term) -> bool {
    matches!(&*partner.kind, TermKind::Value(Value::Atom(_)))
}

/// Adds the links that follow from names: a partner is the machine with its name, or the only other machine that serves the operations
/// that it is asked for.
fn links_by_name(system: &SystemSpecification) -> Vec<MessageLink> {
    let mut links = system.message_links.clone();
    if system.ignores_names {
        return links;
    }
    for (client, known) in system.machines.iter().enumerate() {
        for (partner, operation) in asked_operations(known) {
            let is_linked = |link: &MessageLink| link.client == client && link.partner == partner;
            if links.iter().any(is_linked) {
                continue;
            }
            let others = system.machines.iter().enumerate();
            let others = others.filter(|(other, machine)| {
                *other != client && serves(&machine.specification.model, &operation)
            });
            let others: Vec<usize> = others.map(|(other, _)| other).collect();
            let names = &known.specification.program.symbols.atoms;
            let name = if let Value::Atom(atom) = &partner {
                names.get(atom.0 as usize).map(|name| &**name)
            } else {
                None
            };
            let named = others.iter().copied().find(|other| {
                let machine = system.machines.get(*other);
                machine.is_some_and(|it| Some(it.name.as_str()) == name)
            });
            let provider = match (named, others.as_slice()) {
                (Some(named), _) => named,
                (None, [only]) => *only,
                (None, _) => continue,
            };
            links.push(MessageLink {
                client,
                partner,
                provider,
            });
        }
    }
    links
}

/// Reads the messages of one machine.
struct MailReader<'a> {
    index: usize,
    known: &'a VerifiedMachine,
    machine: &'a Machine,
    links: &'a [MessageLink],
    contents: &'a [ContentValues],
    scripted: &'a [ScriptedAnswer],
    /// Whether components outside the verified system send requests; `None` derives it from the links.
    is_open: Option<bool>,
    report: Report,
}

impl MailReader<'_> {
    fn messages(mut self) -> (MachineMessages, Report) {
        let model = &self.known.specification.model;
        let mut messages = MachineMessages {
            is_used: self.machine.program().messages.is_some(),
            ..MachineMessages::default()
        };
        let uses = message_uses(model);
        for (partner, operation) in asked_operations(self.known) {
            if messages.asked(&partner, &operation).is_some() {
                continue;
            }
            let mut links = self.links.iter();
            let link = links.find(|it| it.client == self.index && it.partner == partner);
            let provider = link.map(|it| it.provider);
            let awaited = uses.iter().find(|used| {
                let is_reply = used.reply.is_some() && used.role == MessageRole::Ask;
                let is_received = used.role == MessageRole::Serve && is_of_partner(used.partner);
                (is_reply || is_received) && operation_name(used.operation) == operation
            });
            let mut scripted = self.scripted.iter();
            let is_played = scripted.any(|it| it.partner == partner && it.operation == operation);
            let replies = match (provider, awaited) {
                (None, Some(used)) if !is_played => self.replies(&partner, &operation, used.at),
                (Some(_), _) | (None, _) => Vec::new(),
            };
            if !messages.partners.contains(&partner) {
                messages.partners.push(partner.clone());
            }
            messages.asked.push(AskedOperation {
                partner,
                operation,
                provider,
                replies,
            });
        }
        for used in &uses {
            let operation = operation_name(used.operation);
            if used.role != MessageRole::Serve || is_of_partner(used.partner) {
                continue;
            }
            if let Some(known) = messages
                .served
                .iter_mut()
                .find(|it| it.operation == operation)
            {
                known.is_answered |= used.is_reply;
                continue;
            }
            let is_open = self.is_open.unwrap_or_else(|| {
                let mut links = self.links.iter();
                links.all(|it| it.provider != self.index) && !self.has_local_client(operation)
            });
            let requests = if is_open {
                self.requests(operation, used.at)
            } else {
                Vec::new()
            };
            messages.served.push(ServedOperation {
                operation: operation.to_owned(),
                is_answered: used.is_reply,
                requests,
            });
        }
        for answer in self.scripted {
            if !messages.partners.contains(&answer.partner) {
                messages.partners.push(answer.partner.clone());
            }
        }
        // requests from other specifications have undef as their sender and receiver
        if !messages.served.is_empty() {
            messages.partners.push(Value::Undef);
        }
        (messages, self.report)
    }

    /// Returns `true` if an agent of the specification itself sends requests of an operation.
    fn has_local_client(&self, operation: &str) -> bool {
        let model = &self.known.specification.model;
        let outside = asked_operations(self.known);
        let uses = message_uses(model);
        let mut asked = uses.iter().filter(|used| used.role == MessageRole::Ask);
        asked.any(|used| {
            operation_name(used.operation) == operation
                && !outside.iter().any(|(_, known)| known == operation)
        })
    }

    fn given(&self, partner: Option<&Value>, operation: &str) -> Option<Vec<Value>> {
        let mut contents = self.contents.iter();
        let given = contents.find(|it| {
            it.machine == self.index && it.partner.as_ref() == partner && it.operation == operation
        });
        given.map(|it| it.values.clone())
    }

    fn replies(&mut self, partner: &Value, operation: &str, at: Span) -> Vec<Value> {
        if let Some(given) = self.given(Some(partner), operation) {
            return given;
        }
        let program = self.machine.program();
        let known = program.operation(operation);
        if !known.replies {
            return Vec::new();
        }
        if let Some(values) = self.machine.elements(&known.gives, MAX_VALUES) {
            return values;
        }
        let naming = self.machine.naming();
        let operation = format!("{}.{operation}", partner.show(&naming));
        self.refuse("replies", operation, at)
    }

    fn requests(&mut self, operation: &str, at: Span) -> Vec<Value> {
        if let Some(given) = self.given(None, operation) {
            return given;
        }
        let program = self.machine.program();
        let known = program.operation(operation);
        let functions = program.symbols.functions.iter().zip(&program.functions);
        let has_no_data = functions.into_iter().any(|(name, function)| {
            function.own
                && function.kind == FunctionKind::Out
                && function.parameters.len() == 1
                && operation_name(name) == operation
        });
        if has_no_data {
            return vec![Value::Bool(true)];
        }
        if let Some(values) = self.machine.elements(&known.takes, MAX_VALUES) {
            return values;
        }
        self.refuse("requests", operation.to_owned(), at)
    }

    fn refuse(&mut self, content: &'static str, operation: String, at: Span) -> Vec<Value> {
        let finding = UnknownContent {
            content,
            operation,
            at,
        };
        self.report.push(finding.diagnostic());
        Vec::new()
    }
}
