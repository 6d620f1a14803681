//! Scenarios: commands read word by word, the terms and rules in them by the grammar.
//!
//! ```text
//! scenario NAME
//! load PATH
//! ( invariant NAME : term ; )*
//! ( set location := term ;   | check term ;  | step  | step until term ;  | exec rule ;
//! | pick $x [in r_rule[(Domain, …)]] := term ;  | begin NAME … end  | execblock [scenario:]block ; )*
//! ```
//!
//! The words of the commands are no reserved words of the language: `set` may be a function in a term.
//! What stands between a command and its `;` is the language's own.

mod error;

use crate::ast::{
    Block, Command, CommandKind, Name, Pick, PickedRule, Scenario, ScenarioInvariant,
};
use crate::findings::Findings;
use crate::fragment::{parse_assignment_in, parse_rule_in, parse_term_in};
use crate::lexer::{Lexer, word_length};
use crate::spelling::nearest;
use error::ScenarioError;
use source::{FileId, Report, Span};
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

/// The words that commands begin with.
const COMMANDS: &[&str] = &[
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

/// Blocks may nest this deep.
const MAX_DEPTH: usize = 64;

/// Reads a scenario: what could be read, and what was wrong.
pub fn parse_scenario(file: FileId, text: &str) -> (Scenario, Report) {
    // what the lexer says of a part is said again by the parser of that part
    let unheard = Findings::new(file);
    let mut reader = Reader {
        file,
        text,
        lexer: Lexer::new(text, &unheard),
        report: Report::new(),
    };
    let scenario = reader.scenario();
    reader.double_blocks(&scenario);
    (scenario, reader.report.finish())
}

struct Reader<'input, 'run> {
    file: FileId,
    text: &'input str,
    lexer: Lexer<'input, 'run>,
    report: Report,
}

impl<'input> Reader<'input, '_> {
    fn scenario(&mut self) -> Scenario {
        let mut scenario = Scenario::default();
        match self.takes("scenario") {
            Some(at) => scenario.name = self.wanted_name("scenario", "a name", "scenario name", at),
            None => {
                self.error(ScenarioError::NoHead { at: self.here() });
                self.skip_command();
            }
        }
        match self.takes("load") {
            Some(at) => scenario.load = self.path(at),
            None => self.error(ScenarioError::NoLoad { at: self.here() }),
        }
        self.invariants(&mut scenario);
        scenario.commands = self.commands(&mut Vec::new());
        scenario
    }

    fn invariants(&mut self, scenario: &mut Scenario) {
        while let Some(at) = self.takes("invariant") {
            let name = self.wanted_name("invariant", "a name", "invariant name : term;", at);
            self.takes_sign(":");
            let part = self.part(at);
            if let (Some(name), Some(condition)) = (name, self.term(part)) {
                scenario
                    .invariants
                    .push(ScenarioInvariant { name, condition });
            }
        }
    }

    /// The commands up to the end of the innermost open block, or of the text.
    fn commands(&mut self, open: &mut Vec<Name>) -> Vec<Command> {
        let mut commands = Vec::new();
        loop {
            self.lexer.blanks_and_comments();
            if self.lexer.rest().is_empty() {
                if let Some(name) = open.last() {
                    self.error(ScenarioError::OpenBlock {
                        name: name.text.to_string(),
                        at: name.span,
                    });
                }
                return commands;
            }
            if self.takes_sign(";") {
                continue;
            }
            let start = self.lexer.position();
            let at = self.here();
            let word = self.word();
            if word == "end" {
                if !open.is_empty() {
                    return commands;
                }
                self.error(ScenarioError::StrayEnd { at });
                continue;
            }
            if let Some(kind) = self.command(word, at, open) {
                let end = self.lexer.position();
                let span = self.span(start..start + self.text[start..end].trim_end().len());
                commands.push(Command { kind, span });
            }
        }
    }

    fn command(&mut self, word: &str, at: Span, open: &mut Vec<Name>) -> Option<CommandKind> {
        match word {
            "set" => {
                let part = self.part(at);
                let parsed = parse_assignment_in(self.file, self.text, part);
                let (target, value) = self.heard(parsed)?;
                Some(CommandKind::Set(target, value))
            }
            "check" => {
                let part = self.part(at);
                Some(CommandKind::Check(self.term(part)?))
            }
            "step" => match self.takes("until") {
                Some(until) => {
                    let part = self.part(until);
                    Some(CommandKind::StepUntil(self.term(part)?))
                }
                None => Some(CommandKind::Step),
            },
            "exec" => {
                let part = self.part(at);
                let parsed = parse_rule_in(self.file, self.text, part);
                Some(CommandKind::Exec(self.heard(parsed)?))
            }
            "pick" => Some(CommandKind::Pick(self.pick(at)?)),
            "begin" => Some(CommandKind::Block(self.block(at, open)?)),
            "execblock" => self.exec_block(at),
            "invariant" | "scenario" | "load" => {
                let word = COMMANDS.iter().find(|known| **known == word)?;
                self.part(at);
                self.error(ScenarioError::Late { word, at });
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
            self.error(ScenarioError::NoCommand { at });
        } else {
            let similar = nearest(word, COMMANDS.iter().copied());
            self.error(ScenarioError::UnknownCommand {
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
        let rule = match self.takes("in") {
            Some(at) => Some(self.picked_rule(at)?),
            None => None,
        };
        if !self.takes_sign(":=") {
            self.incomplete("pick", "`:=` and a value", FORM, variable.span);
            return None;
        }
        let part = self.part(at);
        Some(Pick {
            variable,
            rule,
            value: self.term(part)?,
        })
    }

    fn picked_rule(&mut self, at: Span) -> Option<PickedRule> {
        let form = "pick $x in r_rule := term;";
        let name = self.wanted_name("pick", "a rule", form, at)?;
        let parameters = self.takes_sign("(").then(|| self.domains());
        Some(PickedRule { name, parameters })
    }

    /// The domains in brackets that tell a rule from others of its name, the closing one included.
    fn domains(&mut self) -> Vec<Name> {
        let mut domains = Vec::new();
        let (mut depth, mut start) = (1, self.lexer.position());
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
            if ends {
                let (text, span) = self.trimmed(start..self.lexer.position());
                domains.extend((!text.is_empty()).then(|| Name {
                    text: Arc::from(text),
                    span,
                }));
            }
            self.lexer.pass();
            if ends {
                start = self.lexer.position();
            }
            if depth == 0 {
                return domains;
            }
        }
    }

    fn block(&mut self, at: Span, open: &mut Vec<Name>) -> Option<Block> {
        let name = self.wanted_name("begin", "a name", "begin name … end", at)?;
        if open.len() >= MAX_DEPTH {
            self.error(ScenarioError::TooDeep { at });
            return None;
        }
        open.push(name.clone());
        let commands = self.commands(open);
        open.pop();
        Some(Block { name, commands })
    }

    /// `scenario:block` or, as of old, `scenario.block`.
    fn exec_block(&mut self, at: Span) -> Option<CommandKind> {
        const FORM: &str = "execblock block;";
        let first = self.wanted_name("execblock", "a block", FORM, at)?;
        let second = if self.takes_sign(":") || self.takes_sign(".") {
            Some(self.wanted_name("execblock", "a block", FORM, first.span)?)
        } else {
            None
        };
        self.part(at);
        Some(match second {
            Some(block) => CommandKind::ExecBlock {
                scenario: Some(first),
                block,
            },
            None => CommandKind::ExecBlock {
                scenario: None,
                block: first,
            },
        })
    }

    fn double_blocks(&mut self, scenario: &Scenario) {
        let mut known: BTreeMap<&str, Span> = BTreeMap::new();
        for block in scenario.blocks() {
            let name = &block.name;
            if let Some(&first) = known.get(&*name.text) {
                self.error(ScenarioError::DoubleBlock {
                    name: name.text.to_string(),
                    at: name.span,
                    first,
                });
            }
            known.entry(&name.text).or_insert(name.span);
        }
    }

    // ── parts of commands ──

    /// What stands up to the `;`, which is taken too. Where it is missing, the command ends before
    /// the line that begins with the next one.
    fn part(&mut self, command: Span) -> Range<usize> {
        self.lexer.blanks_and_comments();
        let start = self.lexer.position();
        let mut end = start;
        loop {
            self.lexer.blanks_and_comments();
            let rest = self.lexer.rest();
            if rest.starts_with(';') {
                self.lexer.pass();
                return start..end;
            }
            if rest.is_empty() || (end > start && self.begins_command()) {
                let at = self.here();
                self.error(ScenarioError::Unended { command, end: at });
                return start..end;
            }
            self.lexer.pass();
            end = self.lexer.position();
        }
    }

    /// Goes on behind the next `;`, or before the line that begins with a command.
    fn skip_command(&mut self) {
        loop {
            self.lexer.blanks_and_comments();
            if self.begins_command() || !self.lexer.pass() {
                return;
            }
            if self.text[..self.lexer.position()].ends_with(';') {
                return;
            }
        }
    }

    /// Whether a command stands here, the first of its line: its word alone, and no location.
    fn begins_command(&self) -> bool {
        let before = self.text[..self.lexer.position()].trim_end_matches([' ', '\t']);
        let rest = self.lexer.rest();
        let word = rest.get(..word_length(rest)).unwrap_or("");
        let after = rest.get(word.len()..).unwrap_or("").trim_start();
        (before.is_empty() || before.ends_with(['\n', '\r']))
            && COMMANDS.contains(&word)
            && (after.starts_with("//") || !after.starts_with(|c| "(:=<>+-*/.,".contains(c)))
    }

    fn term(&mut self, part: Range<usize>) -> Option<crate::ast::Term> {
        let parsed = parse_term_in(self.file, self.text, part);
        self.heard(parsed)
    }

    fn heard<T>(&mut self, parsed: Result<T, Report>) -> Option<T> {
        match parsed {
            Ok(part) => Some(part),
            Err(report) => {
                self.report.extend(report);
                None
            }
        }
    }

    // ── words ──

    /// Takes the word that stands here.
    fn word(&mut self) -> &'input str {
        let rest = self.lexer.rest();
        let word = rest.get(..word_length(rest)).unwrap_or("");
        self.lexer.start_at(self.lexer.position() + word.len());
        word
    }

    /// Takes this word, if it stands here.
    fn takes(&mut self, wanted: &str) -> Option<Span> {
        self.lexer.blanks_and_comments();
        let rest = self.lexer.rest();
        let start = self.lexer.position();
        (rest.get(..word_length(rest)) == Some(wanted)).then(|| {
            self.word();
            self.span(start..start + wanted.len())
        })
    }

    fn takes_sign(&mut self, wanted: &str) -> bool {
        self.lexer.blanks_and_comments();
        let is_here = self.lexer.rest().starts_with(wanted);
        if is_here {
            self.lexer.start_at(self.lexer.position() + wanted.len());
        }
        is_here
    }

    fn name(&mut self) -> Option<Name> {
        self.lexer.blanks_and_comments();
        let start = self.lexer.position();
        let text = self.word();
        (!text.is_empty()).then(|| Name {
            text: Arc::from(text),
            span: self.span(start..start + text.len()),
        })
    }

    fn variable(&mut self) -> Option<Name> {
        self.lexer.blanks_and_comments();
        let start = self.lexer.position();
        if !self.takes_sign("$") {
            return None;
        }
        let name = self.name()?;
        Some(Name {
            text: Arc::from(format!("${}", name.text)),
            span: self.span(start..start).to(name.span),
        })
    }

    fn wanted_name(
        &mut self,
        command: &'static str,
        wanted: &'static str,
        form: &'static str,
        at: Span,
    ) -> Option<Name> {
        let name = self.name();
        if name.is_none() {
            self.incomplete(command, wanted, form, at);
        }
        name
    }

    fn incomplete(
        &mut self,
        command: &'static str,
        wanted: &'static str,
        form: &'static str,
        at: Span,
    ) {
        self.error(ScenarioError::Incomplete {
            command,
            wanted,
            form,
            at,
        });
        self.skip_command();
    }

    /// The path after `load`: in quotes, or up to the next blank.
    fn path(&mut self, at: Span) -> Option<Name> {
        self.lexer.blanks_and_comments();
        let rest = self.lexer.rest();
        let start = self.lexer.position();
        let (from, length, taken) = match rest.strip_prefix('"') {
            Some(quoted) => {
                let length = quoted.find(['"', '\n', '\r']).unwrap_or(quoted.len());
                (start + 1, length, length + 2)
            }
            None => {
                let length = rest
                    .find(|c: char| c.is_whitespace() || c == ';')
                    .unwrap_or(rest.len());
                (start, length, length)
            }
        };
        self.lexer.start_at((start + taken).min(self.text.len()));
        if length == 0 {
            self.error(ScenarioError::Incomplete {
                command: "load",
                wanted: "a path",
                form: "load specification.asm",
                at,
            });
            return None;
        }
        self.takes_sign(";");
        Some(Name {
            text: Arc::from(&self.text[from..from + length]),
            span: self.span(from..from + length),
        })
    }

    // ── places ──

    fn span(&self, range: Range<usize>) -> Span {
        Span::new(self.file, range.start, range.end.min(self.text.len()))
    }

    /// The next character that is no blank.
    fn here(&self) -> Span {
        let start = self.lexer.position();
        let rest = self.lexer.rest();
        let length = match word_length(rest) {
            0 => rest.chars().next().map_or(0, char::len_utf8),
            length => length,
        };
        self.span(start..start + length)
    }

    fn trimmed(&self, range: Range<usize>) -> (&'input str, Span) {
        let text = &self.text[range.clone()];
        let start = range.start + (text.len() - text.trim_start().len());
        (text.trim(), self.span(start..start + text.trim().len()))
    }

    fn error(&mut self, error: ScenarioError) {
        self.report.push(error.diagnostic());
    }
}
