//! `asmotion check`: reports errors and warnings before anything runs.

mod connections;
mod explain;
mod findings;
mod fix;
mod json;

use super::tool::Tool;
use crate::build::Build;
use crate::exit::Exit;
use crate::files::DiskLoader;
use crate::paths::{FileKind, NamedFile, named_files};
use crate::terminal::{TerminalOutput, count};
use asmotion_diagnostics::Applicability;
use asmotion_lang::{Diagnostic, ReadOptions, Report, Sources};
use clap::{Args, ValueEnum};
use findings::findings;
use fix::FixedFile;
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::path::PathBuf;

/// Checks specifications, scenarios and composites without running them.
#[derive(Args)]
pub struct Check {
    /// Specifications (`.asm`), scenarios (`.avalla`, `.env.toml`), composites and message types (`.toml`), and folders that
    /// contain specifications, scenarios and composites (`.composite.toml`); `-` is standard input
    #[arg(value_name = "PATH", required_unless_present = "explain")]
    paths: Vec<PathBuf>,

    /// Explains a code, with a faulty example and its correction; without a code, lists all codes
    #[arg(long, value_name = "CODE", num_args = 0..=1, conflicts_with_all = ["paths", "fix"])]
    explain: Option<Option<String>>,

    /// Output format of the findings
    #[arg(long, value_enum, default_value_t = FindingFormat::Full)]
    format: FindingFormat,

    /// Same as `--format json`
    #[arg(long, conflicts_with = "format")]
    json: bool,

    /// Applies all safe fixes, rewrites the files, and reports the remaining findings
    #[arg(long)]
    fix: bool,

    /// With `--fix`: prints the changes as a diff and leaves the files unchanged
    #[arg(
        long,
        visible_alias = "dry-run",
        requires = "fix",
        conflicts_with = "json"
    )]
    diff: bool,

    /// Lists the connections of composites: within a process (real time) or over a broker (not real time)
    #[arg(long, conflicts_with_all = ["json", "explain"])]
    connections: bool,

    /// Starts no programs that implement components of composites, and does not verify their ports and services
    #[arg(long)]
    no_programs: bool,

    /// Follows this tool where it observably differs from the textbook
    #[arg(long, value_enum, value_name = "TOOLS")]
    compat: Option<Tool>,
}

/// Kinds of files that are checked in a folder.
const KINDS: &[FileKind] = &[
    FileKind::Specification,
    FileKind::Scenario,
    FileKind::Script,
    FileKind::Composite,
    FileKind::Mission,
];

/// Output format of the findings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum FindingFormat {
    /// Findings with source lines, on standard error
    Full,
    /// One line for each finding, on standard output
    Concise,
    /// One JSON document, on standard output
    Json,
}

/// Results of all files.
#[derive(Default)]
struct CheckSummary {
    files: Vec<String>,
    report: Report,
    findings: Vec<Value>,
    fixed: Vec<Value>,
    /// The findings so far, as JSON.
    seen: BTreeSet<String>,
    /// The most severe exit code so far.
    exit: Exit,
}

impl CheckSummary {
    /// Returns the findings that no earlier file has: a specification is checked alone and as part of composites.
    fn unseen(&mut self, report: Report, sources: &Sources) -> Report {
        let mut unseen = Report::new();
        let mut all = Vec::new();
        for finding in report.diagnostics {
            let content = json::finding(&finding, sources).to_string();
            if !self.seen.contains(&content) {
                unseen.push(finding);
            }
            all.push(content);
        }
        self.seen.extend(all);
        unseen
    }
}

