//! Coverage: a table of rules, sources with counts in the margin, and LCOV.

use crate::terminal::{BAD, FAINT, GOOD, NAME, TerminalOutput};
use asmotion_lang::coverage::{Coverage, FileCoverage, RuleCoverage};
use asmotion_lang::ir::CoveragePoint;
use clap::ValueEnum;
use std::collections::BTreeMap;
use std::fmt::Write;

/// Detail of the coverage report.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum CoverageFormat {
    /// A table with a line for each rule
    Table,
    /// Also the sources with counts in the margin
    Lines,
}

/// Prints the coverage.
pub fn print(coverage: &Coverage, format: CoverageFormat, terminal: &mut TerminalOutput) {
    for (path, file) in &coverage.files {
        terminal.result(format_args!("\n{NAME}{path}{NAME:#}"));
        table(file, terminal);
        if format == CoverageFormat::Lines {
            terminal.result("");
            lines(file, terminal);
        }
    }
}

fn table(file: &FileCoverage, terminal: &mut TerminalOutput) {
    let widest = file.rules.values().map(|rule| rule.name.len()).max();
    let width = widest.unwrap_or(0).max("rule".len());
    terminal.result(format_args!(
        "  {FAINT}{:width$}  {:>7}  {:>9}  {:>9}  {:>14}{FAINT:#}",
        "rule", "calls", "branches", "updates", "forall 0/1/many"
    ));
    for rule in file.rules.values() {
        let colour = if is_covered(rule) { GOOD } else { BAD };
        terminal.result(format_args!(
            "  {colour}{:width$}{colour:#}  {:>7}  {:>9}  {:>9}  {:>14}",
            rule.name,
            rule.calls,
            share(rule.branches()),
            share(rule.updates()),
            rounds(rule),
        ));
    }
}

/// Returns `true` if every part of the rule ran.
fn is_covered(rule: &RuleCoverage) -> bool {
    let all = |(ran, all): (usize, usize)| ran == all;
    rule.calls > 0 && all(rule.branches()) && all(rule.updates())
}

fn share((run, all): (usize, usize)) -> String {
    match all {
        0 => "-".to_owned(),
        all => format!("{run}/{all}"),
    }
}

fn rounds(rule: &RuleCoverage) -> String {
    let ([none, one, many], all) = rule.rounds();
    match all {
        0 => "-".to_owned(),
        all => format!("{none} {one} {many} of {all}"),
    }
}

/// Prints the source lines with counts of the constructs that begin on them: a number for rules and updates, `T`
/// and `F` for the branches of `if`, `0`, `1` and `*` for the rounds of `forall`; `!` marks constructs that did
/// not run.
fn lines(file: &FileCoverage, terminal: &mut TerminalOutput) {
    let margins = margins(file);
    for (index, text) in file.text.lines().enumerate() {
        let (margin, is_missed) = margins.get(&(index + 1)).cloned().unwrap_or_default();
        let colour = if is_missed { BAD } else { FAINT };
        let mark = if is_missed { '!' } else { ' ' };
        terminal.result(format_args!(
            "{FAINT}{:>5}{FAINT:#} {colour}{mark}{margin:>14}{colour:#} {FAINT}|{FAINT:#} {text}",
            index + 1
        ));
    }
}

/// For each line: the text in the margin, and whether a construct did not run.
fn margins(file: &FileCoverage) -> BTreeMap<usize, (String, bool)> {
    let mut margins: BTreeMap<usize, (String, bool)> = BTreeMap::new();
    let mut note = |line: usize, text: String, is_missed: bool| {
        let margin = margins.entry(line).or_default();
        if !margin.0.is_empty() {
            margin.0.push(' ');
        }
        margin.0.push_str(&text);
        margin.1 |= is_missed;
    };
    for rule in file.rules.values() {
        note(rule.line, rule.calls.to_string(), rule.calls == 0);
        for ((_, part), covered) in &rule.parts {
            let count = covered.count;
            let text = match part {
                CoveragePoint::Rule | CoveragePoint::Round => continue,
                CoveragePoint::Update => count.to_string(),
                CoveragePoint::Then | CoveragePoint::Found => format!("T{count}"),
                CoveragePoint::Else | CoveragePoint::NotFound => format!("F{count}"),
                CoveragePoint::Case(_) => format!("C{count}"),
                CoveragePoint::Otherwise => format!("O{count}"),
                CoveragePoint::None => format!("0:{count}"),
                CoveragePoint::One => format!("1:{count}"),
                CoveragePoint::Many => format!("*:{count}"),
            };
            let is_round = matches!(
                part,
                CoveragePoint::None | CoveragePoint::One | CoveragePoint::Many
            );
            note(covered.line, text, count == 0 && !is_round);
        }
    }
    margins
}

/// The coverage as LCOV.
pub fn lcov(coverage: &Coverage) -> String {
    let mut text = String::new();
    // writing to a string cannot fail
    for (path, file) in &coverage.files {
        let _ = writeln!(text, "TN:\nSF:{path}");
        for rule in file.rules.values() {
            let _ = writeln!(text, "FN:{},{}", rule.line, rule.name);
            let _ = writeln!(text, "FNDA:{},{}", rule.calls, rule.name);
        }
        let mut lines: BTreeMap<usize, u64> = BTreeMap::new();
        for rule in file.rules.values() {
            lines.insert(rule.line, rule.calls);
            for (branch, ((place, part), covered)) in rule.parts.iter().enumerate() {
                if *part == CoveragePoint::Update {
                    *lines.entry(covered.line).or_default() += covered.count;
                } else if is_branch(*part) {
                    let (line, count) = (covered.line, covered.count);
                    let _ = writeln!(text, "BRDA:{line},{place},{branch},{count}");
                }
            }
        }
        for (line, count) in lines {
            let _ = writeln!(text, "DA:{line},{count}");
        }
        text.push_str("end_of_record\n");
    }
    text
}

fn is_branch(part: CoveragePoint) -> bool {
    match part {
        CoveragePoint::Then
        | CoveragePoint::Else
        | CoveragePoint::Case(_)
        | CoveragePoint::Otherwise
        | CoveragePoint::Found
        | CoveragePoint::NotFound => true,
        CoveragePoint::Rule
        | CoveragePoint::Update
        | CoveragePoint::Round
        | CoveragePoint::None
        | CoveragePoint::One
        | CoveragePoint::Many => false,
    }
}
