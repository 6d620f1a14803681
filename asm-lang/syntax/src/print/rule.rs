//! Rules. A rule the text has on one line stays there if it fits; every other one is spread out.

use super::layout::{Break, Layout};
use crate::ast::*;
use crate::lexer::{Keyword, Sign, Token};
use source::Span;

impl Layout<'_> {
    /// A rule.
    pub(super) fn rule(&mut self, rule: &Rule) {
        let lines = self.in_lines(rule.span);
        self.group(|it| it.rule_kind(&rule.kind, lines));
    }

    fn rule_kind(&mut self, kind: &RuleKind, lines: bool) {
        match kind {
            RuleKind::Skip | RuleKind::Invalid => self.token(),
            RuleKind::Update { target, value } => {
                self.assignee(target);
                self.separate(Break::Blank);
                self.token();
                self.value(value);
            }
            RuleKind::Assign {
                target, arguments, ..
            } => {
                self.assignee(target);
                self.separate(Break::Blank);
                self.token();
                self.separate(Break::Blank);
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
            } => self.if_rule(guard, then, otherwise.as_ref(), lines),
            RuleKind::Switch(switch) => self.switch_rule(switch, lines),
            RuleKind::Choose {
                binders,
                guard,
                body,
                ifnone,
            } => {
                self.choice(binders, guard.as_ref());
                self.inside(body, lines);
                if let Some(ifnone) = ifnone {
                    self.separate(Break::line(lines));
                    self.token();
                    self.inside(ifnone, lines);
                }
            }
            RuleKind::Forall {
                binders,
                guard,
                body,
            } => {
                self.choice(binders, guard.as_ref());
                self.inside(body, lines);
            }
            RuleKind::Let { bindings, body } => {
                self.bindings(bindings);
                self.inside(body, lines);
                self.end(lines);
            }
            RuleKind::Extend {
                variables, body, ..
            } => {
                self.extend(variables);
                self.inside(body, lines);
            }
            RuleKind::While { guard, body } | RuleKind::WhileRec { guard, body } => {
                self.guarded(guard);
                self.inside(body, lines);
            }
            RuleKind::Iterate(body) => {
                self.token();
                self.inside(body, lines);
                self.end(lines);
            }
            RuleKind::Local { functions, body } => self.local(functions, body, lines),
        }
    }

    // ── rules with parts ──

    /// The rule a declaration stands for; on a line of its own where the text has it so.
    pub(super) fn body(&mut self, rule: &Rule) {
        let own_line = self.begins_line();
        self.indent(|it| {
            it.separate(Break::line(own_line));
            it.rule(rule);
        });
    }

    /// A rule between words.
    fn inside(&mut self, rule: &Rule, lines: bool) {
        self.indent(|it| {
            it.separate(Break::line(lines));
            it.rule(rule);
            it.comments_inside();
        });
    }

    /// The word that ends a rule.
    fn end(&mut self, lines: bool) {
        self.separate(Break::line(lines));
        self.token();
    }

    /// `par … endpar`, `seq … endseq`.
    fn block(&mut self, rules: &[Rule], lines: bool) {
        self.token();
        self.indent(|block| {
            for (index, rule) in rules.iter().enumerate() {
                block.separate(match (lines, index) {
                    (true, 0) => Break::Hard,
                    (true, _) => Break::Item,
                    (false, 0) => Break::Line,
                    (false, _) => Break::Rule,
                });
                block.rule(rule);
            }
            block.comments_inside();
        });
        self.end(lines);
    }

    /// `if … endif`; an `else if` in one line goes on in the same indentation.
    fn if_rule(&mut self, guard: &Term, then: &Rule, otherwise: Option<&Rule>, lines: bool) {
        self.guarded(guard);
        self.inside(then, lines);
        let mut chained = false;
        if let Some(otherwise) = otherwise {
            self.separate(Break::line(lines));
            chained = self.else_if();
            self.token();
            if let RuleKind::If {
                guard,
                then,
                otherwise,
            } = &*otherwise.kind
                && chained
            {
                self.separate(Break::Blank);
                self.if_rule(guard, then, otherwise.as_ref(), lines);
            } else {
                self.inside(otherwise, lines);
            }
        }
        self.separate(if chained {
            Break::Blank
        } else {
            Break::line(lines)
        });
        self.token();
    }

    /// Whether `else if` comes next, in one line.
    pub(super) fn else_if(&self) -> bool {
        self.peek_second() == Some(Token::Keyword(Keyword::If)) && self.goes_on()
    }

    fn switch_rule(&mut self, switch: &SwitchRule, lines: bool) {
        self.subject(&switch.subject);
        self.indent(|cases| {
            for (case, body) in &switch.cases {
                cases.separate(if lines { Break::Item } else { Break::Line });
                let apart = cases.in_lines(case.span.to(body.span));
                cases.case(case, apart, |it| it.rule(body));
            }
            if let Some(otherwise) = &switch.otherwise {
                cases.separate(if lines { Break::Item } else { Break::Line });
                cases.otherwise(otherwise.span, |it| it.rule(otherwise));
            }
        });
        self.end(lines);
    }

    /// `extend D with $x, $y do`.
    fn extend(&mut self, variables: &[Name]) {
        self.token();
        for _ in 0..2 {
            self.separate(Break::Blank);
            self.token();
        }
        self.indent(|list| {
            list.separate(Break::Blank);
            list.items(variables, Break::Fill, |list, _| list.token());
        });
        self.separate(Break::Blank);
        self.token();
    }

    /// `local f: D [R] S`.
    fn local(&mut self, functions: &[(Function, Rule)], body: &Rule, lines: bool) {
        for (function, init) in functions {
            self.group(|it| {
                it.function(function);
                it.separate(Break::Blank);
                it.token();
                it.indent(|it| {
                    it.separate(Break::Soft);
                    it.rule(init);
                    it.comments_inside();
                });
                it.separate(Break::Soft);
                it.token();
            });
            self.separate(Break::line(lines));
        }
        self.rule(body);
    }

    /// What is written.
    fn assignee(&mut self, target: &Assignee) {
        match target {
            Assignee::Variable(_) => self.token(),
            Assignee::Location {
                agent, arguments, ..
            } => self.applied(agent.is_some(), arguments),
        }
    }

    // ── what rules and terms share ──

    /// `if g then`, `while g do`: the last word on a line of its own after a guard of several lines.
    pub(super) fn guarded(&mut self, guard: &Term) {
        self.group(|it| {
            it.token();
            it.indent(|it| {
                it.separate(Break::Blank);
                it.term(guard);
            });
            it.separate(Break::Line);
            it.token();
        });
    }

    /// `choose $x in D with g do`.
    fn choice(&mut self, binders: &[Binder], guard: Option<&Term>) {
        self.group(|it| {
            it.token();
            it.binders(binders, guard);
            it.separate(Break::Line);
            it.token();
        });
    }

    /// `switch t`.
    pub(super) fn subject(&mut self, subject: &Term) {
        self.token();
        self.indent(|it| {
            it.separate(Break::Blank);
            it.term(subject);
        });
    }

    /// `case c: R`.
    pub(super) fn case(&mut self, case: &Term, apart: bool, body: impl FnOnce(&mut Self)) {
        self.group(|it| {
            it.token();
            it.indent(|it| {
                it.separate(Break::Blank);
                it.term(case);
                it.token();
                it.separate(Break::line(apart));
                body(it);
                it.comments_inside();
            });
        });
    }

    /// `otherwise R`.
    pub(super) fn otherwise(&mut self, place: Span, body: impl FnOnce(&mut Self)) {
        let apart = self.in_lines(Span {
            start: u32::try_from(self.start()).unwrap_or(place.start),
            ..place
        });
        self.group(|it| {
            it.token();
            it.indent(|it| {
                it.separate(Break::line(apart));
                body(it);
                it.comments_inside();
            });
        });
    }

    /// `let ($x = t, …) in`.
    pub(super) fn bindings(&mut self, bindings: &[(Name, Term)]) {
        self.token();
        self.separate(Break::Blank);
        self.list(bindings, Break::Line, |list, (_, value)| {
            list.token();
            list.separate(Break::Blank);
            list.token();
            list.value(value);
        });
        self.separate(Break::Blank);
        self.token();
    }
}
