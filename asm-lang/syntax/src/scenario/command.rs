//! Parsing of commands up to their `;`.

use super::reader::ScenarioReader;
use crate::ast::{NameText, Pick, PickedRule, ScenarioBlock, ScenarioCommand, ScenarioCommandKind};
use crate::codes::v003::UnknownCommand;
use crate::codes::v006::OpenBlock;
use crate::codes::v007::StrayBlockEnd;
use crate::codes::v009::LateHeading;
use crate::codes::v010::BlocksNestTooDeep;
use crate::fragment::{parse_assignment_in, parse_rule_in};
use crate::spelling::nearest;
use asmotion_diagnostics::Span;

/// The keywords with which commands begin.
pub(super) const COMMANDS: &[&str] = &[
    "set",
    "check",
    "step",
    "exec",
    "pick",
    "begin",
    "end",
    "execblock",
    "invariant",
    "scenario",
    "load",
];

/// Limit for the nesting of blocks.
const MAX_DEPTH: usize = 64;

impl ScenarioReader<'_, '_> {
    /// Parses commands up to the end of the innermost open block, or of the text.
    pub(super) fn commands(&mut self, open: &mut Vec<NameText>) -> Vec<ScenarioCommand> {
        let mut commands = Vec::new();
        loop {
            self.lexer.blanks_and_comments();
            if self.lexer.rest().is_empty() {
                if let Some(name) = open.last() {
                    self.error(OpenBlock {
                        name: name.text.to_string(),
                        at: name.span,
                    });
                }
                return commands;
            }
            if self.accept_sign(";") {
                continue;
            }
            let start = self.lexer.position();
            let at = self.here();
            let word = self.word();
            if word == "end" {
                if !open.is_empty() {
                    return commands;
                }
                self.error(StrayBlockEnd { at });
                continue;
            }
            if let Some(kind) = self.command(word, at, open) {
                let end = self.lexer.position();
                let span = self.span(start..start + self.text[start..end].trim_end().len());
                commands.push(ScenarioCommand { kind, span });
            }
        }
    }

    fn command(
        &mut self,
        word: &str,
        at: Span,
        open: &mut Vec<NameText>,
    ) -> Option<ScenarioCommandKind> {
        match word {
            "set" => {
                let part = self.command_range(at);
                let parsed = parse_assignment_in(self.file, self.text, part);
                let (target, value) = self.collect_errors(parsed)?;
                Some(ScenarioCommandKind::Set(target, value))
            }
            "check" => {
                let part = self.command_range(at);
                Some(ScenarioCommandKind::Check(self.term(part)?))
            }
            "step" => match self.accept_word("until") {
                Some(until) => {
                    let part = self.command_range(until);
                    Some(ScenarioCommandKind::StepUntil(self.term(part)?))
                }
                None => Some(ScenarioCommandKind::Step),
            },
            "exec" => {
                let part = self.command_range(at);
                let parsed = parse_rule_in(self.file, self.text, part);
                Some(ScenarioCommandKind::Exec(self.collect_errors(parsed)?))
            }
            "pick" => Some(ScenarioCommandKind::Pick(self.pick(at)?)),
            "begin" => Some(ScenarioCommandKind::Block(self.block(at, open)?)),
            "execblock" => self.exec_block(at),
            "invariant" | "scenario" | "load" => {
                let word = COMMANDS.iter().find(|known| **known == word)?;
                self.command_range(at);
                self.error(LateHeading { word, at });
                None
            }
            _ => {
                self.unknown(word, at);
                None
            }
        }
    }

    fn unknown(&mut self, word: &str, at: Span) {
        if word.is_empty() {
            self.error(UnknownCommand::Missing { at });
        } else {
            let similar = nearest(word, COMMANDS.iter().copied());
            self.error(UnknownCommand::Misspelt {
                word: word.to_owned(),
                at,
                similar,
            });
        }
        self.skip_command();
    }

