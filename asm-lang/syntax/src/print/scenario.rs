//! Layout of scenarios: one line for each command.

use super::layout::{LayoutBreak, TokenLayout};
use crate::ast::*;
use crate::codes::v005::UnendedCommand;
use crate::findings::SyntaxFindings;
use crate::lexer::{Lexer, Sign, SpannedToken, Token};
use crate::scenario::parse_scenario;
use asmotion_diagnostics::{Diagnostic, FileId, Span};
use std::collections::{BTreeMap, BTreeSet};

/// The sign `;` that ends a command, which is not a sign of AsmetaL.
const END: Token<'_> = Token::Word(";");

impl TokenLayout<'_> {
    /// Prints the whole scenario.
    pub(super) fn scenario(&mut self, scenario: &Scenario) {
        for _ in [&scenario.name, &scenario.load].into_iter().flatten() {
            self.separate(LayoutBreak::Item);
            self.token();
            self.separate(LayoutBreak::Blank);
            self.token();
            self.no_end();
        }
        for invariant in &scenario.invariants {
            self.separate(LayoutBreak::Item);
            self.group(|it| {
                it.token();
                it.separate(LayoutBreak::Blank);
                it.joined(2);
                it.rest_of_line(&invariant.condition);
                it.token();
                it.no_end();
            });
        }
        for command in &scenario.commands {
            self.separate(LayoutBreak::Item);
            self.command(command);
        }
    }

    fn command(&mut self, command: &ScenarioCommand) {
        self.group(|it| {
            it.token();
            match &command.kind {
                ScenarioCommandKind::Step => {}
                ScenarioCommandKind::Set(target, value) => {
                    it.separate(LayoutBreak::Blank);
                    it.assignee(target);
                    it.separate(LayoutBreak::Blank);
                    it.token();
                    it.value(value);
                }
                ScenarioCommandKind::Check(condition) => it.rest_of_line(condition),
                ScenarioCommandKind::StepUntil(condition) => {
                    it.separate(LayoutBreak::Blank);
                    it.token();
                    it.rest_of_line(condition);
                }
                ScenarioCommandKind::Exec(rule) => it.body(rule),
                ScenarioCommandKind::Pick(pick) => it.pick(pick),
                ScenarioCommandKind::Block(block) => it.named_block(block),
                ScenarioCommandKind::ExecBlock { scenario, .. } => {
                    it.separate(LayoutBreak::Blank);
                    it.joined(if scenario.is_some() { 3 } else { 1 });
                }
            }
            match &command.kind {
                ScenarioCommandKind::Step | ScenarioCommandKind::Block(_) => {}
                ScenarioCommandKind::Set(..)
                | ScenarioCommandKind::Check(_)
                | ScenarioCommandKind::StepUntil(_)
                | ScenarioCommandKind::Exec(_)
                | ScenarioCommandKind::Pick(_)
                | ScenarioCommandKind::ExecBlock { .. } => it.token(),
            }
            it.no_end();
        });
    }

    /// Prints a condition after its command, on the following lines if it does not fit.
    fn rest_of_line(&mut self, condition: &Term) {
        self.indent(|it| {
            it.separate(LayoutBreak::Blank);
            it.term(condition);
        });
    }

    /// Prints `pick $x in r_rule(Domain, …) := term` after its keyword.
    fn pick(&mut self, pick: &Pick) {
        self.separate(LayoutBreak::Blank);
        self.token();
        if pick.rule.is_some() {
            self.separate(LayoutBreak::Blank);
            self.token();
            self.separate(LayoutBreak::Blank);
        }
        while self.peek().is_some() && !self.at(Sign::Assign) {
            let is_comma = self.at(Sign::Comma);
            self.token();
            if is_comma {
                self.separate(LayoutBreak::Blank);
            }
        }
        self.separate(LayoutBreak::Blank);
        self.token();
        self.value(&pick.value);
    }

    /// Prints `begin name … end` after its keyword.
    fn named_block(&mut self, block: &ScenarioBlock) {
        self.separate(LayoutBreak::Blank);
        self.token();
        self.no_end();
        self.indent(|all| {
            let mut begin = LayoutBreak::Hard;
            for command in &block.commands {
                all.separate(begin);
                all.command(command);
                begin = LayoutBreak::Item;
            }
            all.comments_inside();
        });
        self.separate(LayoutBreak::Hard);
        self.token();
    }

    /// Omits `;` that end no command.
    fn no_end(&mut self) {
        while self.peek() == Some(END) {
            self.leave_out();
        }
    }
}

