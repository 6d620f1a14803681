//! Assembles a file from its items, which may come in any order.

use super::{Nodes, order};
use crate::ast::*;
use crate::codes::l020::EmptyFile;
use crate::codes::l021::NoHeading;
use crate::codes::l022::SecondHeading;
use crate::codes::l023::SecondExport;
use crate::codes::l024::SecondMain;
use crate::codes::l025::AgentOutsideInit;
use crate::codes::l073::OutOfOrder;
use crate::codes::l074::NoSection;
use crate::findings::SyntaxFindings;
use asmotion_diagnostics::{Edit, Span};

/// An item of a file. A heading opens a section, which ends with the next heading.
pub(crate) enum Item {
    /// `asm x` or `module x`.
    Heading {
        asyncr: bool,
        module: bool,
        name: NameText,
    },
    /// `import x`
    Import(Import),
    /// `export x`
    Export(Export),
    /// `signature:`
    Signature(Span),
    /// A domain of the signature.
    Domain(Domain),
    /// A function of the signature.
    Function(Function),
    /// `definitions:`.
    Definitions(Span),
    /// `domain D = …`, in the definitions or in an initial state.
    DomainDefinition(DomainDefinition),
    /// `function f = …`, in the definitions or in an initial state.
    FunctionDefinition(FunctionDefinition),
    /// A rule other than the main rule.
    Rule(RuleDeclaration),
    /// An invariant, constraint or temporal property.
    Property(Property),
    /// A rule with the keyword `main`.
    Main(RuleDeclaration),
    /// `init x:`
    Init { default: bool, name: NameText },
    /// `agent D: r_x[]`, in an initial state.
    Agent(AgentInit),
    /// A text that could not be parsed.
    Broken(Span),
}

/// Kinds of items, in the order required by AsmetaS.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum FileItemKind {
    Heading,
    Import,
    Export,
    Signature,
    Domain,
    Function,
    Definitions,
    DomainDefinition,
    FunctionDefinition,
    Rule,
    Constraint,
    Fairness,
    Property,
    Main,
    Init,
    DomainInit,
    FunctionInit,
    Agent,
    End,
}

impl FileItemKind {
    /// Returns `true` for the heading of a section.
    fn is_heading(self) -> bool {
        match self {
            Self::Heading | Self::Signature | Self::Definitions | Self::Init | Self::End => true,
            Self::Import
            | Self::Export
            | Self::Domain
            | Self::Function
            | Self::DomainDefinition
            | Self::FunctionDefinition
            | Self::Rule
            | Self::Constraint
            | Self::Fairness
            | Self::Property
            | Self::Main
            | Self::DomainInit
            | Self::FunctionInit
            | Self::Agent => false,
        }
    }

    /// Returns the phrase used in messages, as in "a domain after a function".
    fn described(self) -> &'static str {
        match self {
            Self::Heading => "the heading",
            Self::Import => "an import",
            Self::Export => "the export",
            Self::Signature => "the signature",
            Self::Domain => "a domain",
            Self::Function => "a function",
            Self::Definitions => "the definitions",
            Self::DomainDefinition => "the definition of a domain",
            Self::FunctionDefinition => "the definition of a function",
            Self::Rule => "a rule",
            Self::Constraint => "a constraint",
            Self::Fairness => "a fairness condition",
            Self::Property => "a property",
            Self::Main => "the main rule",
            Self::Init => "an initial state",
            Self::DomainInit => "an initial domain",
            Self::FunctionInit => "an initial function",
            Self::Agent => "an agent",
            Self::End => "the end of the file",
        }
    }
}

impl Nodes<'_, '_> {
    /// Sorts the items into their sections.
    pub(crate) fn file(&self, items: Vec<(usize, Item, usize)>) -> File {
        let mut assembly = FileBuilder::new(self.findings, self.text);
        let end = self.span(self.text.len(), self.text.len());
        if items.is_empty() && !self.findings.has_errors() {
            self.findings.report(EmptyFile { at: end });
            return assembly.file;
        }
        let mut kinds = items.iter();
        assembly.has_broken = kinds.any(|(_, item, _)| matches!(item, Item::Broken(_)));
        for (start, item, stop) in items {
            assembly.whole = self.span(start, stop);
            assembly.add(item);
        }
        assembly.whole = end;
        assembly.place(FileItemKind::End, end);
        if assembly.in_order && assembly.file.unread.is_empty() {
            order::rules(self.text, &assembly.file.rules, self.findings);
        }
        assembly.file
    }
}