    fn pick(&mut self, at: Span) -> Option<Pick> {
        const FORM: &str = "pick $x := term;";
        let variable = self.variable();
        let Some(variable) = variable else {
            self.incomplete("pick", "a variable", FORM, at);
            return None;
        };
        let rule = match self.accept_word("in") {
            Some(at) => Some(self.picked_rule(at)?),
            None => None,
        };
        if !self.accept_sign(":=") {
            self.incomplete("pick", "`:=` and a value", FORM, variable.span);
            return None;
        }
        let part = self.command_range(at);
        Some(Pick {
            variable,
            rule,
            value: self.term(part)?,
        })
    }

    fn picked_rule(&mut self, at: Span) -> Option<PickedRule> {
        let form = "pick $x in r_rule := term;";
        let Some(name) = self.name() else {
            self.incomplete("pick", "a rule", form, at);
            return None;
        };
        let parameters = self.accept_sign("(").then(|| self.domains());
        Some(PickedRule { name, parameters })
    }

    /// Parses the domains of a rule's parameters, including the closing bracket.
    fn domains(&mut self) -> Vec<NameText> {
        let mut domains = Vec::new();
        let mut depth = 1;
        let mut domain: Option<(String, Span)> = None;
        loop {
            self.lexer.blanks_and_comments();
            let sign = self.lexer.rest().chars().next();
            let ends = match sign {
                Some('(') => {
                    depth += 1;
                    false
                }
                Some(')') => {
                    depth -= 1;
                    depth == 0
                }
                Some(',') => depth == 1,
                None | Some(';') => return domains,
                Some(_) => false,
            };
            let start = self.lexer.position();
            self.lexer.pass();
            let token = self.span(start..self.lexer.position());
            if ends {
                domains.extend(domain.take().map(|(text, span)| NameText {
                    text: text.into(),
                    span,
                }));
            } else {
                let (text, span) = domain.get_or_insert((String::new(), token));
                text.push_str(&self.text[token.range()]);
                text.push_str(if sign == Some(',') { " " } else { "" });
                *span = span.to(token);
            }
            if depth == 0 {
                return domains;
            }
        }
    }

    fn block(&mut self, at: Span, open: &mut Vec<NameText>) -> Option<ScenarioBlock> {
        let name = self.expected_label("begin", "a name", "begin name … end", at)?;
        if open.len() >= MAX_DEPTH {
            self.error(BlocksNestTooDeep { at });
            self.skip_block();
            return None;
        }
        open.push(name.clone());
        let commands = self.commands(open);
        open.pop();
        Some(ScenarioBlock { name, commands })
    }

    /// Skips to the `end` of the block that has just begun.
    fn skip_block(&mut self) {
        let mut open = 1;
        while open > 0 {
            self.lexer.blanks_and_comments();
            match self.word() {
                "begin" => {
                    self.label();
                    open += 1;
                }
                "end" => open -= 1,
                "" if !self.lexer.pass() => return,
                _ => {}
            }
        }
    }

    /// Parses `scenario:block`. In the old notation, `scenario.block`, the text without blanks is a
    /// single name here; [`Scenario::split_qualified_blocks`](crate::ast::Scenario) divides it.
    fn exec_block(&mut self, at: Span) -> Option<ScenarioCommandKind> {
        const FORM: &str = "execblock block;";
        let first = self.expected_label("execblock", "a block", FORM, at)?;
        let second = if self.accept_sign(":") || self.accept_sign(".") {
            Some(self.expected_label("execblock", "a block", FORM, first.span)?)
        } else {
            None
        };
        let last = second.as_ref().unwrap_or(&first).span;
        self.part_behind(last.range().end, at);
        Some(match second {
            Some(block) => ScenarioCommandKind::ExecBlock {
                scenario: Some(first),
                block,
            },
            None => ScenarioCommandKind::ExecBlock {
                scenario: None,
                block: first,
            },
        })
    }
}