/// Adds missing `;` at the ends of commands.
pub(super) fn with_ends(file: FileId, text: &str) -> String {
    let (_, report) = parse_scenario(file, text);
    let missing = report.diagnostics.iter();
    let missing: Vec<Diagnostic> = missing
        .filter(|finding| finding.is_any(&[UnendedCommand::CODE]))
        .cloned()
        .collect();
    asmotion_diagnostics::apply(text, file, &missing).text
}

/// Returns the tokens of a scenario. Names and paths are single tokens, even if AsmetaL would split
/// them. The lexer starts afresh at each term.
pub(super) fn tokens<'text>(text: &'text str, scenario: &Scenario) -> Vec<SpannedToken<'text>> {
    let unheard = SyntaxFindings::new(FileId(0));
    let mut places = ScenarioPositions::default();
    places.scenario(scenario, text);
    let mut lexer = Lexer::new(text, &unheard);
    let mut tokens = Vec::new();
    loop {
        lexer.blanks_and_comments();
        let start = lexer.position();
        if places.begins.contains(&start) {
            lexer = Lexer::new(text, &unheard);
            lexer.start_at(start);
        }
        let whole = match places.whole.get(&start) {
            Some(&end) => end,
            None if lexer.rest().starts_with(';') => start + 1,
            None => match lexer.next() {
                Some(token) => {
                    tokens.push(token);
                    continue;
                }
                None => return tokens,
            },
        };
        let word = text.get(start..whole).unwrap_or("");
        tokens.push((start, Token::Word(word), whole));
        lexer.start_at(whole);
    }
}

/// Positions at which the tokens of a scenario differ from those of AsmetaL.
#[derive(Default)]
struct ScenarioPositions {
    /// Start and end offsets of names and paths.
    whole: BTreeMap<usize, usize>,
    /// Start offsets of terms and rules.
    begins: BTreeSet<usize>,
}

impl ScenarioPositions {
    fn scenario(&mut self, scenario: &Scenario, text: &str) {
        self.whole(scenario.name.iter().map(|name| name.span));
        let paths = scenario.load.iter().map(|path| path.span.range());
        let is_quoted = |start: usize| text.get(..start).is_some_and(|text| text.ends_with('"'));
        self.whole.extend(paths.map(|path| {
            if is_quoted(path.start) {
                (path.start - 1, path.end + 1)
            } else {
                (path.start, path.end)
            }
        }));
        for invariant in &scenario.invariants {
            self.whole([invariant.name.span]);
            self.begins(invariant.condition.span);
        }
        scenario
            .commands
            .iter()
            .for_each(|command| self.command(command));
    }

    fn command(&mut self, command: &ScenarioCommand) {
        match &command.kind {
            ScenarioCommandKind::Step => {}
            ScenarioCommandKind::Set(target, value) => {
                match target {
                    Assignee::Variable(name) => self.begins(name.span),
                    Assignee::Location { span, .. } => self.begins(*span),
                }
                self.begins(value.span);
            }
            ScenarioCommandKind::Check(condition) | ScenarioCommandKind::StepUntil(condition) => {
                self.begins(condition.span);
            }
            ScenarioCommandKind::Exec(rule) => self.begins(rule.span),
            ScenarioCommandKind::Pick(pick) => {
                if let Some(rule) = &pick.rule {
                    self.whole([rule.name.span]);
                }
                self.begins(pick.value.span);
            }
            ScenarioCommandKind::Block(block) => {
                self.whole([block.name.span]);
                block
                    .commands
                    .iter()
                    .for_each(|command| self.command(command));
            }
            ScenarioCommandKind::ExecBlock { scenario, block } => {
                self.whole(scenario.iter().chain([block]).map(|name| name.span));
            }
        }
    }

    fn whole(&mut self, spans: impl IntoIterator<Item = Span>) {
        let ranges = spans.into_iter().map(Span::range);
        self.whole
            .extend(ranges.map(|range| (range.start, range.end)));
    }

    fn begins(&mut self, span: Span) {
        self.begins.insert(span.range().start);
    }
}