impl Check {
    /// Checks all files.
    pub fn run(self, build: &Build, terminal: &mut TerminalOutput) -> Exit {
        if let Some(code) = &self.explain {
            return explain::explain(code.as_deref(), terminal);
        }
        if self.no_programs {
            build.programs().turn_off();
        }
        let options = self.options();
        let named = match named_files(&self.paths, KINDS) {
            Ok(named) => named,
            Err(error) => {
                terminal.error(error);
                return Exit::Usage;
            }
        };
        if self.fix && !self.diff && named.iter().any(NamedFile::is_standard_input) {
            terminal.error(
                "`--fix` rewrites files; for standard input, `--fix --diff` prints the changes",
            );
            return Exit::Usage;
        }
        let files: Vec<String> = named.iter().map(NamedFile::text).collect();
        let mut summary = CheckSummary {
            files: files.clone(),
            ..CheckSummary::default()
        };
        for path in &files {
            if self.format() == FindingFormat::Full {
                terminal.status("Checking", path);
            }
            let (report, sources) = match self.fix.then(|| fix::fix_file(build, path, &options)) {
                Some(Ok(fixed)) => self.fixed(build, path, fixed, &mut summary, terminal),
                // a file that cannot be read is reported like any other finding
                Some(Err(_)) | None => findings(build, path, &options, &DiskLoader),
            };
            if report.has_errors() {
                summary.exit = summary.exit.max(Exit::refused(path));
            }
            let report = summary.unseen(report, &sources);
            self.show(&report, &sources, &mut summary, terminal);
            if self.connections {
                connections::show(build, path, terminal);
            }
            summary.report.extend(report);
        }
        if self.format() == FindingFormat::Json {
            let mut document = json!({ "type": "check", "v": 1, "files": summary.files, "findings": summary.findings });
            if self.fix {
                document["fixed"] = std::mem::take(&mut summary.fixed).into();
            }
            terminal.result(document);
        }
        conclude(&summary, terminal);
        summary.exit
    }

    fn options(&self) -> ReadOptions {
        ReadOptions {
            compatible: self.compat.is_some(),
            initial: None,
        }
    }

    fn format(&self) -> FindingFormat {
        if self.json {
            FindingFormat::Json
        } else {
            self.format
        }
    }

    /// Writes the fixed file, or prints its diff. Returns the remaining findings.
    fn fixed(
        &self,
        build: &Build,
        path: &str,
        fixed: FixedFile,
        summary: &mut CheckSummary,
        terminal: &mut TerminalOutput,
    ) -> (Report, Sources) {
        if !fixed.applied_fixes.is_empty() {
            if self.diff {
                terminal.result(fixed.diff(path).trim_end());
            } else if let Err(error) = fixed.write(path) {
                terminal.error(format_args!("cannot rewrite `{path}`: {error}"));
                summary.exit = Exit::Usage;
                return findings(build, path, &self.options(), &DiskLoader);
            }
        }
        let verb = if self.diff { "Would fix" } else { "Fixed" };
        for applied in &fixed.applied_fixes {
            terminal.status(verb, format_args!("{path}:{applied}"));
        }
        summary
            .fixed
            .extend(fixed.applied_fixes.iter().map(|done| done.json(path)));
        (fixed.report, fixed.sources)
    }

    fn show(
        &self,
        report: &Report,
        sources: &Sources,
        summary: &mut CheckSummary,
        terminal: &mut TerminalOutput,
    ) {
        match self.format() {
            FindingFormat::Full => terminal.report(report, sources),
            FindingFormat::Concise => {
                for finding in &report.diagnostics {
                    terminal.result(asmotion_lang::concise(finding, sources));
                }
            }
            FindingFormat::Json => summary.findings.extend(
                report
                    .diagnostics
                    .iter()
                    .map(|finding| json::finding(finding, sources)),
            ),
        }
    }
}

/// Prints the number of files and findings.
fn conclude(summary: &CheckSummary, terminal: &mut TerminalOutput) {
    let report = &summary.report;
    let files = match summary.files.len() {
        1 => "1 file".to_owned(),
        several => format!("{several} files"),
    };
    match (count(report), report.has_errors()) {
        (Some(found), true) => terminal.error(format_args!("{found} in {files}")),
        (Some(found), false) => terminal.status("Checked", format_args!("{files}: {found}")),
        (None, _) => terminal.status("Checked", format_args!("{files}: no findings")),
    }
    let sure = report.diagnostics.iter().filter(|finding| is_sure(finding));
    match sure.count() {
        0 => {}
        1 => terminal.progress("`--fix` can fix one of them"),
        several => terminal.progress(format_args!("`--fix` can fix {several} of them")),
    }
}

/// Returns `true` if the finding has a fix that can be applied automatically.
fn is_sure(finding: &Diagnostic) -> bool {
    let fix = finding.fix.as_ref();
    fix.is_some_and(|fix| fix.applicability == Applicability::Sure)
}