/// A file under construction.
struct FileBuilder<'run> {
    findings: &'run SyntaxFindings,
    text: &'run str,
    file: File,
    /// Whether a text could not be parsed: the item before it may have lost its end.
    has_broken: bool,
    /// Span of the item that is being added.
    whole: Span,
    /// The items in correct order so far, since the order last restarted.
    placed: Vec<(FileItemKind, Span)>,
    /// The latest kind in the order so far, with its last item.
    furthest: Option<(FileItemKind, Span)>,
    in_order: bool,
    heading: Option<Span>,
    signature: bool,
    definitions: bool,
}

impl<'run> FileBuilder<'run> {
    fn new(findings: &'run SyntaxFindings, text: &'run str) -> Self {
        Self {
            findings,
            text,
            file: empty(),
            has_broken: false,
            whole: Span::default(),
            placed: Vec::new(),
            furthest: None,
            in_order: true,
            heading: None,
            signature: false,
            definitions: false,
        }
    }

    fn add(&mut self, item: Item) {
        let in_init = !self.file.inits.is_empty();
        match item {
            Item::Heading {
                asyncr,
                module,
                name,
            } => self.heading(asyncr, module, name),
            Item::Import(import) => {
                self.place(FileItemKind::Import, import.path.span);
                self.file.imports.push(import);
            }
            Item::Export(export) => self.export(export),
            Item::Signature(span) => {
                self.place(FileItemKind::Signature, span);
                self.signature = true;
            }
            Item::Domain(domain) => {
                self.place(FileItemKind::Domain, domain.name.span);
                self.file.domains.push(domain);
            }
            Item::Function(function) => {
                self.place(FileItemKind::Function, function.name.span);
                self.file.functions.push(function);
            }
            Item::Definitions(span) => {
                self.place(FileItemKind::Definitions, span);
                self.definitions = true;
            }
            Item::DomainDefinition(definition) => {
                let kind = if in_init {
                    FileItemKind::DomainInit
                } else {
                    FileItemKind::DomainDefinition
                };
                self.place(kind, definition.name.span);
                match self.file.inits.last_mut() {
                    Some(init) => init.domains.push(definition),
                    None => self.file.domain_definitions.push(definition),
                }
            }
            Item::FunctionDefinition(definition) => {
                let kind = if in_init {
                    FileItemKind::FunctionInit
                } else {
                    FileItemKind::FunctionDefinition
                };
                self.place(kind, definition.name.span);
                match self.file.inits.last_mut() {
                    Some(init) => init.functions.push(definition),
                    None => self.file.function_definitions.push(definition),
                }
            }
            Item::Rule(rule) => {
                self.place(FileItemKind::Rule, rule.name.span);
                self.file.rules.push(rule);
            }
            Item::Property(property) => {
                self.place(kind_of(&property.kind), property.span);
                self.file.properties.push(property);
            }
            Item::Main(rule) => self.main(rule),
            Item::Init { default, name } => {
                self.begin_init(name.span);
                self.file.inits.push(Init {
                    name,
                    default,
                    domains: Vec::new(),
                    functions: Vec::new(),
                    agents: Vec::new(),
                });
            }
            Item::Agent(agent) => self.agent(agent),
            Item::Broken(place) => self.file.unread.push(place),
        }
    }

    fn heading(&mut self, asyncr: bool, module: bool, name: NameText) {
        if let Some(first) = self.heading {
            self.findings.report(SecondHeading {
                at: name.span,
                first,
            });
            return;
        }
        self.place(FileItemKind::Heading, name.span);
        self.heading = Some(name.span);
        self.file.asyncr = asyncr;
        self.file.module = module;
        self.file.name = Some(name);
    }

