//! JUnit report.

use super::{End, Ended};
use crate::exit::Exit;
use crate::terminal::Terminal;
use asmotion_lang::simulate::scenario::Verdict;
use asmotion_lang::{Style, render_all};
use quick_junit::{NonSuccessKind, Report, TestCase, TestCaseStatus, TestSuite};
use std::path::Path;

/// Writes one suite with a test case for each scenario.
pub fn write(file: &Path, ended: &[Ended], terminal: &mut Terminal) -> Exit {
    let mut suite = TestSuite::new("scenarios");
    suite.add_test_cases(ended.iter().map(case));
    let mut report = Report::new("asmotion test");
    report.add_test_suite(suite);
    let written = report
        .to_string()
        .map_err(|error| error.to_string())
        .and_then(|text| std::fs::write(file, text).map_err(|error| error.to_string()));
    match written {
        Ok(()) => Exit::Ok,
        Err(error) => {
            terminal.error(format_args!("cannot write `{}`: {error}", file.display()));
            Exit::Usage
        }
    }
}

fn case(one: &Ended) -> TestCase {
    let kind = match one.end {
        End::Ran(Verdict::Pass) => None,
        End::Ran(Verdict::Fail | Verdict::Invariant) => Some(NonSuccessKind::Failure),
        End::Ran(Verdict::Fault) | End::Unusable => Some(NonSuccessKind::Error),
    };
    let status = match kind {
        None => TestCaseStatus::success(),
        Some(kind) => {
            let mut status = TestCaseStatus::non_success(kind);
            let first = one.report.diagnostics.first();
            status
                .set_type(one.end.word())
                .set_message(first.map_or("", |finding| &finding.message))
                .set_description(render_all(&one.report, &one.sources, Style::Plain));
            status
        }
    };
    let path = one.path.display().to_string();
    let mut case = TestCase::new(
        if one.name.is_empty() {
            &path
        } else {
            &one.name
        },
        status,
    );
    case.set_classname(path).set_time(one.took);
    case
}
