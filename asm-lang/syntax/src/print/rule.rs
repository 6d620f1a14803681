//! Layout of rules: a rule on one line of the source stays so if it fits; all others are spread
//! over lines.

use super::branch::If;
use super::layout::{LayoutBreak, TokenLayout};
use crate::ast::*;
use crate::lexer::Sign;

impl TokenLayout<'_> {
    pub(super) fn rule(&mut self, rule: &Rule) {
        let lines = self.in_lines(rule.span);
        self.group(|it| it.rule_kind(&rule.kind, lines));
    }

    fn rule_kind(&mut self, kind: &RuleKind, lines: bool) {
        match kind {
            RuleKind::Skip | RuleKind::Invalid => self.token(),
            RuleKind::Update { target, value } => {
                self.assignee(target);
                self.separate(LayoutBreak::Blank);
                self.token();
                self.value(value);
            }
            RuleKind::Assign {
                target, arguments, ..
            } => {
                self.assignee(target);
                self.separate(LayoutBreak::Blank);
                self.token();
                self.separate(LayoutBreak::Blank);
                self.token();
                self.arguments(arguments);
            }
            RuleKind::Macro { arguments, .. } | RuleKind::Turbo { arguments, .. } => {
                self.token();
                self.arguments(arguments);
            }
            RuleKind::Term { term, arguments } => {
                self.term(term);
                if self.at(Sign::OpenBracket) {
                    self.arguments(arguments);
                }
            }
            RuleKind::Par(rules) | RuleKind::Seq(rules) => self.block(rules, lines),
            RuleKind::If {
                guard,
                then,
                otherwise,
            } => self.choose_if(&If::of(guard, then, otherwise), lines),
            RuleKind::Switch(SwitchRule {
                subject,
                cases,
                otherwise,
            }) => self.choose_case(subject, cases, otherwise.as_ref(), lines),
            RuleKind::Choose {
                binders,
                guard,
                body,
                ifnone,
            } => {
                self.choice(binders, guard.as_ref());
                self.branch(body, lines);
                if let Some(ifnone) = ifnone {
                    self.separate(LayoutBreak::line(lines));
                    self.token();
                    self.branch(ifnone, lines);
                }
            }
            RuleKind::Forall {
                binders,
                guard,
                body,
            } => {
                self.choice(binders, guard.as_ref());
                self.branch(body, lines);
            }
            RuleKind::Let { bindings, body } => {
                self.bindings(bindings);
                self.branch(body, lines);
                self.end(lines);
            }
            RuleKind::Extend {
                variables, body, ..
            } => {
                self.extend(variables);
                self.branch(body, lines);
            }
            RuleKind::While { guard, body } | RuleKind::WhileRec { guard, body } => {
                self.guarded(guard);
                self.branch(body, lines);
            }
            RuleKind::Iterate(body) => {
                self.token();
                self.branch(body, lines);
                self.end(lines);
            }
            RuleKind::Local { functions, body } => self.local(functions, body, lines),
        }
    }

    // ── rules with parts ──

    /// Prints the body of a declaration, on a line of its own if the source has it so.
    pub(super) fn body(&mut self, rule: &Rule) {
        let own_line = self.begins_line();
        self.indent(|it| {
            it.separate(LayoutBreak::line(own_line));
            it.rule(rule);
        });
    }

    /// Prints the closing keyword of a rule.
    fn end(&mut self, lines: bool) {
        self.separate(LayoutBreak::line(lines));
        self.token();
    }

    /// Prints `par … endpar` or `seq … endseq`.
    fn block(&mut self, rules: &[Rule], lines: bool) {
        self.token();
        self.indent(|block| {
            for (index, rule) in rules.iter().enumerate() {
                block.separate(match (lines, index) {
                    (true, 0) => LayoutBreak::Hard,
                    (true, _) => LayoutBreak::Item,
                    (false, 0) => LayoutBreak::Line,
                    (false, _) => LayoutBreak::Rule,
                });
                block.rule(rule);
            }
            block.comments_inside();
        });
        self.end(lines);
    }

    /// Prints `extend D with $x, $y do`.
    fn extend(&mut self, variables: &[NameText]) {
        self.token();
        for _ in 0..2 {
            self.separate(LayoutBreak::Blank);
            self.token();
        }
        self.indent(|list| {
            list.separate(LayoutBreak::Blank);
            list.items(variables, LayoutBreak::Fill, |list, _| list.token());
        });
        self.separate(LayoutBreak::Blank);
        self.token();
    }

    /// Prints `local f: D [R] S`.
    fn local(&mut self, functions: &[(Function, Rule)], body: &Rule, lines: bool) {
        for (function, init) in functions {
            self.group(|it| {
                it.function(function);
                it.separate(LayoutBreak::Blank);
                it.token();
                it.indent(|it| {
                    it.separate(LayoutBreak::Soft);
                    it.rule(init);
                    it.comments_inside();
                });
                it.separate(LayoutBreak::Soft);
                it.token();
            });
            self.separate(LayoutBreak::line(lines));
        }
        self.rule(body);
    }

    /// Prints the left-hand side of an update.
    pub(super) fn assignee(&mut self, target: &Assignee) {
        match target {
            Assignee::Variable(_) => self.token(),
            Assignee::Location {
                agent, arguments, ..
            } => self.applied(agent.is_some(), arguments),
        }
    }

    // ── shared by rules and terms ──

    /// Prints `if g then` or `while g do`. After a guard on several lines, the last keyword is on a
    /// line of its own.
    pub(super) fn guarded(&mut self, guard: &Term) {
        self.group(|it| {
            it.token();
            it.indent(|it| {
                it.separate(LayoutBreak::Blank);
                it.term(guard);
            });
            it.separate(LayoutBreak::Line);
            it.token();
        });
    }

    /// Prints `choose $x in D with g do`.
    fn choice(&mut self, binders: &[Binder], guard: Option<&Term>) {
        self.group(|it| {
            it.token();
            it.binders(binders, guard);
            it.separate(LayoutBreak::Line);
            it.token();
        });
    }

    /// Prints `let ($x = t, …) in`.
    pub(super) fn bindings(&mut self, bindings: &[(NameText, Term)]) {
        self.token();
        self.separate(LayoutBreak::Blank);
        self.list(bindings, LayoutBreak::Line, |list, (_, value)| {
            list.token();
            list.separate(LayoutBreak::Blank);
            list.token();
            list.value(value);
        });
        self.separate(LayoutBreak::Blank);
        self.token();
    }
}
