//! The parser of scenarios: commands are parsed here, their terms and rules by the grammar.
//!
//! ```text
//! scenario NAME
//! load PATH
//! ( invariant NAME : term ; )*
//! ( set location := term ;   | check term ;  | step  | step until term ;  | exec rule ;
//! | pick $x [in r_rule[(Domain, …)]] := term ;  | begin NAME … end  | execblock [scenario:]block ; )*
//! ```
//!
//! The name of a scenario, block or invariant is any run of printable characters without blanks, `:`
//! and `;`, such as `door-2.closed`. The keywords of commands are not reserved in AsmetaL: `set` may be a function in a term. The
//! text between a command and its `;` follows the syntax of AsmetaL.

mod command;
mod reader;

use crate::ast::{NameText, Scenario, ScenarioInvariant};
use crate::codes::v001::NoScenarioHeading;
use crate::codes::v002::NoLoadCommand;
use crate::codes::v004::IncompleteCommand;
use crate::codes::v008::DuplicateBlock;
use crate::findings::SyntaxFindings;
use crate::lexer::Lexer;

use asmotion_diagnostics::{FileId, Report, Span};
use reader::ScenarioReader;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Returns `true` if the first word of a text marks it as a scenario.
pub fn begins_scenario(text: &str) -> bool {
    let unheard = SyntaxFindings::new(FileId(0));
    let mut lexer = Lexer::new(text, &unheard);
    lexer.blanks_and_comments();
    lexer.rest().starts_with("scenario")
}

/// Parses a scenario; returns everything that could be parsed, with a report.
pub fn parse_scenario(file: FileId, text: &str) -> (Scenario, Report) {
    // these findings are dropped, because the parser of each part reports them again
    let unheard = SyntaxFindings::new(file);
    let mut reader = ScenarioReader {
        file,
        text,
        lexer: Lexer::new(text, &unheard),
        report: Report::new(),
    };
    let mut scenario = reader.scenario();
    scenario.split_qualified_blocks();
    reader.double_blocks(&scenario);
    (scenario, reader.report.finish())
}

impl ScenarioReader<'_, '_> {
    fn scenario(&mut self) -> Scenario {
        let mut scenario = Scenario::default();
        match self.accept_word("scenario") {
            Some(at) => {
                scenario.name = self.expected_label("scenario", "a name", "scenario name", at)
            }
            None => {
                self.error(NoScenarioHeading { at: self.here() });
                self.skip_command();
            }
        }
        match self.accept_word("load") {
            Some(at) => scenario.load = self.path(at),
            None => self.error(NoLoadCommand { at: self.here() }),
        }
        self.invariants(&mut scenario);
        scenario.commands = self.commands(&mut Vec::new());
        scenario
    }

    fn invariants(&mut self, scenario: &mut Scenario) {
        while let Some(at) = self.accept_word("invariant") {
            let name = self.expected_label("invariant", "a name", "invariant name : term;", at);
            self.accept_sign(":");
            let part = self.command_range(at);
            if let (Some(name), Some(condition)) = (name, self.term(part)) {
                scenario
                    .invariants
                    .push(ScenarioInvariant { name, condition });
            }
        }
    }

    fn double_blocks(&mut self, scenario: &Scenario) {
        let mut known: BTreeMap<&str, Span> = BTreeMap::new();
        for block in scenario.blocks() {
            let name = &block.name;
            if let Some(&first) = known.get(&*name.text) {
                self.error(DuplicateBlock {
                    name: name.text.to_string(),
                    at: name.span,
                    first,
                });
            }
            known.entry(&name.text).or_insert(name.span);
        }
    }

    /// Reads the path after `load`: in quotes, or up to the next blank.
    fn path(&mut self, at: Span) -> Option<NameText> {
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
            self.error(IncompleteCommand {
                command: "load",
                expected: "a path",
                form: "load specification.asm",
                at,
            });
            return None;
        }
        self.accept_sign(";");
        Some(NameText {
            text: Arc::from(&self.text[from..from + length]),
            span: self.span(from..from + length),
        })
    }
}