    fn export(&mut self, export: Export) {
        self.place(FileItemKind::Export, export.span);
        if let Some(first) = &self.file.export {
            let (at, first) = (export.span, first.span);
            self.findings.report(SecondExport { at, first });
            return;
        }
        self.file.export = Some(export);
    }

    fn main(&mut self, rule: RuleDeclaration) {
        self.place(FileItemKind::Main, rule.name.span);
        if let Some(first) = &self.file.main {
            let (at, first) = (rule.name.span, first.name.span);
            self.findings.report(SecondMain { at, first });
            return;
        }
        self.file.main = Some(rule);
    }

    fn agent(&mut self, agent: AgentInit) {
        let Some(init) = self.file.inits.last_mut() else {
            self.findings.report(AgentOutsideInit {
                at: agent.domain.span,
            });
            return;
        };
        let at = agent.domain.span;
        init.agents.push(agent);
        self.place(FileItemKind::Agent, at);
    }

    /// Restarts the order, which applies within each initial state separately.
    fn begin_init(&mut self, at: Span) {
        if self
            .furthest
            .is_some_and(|(kind, _)| kind > FileItemKind::Init)
        {
            self.furthest = Some((FileItemKind::Init, at));
            self.placed.clear();
        }
        self.place(FileItemKind::Init, at);
    }

    /// Checks the position of an item against the order required by AsmetaS; reported once.
    fn place(&mut self, kind: FileItemKind, at: Span) {
        if self.furthest.is_none() && kind != FileItemKind::Heading && self.file.unread.is_empty() {
            self.findings.report(NoHeading { at });
        }
        let (text, whole) = (self.text, self.whole);
        let mut section = |missing: bool, section: &'static str| {
            if missing && self.in_order && self.file.unread.is_empty() {
                let what = kind.described();
                self.findings.report(NoSection {
                    section,
                    what,
                    at,
                    written: order::heading(text, section, whole),
                });
                self.in_order = false;
            }
        };
        section(
            kind > FileItemKind::Signature && !self.signature,
            "signature",
        );
        section(
            kind > FileItemKind::Definitions && !self.definitions,
            "definitions",
        );
        match self.furthest {
            Some((furthest, earlier)) if kind < furthest => {
                // after a text that could not be read, the kind may be that of the remains: of `controlled i: D`, in
                // which `i` is no name, `D` is left and looks like a domain
                if self.in_order && self.file.unread.is_empty() {
                    let (what, before) = (kind.described(), furthest.described());
                    self.findings.report(OutOfOrder {
                        what,
                        before,
                        at,
                        earlier,
                        moved: self.moved(kind),
                    });
                    self.in_order = false;
                }
            }
            _ => {
                self.furthest = Some((kind, at));
                self.placed.push((kind, self.whole));
            }
        }
    }

    /// Returns the edits that move the current item before the first one that belongs after it; none if an item may lack its
    /// end.
    fn moved(&self, kind: FileItemKind) -> Vec<Edit> {
        let later = self.placed.iter().find(|(other, _)| *other > kind);
        match later {
            Some((_, later)) if !kind.is_heading() && !self.has_broken => {
                order::moved(self.text, self.whole, *later)
            }
            Some(_) | None => Vec::new(),
        }
    }
}

fn kind_of(property: &PropertyKind) -> FileItemKind {
    match property {
        PropertyKind::Constraint(_) => FileItemKind::Constraint,
        PropertyKind::Justice(_) | PropertyKind::Compassion(..) => FileItemKind::Fairness,
        PropertyKind::Invariant { .. } | PropertyKind::Ctl(_) | PropertyKind::Ltl(_) => {
            FileItemKind::Property
        }
    }
}

/// Returns a file without contents.
pub(crate) fn empty() -> File {
    File {
        asyncr: false,
        module: false,
        name: None,
        imports: Vec::new(),
        export: None,
        domains: Vec::new(),
        functions: Vec::new(),
        domain_definitions: Vec::new(),
        function_definitions: Vec::new(),
        rules: Vec::new(),
        properties: Vec::new(),
        main: None,
        inits: Vec::new(),
        annotations: Vec::new(),
        unread: Vec::new(),
    }
}
