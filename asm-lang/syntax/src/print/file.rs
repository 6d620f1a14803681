//! Layout of files: sections, declarations and properties.

use super::layout::{LayoutBreak, TokenLayout};
use crate::ast::*;
use crate::lexer::{Keyword, Sign, Token};
use asmotion_diagnostics::Span;

/// An item of a section, in source order.
enum SectionItem<'tree> {
    Import(&'tree Import),
    Export(&'tree Export),
    Domain(&'tree Domain),
    Function(&'tree Function),
    DomainDefinition(&'tree DomainDefinition),
    FunctionDefinition(&'tree FunctionDefinition),
    Rule(&'tree RuleDeclaration),
    Property(&'tree Property),
    Agent(&'tree AgentInit),
}

impl TokenLayout<'_> {
    /// Prints the whole file.
    pub(super) fn file(&mut self, file: &File) {
        let mut items = items(file).into_iter();
        loop {
            if self.at_section() {
                self.section(&mut items);
            } else if self.at_heading() {
                self.heading();
            } else if let Some(item) = items.next() {
                self.separate(LayoutBreak::Item);
                self.item(&item);
            } else {
                return;
            }
        }
    }

    /// Prints the heading: `asyncr asm x`.
    fn heading(&mut self) {
        self.separate(LayoutBreak::Item);
        while self.at_heading() {
            self.token();
            self.separate(LayoutBreak::Blank);
        }
        self.token();
    }

    fn at_heading(&self) -> bool {
        matches!(
            self.peek(),
            Some(Token::Keyword(
                Keyword::Asyncr | Keyword::Asm | Keyword::Module
            ))
        )
    }

    fn at_section(&self) -> bool {
        matches!(
            self.peek(),
            Some(Token::Keyword(
                Keyword::Signature | Keyword::Definitions | Keyword::Default | Keyword::Init
            ))
        )
    }

    /// Prints the heading of a section (`signature:`, `definitions:`, `default init s0:`) and its
    /// items.
    fn section<'tree>(&mut self, items: &mut impl Iterator<Item = SectionItem<'tree>>) {
        self.separate(LayoutBreak::Section);
        self.token();
        while self.peek().is_some() && !self.at(Sign::Colon) {
            self.separate(LayoutBreak::Blank);
            self.token();
        }
        self.token();
        self.indent(|all| {
            let mut begin = LayoutBreak::Hard;
            while !all.at_section()
                && !all.at_heading()
                && let Some(item) = items.next()
            {
                all.separate(begin);
                all.item(&item);
                begin = LayoutBreak::Item;
            }
            all.comments_inside();
        });
    }

    fn item(&mut self, item: &SectionItem<'_>) {
        self.group(|it| match item {
            SectionItem::Import(import) => it.import(import),
            SectionItem::Export(export) => it.export(export),
            SectionItem::Domain(domain) => it.domain(domain),
            SectionItem::Function(function) => it.function(function),
            SectionItem::DomainDefinition(definition) => {
                it.words_before(definition.name.span);
                it.token();
                it.definition(&definition.body);
            }
            SectionItem::FunctionDefinition(definition) => {
                it.words_before(definition.name.span);
                it.token();
                it.parameters(&definition.parameters);
                it.definition(&definition.body);
            }
            SectionItem::Rule(rule) => it.rule_declaration(rule),
            SectionItem::Property(property) => it.property(property),
            SectionItem::Agent(agent) => {
                it.words_before(agent.domain.span);
                it.joined(2);
                it.separate(LayoutBreak::Blank);
                it.token();
                it.arguments(&agent.arguments);
            }
        });
    }

    fn import(&mut self, import: &Import) {
        self.token();
        self.separate(LayoutBreak::Blank);
        self.token();
        if let Some(names) = &import.names {
            self.separate(LayoutBreak::Blank);
            self.list(names, LayoutBreak::Fill, |list, _| list.token());
        }
    }

    fn export(&mut self, export: &Export) {
        self.token();
        self.indent(|list| {
            list.separate(LayoutBreak::Blank);
            match &export.names {
                Some(names) => list.items(names, LayoutBreak::Fill, |list, _| list.token()),
                None => list.token(),
            }
        });
    }

    fn domain(&mut self, domain: &Domain) {
        match &domain.kind {
            DomainKind::Concrete(of) => {
                self.words_before(of.span);
                self.type_(of);
            }
            DomainKind::Structured(of) => self.type_(of),
            DomainKind::Any | DomainKind::Basic | DomainKind::Abstract => {
                self.words_before(domain.name.span);
                self.token();
            }
            DomainKind::Enum(literals) => {
                self.words_before(domain.name.span);
                for _ in 0..2 {
                    self.token();
                    self.separate(LayoutBreak::Blank);
                }
                self.rows(literals, LayoutBreak::Fill, |list, _| list.token());
            }
        }
    }

    /// Prints a function: `controlled f: D -> E`.
    pub(super) fn function(&mut self, function: &Function) {
        self.words_before(function.name.span);
        self.joined(2);
        self.indent(|of| {
            of.separate(LayoutBreak::Blank);
            if let Some(domain) = &function.domain {
                of.type_(domain);
                of.separate(LayoutBreak::Line);
                of.token();
                of.separate(LayoutBreak::Blank);
            }
            of.type_(&function.codomain);
        });
    }

    /// Prints a domain in use.
    pub(super) fn type_(&mut self, of: &Type) {
        self.token();
        match &of.kind {
            TypeKind::Named(_) => {}
            TypeKind::Rule(parts) | TypeKind::Prod(parts) => {
                self.types(&parts.iter().collect::<Vec<_>>());
            }
            TypeKind::Seq(part) | TypeKind::Powerset(part) | TypeKind::Bag(part) => {
                self.types(&[part]);
            }
            TypeKind::Map(key, value) => self.types(&[key, value]),
        }
    }

    /// Prints domains in parentheses, if there are any.
    pub(super) fn types(&mut self, types: &[&Type]) {
        if !types.is_empty() {
            self.list(types, LayoutBreak::Line, |list, part| list.type_(part));
        }
    }

    fn parameters(&mut self, parameters: &[Parameter]) {
        if !parameters.is_empty() {
            self.list(parameters, LayoutBreak::Line, |list, parameter| {
                list.words_before(parameter.domain.span);
                list.type_(&parameter.domain);
            });
        }
    }

    /// Prints `= t` of a domain or function; the term stays on a line of its own if the source has
    /// it so.
    fn definition(&mut self, body: &Term) {
        self.separate(LayoutBreak::Blank);
        self.token();
        if self.begins_line() {
            self.indent(|value| {
                value.separate(LayoutBreak::Hard);
                value.term(body);
            });
        } else {
            self.value(body);
        }
    }

    fn rule_declaration(&mut self, rule: &RuleDeclaration) {
        self.words_before(rule.name.span);
        self.token();
        self.parameters(&rule.parameters);
        if let Some(result) = &rule.result {
            self.separate(LayoutBreak::Blank);
            self.words_before(result.span);
            self.type_(result);
        }
        self.separate(LayoutBreak::Blank);
        self.token();
        self.body(&rule.body);
    }

    fn property(&mut self, property: &Property) {
        match &property.kind {
            PropertyKind::Invariant { over, body } => self.invariant(property, over, body),
            PropertyKind::Constraint(body)
            | PropertyKind::Justice(body)
            | PropertyKind::Ctl(body)
            | PropertyKind::Ltl(body) => {
                self.token();
                if property.name.is_some() {
                    self.separate(LayoutBreak::Blank);
                    self.joined(2);
                }
                self.condition(body);
            }
            PropertyKind::Compassion(p, q) => {
                self.token();
                self.list(&[p, q], LayoutBreak::Line, |list, part| list.term(part));
            }
        }
    }

    /// Prints a condition. The arguments of a function are indented anyway, so it is not indented
    /// further.
    fn condition(&mut self, body: &Term) {
        let print = |of: &mut Self| {
            of.separate(LayoutBreak::Blank);
            of.term(body);
        };
        if matches!(*body.kind, TermKind::Apply { .. }) {
            print(self);
        } else {
            self.indent(print);
        }
    }

    fn invariant(&mut self, property: &Property, over: &[Over], body: &Term) {
        self.token();
        self.separate(LayoutBreak::Blank);
        if property.name.is_some() {
            self.token();
            self.separate(LayoutBreak::Blank);
        }
        self.token();
        self.indent(|of| {
            of.separate(LayoutBreak::Blank);
            of.items(over, LayoutBreak::Fill, Self::over);
            of.token();
            of.separate(LayoutBreak::Line);
            of.term(body);
        });
    }

    fn over(&mut self, over: &Over) {
        self.token();
        if self.at(Sign::Open) {
            match &over.domain {
                Some(domain) => self.types(&[domain]),
                None => self.joined(2),
            }
        }
    }
}

/// Returns the items of a file in source order.
fn items(file: &File) -> Vec<SectionItem<'_>> {
    let mut items: Vec<(Span, SectionItem<'_>)> = Vec::new();
    items.extend(
        file.imports
            .iter()
            .map(|it| (it.path.span, SectionItem::Import(it))),
    );
    items.extend(
        file.export
            .iter()
            .map(|it| (it.span, SectionItem::Export(it))),
    );
    items.extend(
        file.domains
            .iter()
            .map(|it| (it.span, SectionItem::Domain(it))),
    );
    items.extend(
        file.functions
            .iter()
            .map(|it| (it.span, SectionItem::Function(it))),
    );
    let inits = || file.inits.iter();
    let domains = file.domain_definitions.iter();
    let domains = domains.chain(inits().flat_map(|init| &init.domains));
    items.extend(domains.map(|it| (it.name.span, SectionItem::DomainDefinition(it))));
    let functions = file.function_definitions.iter();
    let functions = functions.chain(inits().flat_map(|init| &init.functions));
    items.extend(functions.map(|it| (it.name.span, SectionItem::FunctionDefinition(it))));
    let rules = file.rules.iter().chain(&file.main);
    items.extend(rules.map(|it| (it.span, SectionItem::Rule(it))));
    items.extend(
        file.properties
            .iter()
            .map(|it| (it.span, SectionItem::Property(it))),
    );
    let agents = inits().flat_map(|init| &init.agents);
    items.extend(agents.map(|it| (it.domain.span, SectionItem::Agent(it))));
    items.sort_by_key(|(place, _)| *place);
    items.into_iter().map(|(_, item)| item).collect()
}
