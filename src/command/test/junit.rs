//! Writes a JUnit report for Jenkins and GitLab.

use std::fmt::{self, Display, Write};
use std::path::Path;

use asmotion_lang::simulate::scenario::Verdict;
use asmotion_lang::{Style, render_all};

use super::result::{TestEnd, TestResult};
use crate::exit::Exit;
use crate::terminal::TerminalOutput;

/// Writes the report: one suite with a case for each scenario.
pub fn write(file: &Path, results: &[TestResult], terminal: &mut TerminalOutput) -> Exit {
    match std::fs::write(file, JunitReport(results).to_string()) {
        Ok(()) => Exit::Ok,
        Err(error) => {
            terminal.error(format_args!("cannot write `{}`: {error}", file.display()));
            Exit::Usage
        }
    }
}

struct JunitReport<'a>(&'a [TestResult]);

/// The element for a case that did not pass; `None` for one that passed.
fn failure_element(end: &TestEnd) -> Option<&'static str> {
    match end {
        TestEnd::Ran(Verdict::Pass) => None,
        TestEnd::Ran(Verdict::Fail | Verdict::Invariant) => Some("failure"),
        TestEnd::Ran(Verdict::Fault) | TestEnd::Unusable => Some("error"),
    }
}

impl Display for JunitReport<'_> {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        let tests = self.0.len();
        let count = |kind| {
            let troubles = self.0.iter().map(|it| failure_element(&it.end));
            troubles.filter(|it| *it == Some(kind)).count()
        };
        let (failures, errors) = (count("failure"), count("error"));
        let counts =
            format!(r#"tests="{tests}" skipped="0" errors="{errors}" failures="{failures}""#);
        writeln!(to, r#"<?xml version="1.0" encoding="UTF-8"?>"#)?;
        writeln!(to, r#"<testsuites name="asmotion test" {counts}>"#)?;
        writeln!(to, r#"    <testsuite name="scenarios" {counts}>"#)?;
        self.0.iter().try_for_each(|one| case(one, to))?;
        writeln!(to, "    </testsuite>\n</testsuites>")
    }
}

fn case(result: &TestResult, to: &mut fmt::Formatter<'_>) -> fmt::Result {
    let path = result.path.display().to_string();
    let name = match &*result.name {
        "" => &path,
        name => name,
    };
    let seconds = result.duration.as_secs_f64();
    write!(
        to,
        r#"        <testcase name="{}" classname="{}" time="{seconds:.3}""#,
        Escaped(name),
        Escaped(&path)
    )?;
    let Some(element) = failure_element(&result.end) else {
        return writeln!(to, "/>");
    };
    let first = result.report.diagnostics.first();
    let message = first.map_or("", |finding| &finding.message);
    let findings = render_all(&result.report, &result.sources, Style::Plain);
    writeln!(
        to,
        ">\n            <{element} message=\"{}\" type=\"{}\">{}</{element}>\n        </testcase>",
        Escaped(message),
        Escaped(result.end.word()),
        Escaped(&findings)
    )
}

/// Escapes a text for XML 1.0 content or attributes. Control characters, which XML 1.0 does not allow, are left out.
struct Escaped<'a>(&'a str);

impl Display for Escaped<'_> {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        for letter in self.0.chars() {
            match letter {
                '&' => to.write_str("&amp;")?,
                '<' => to.write_str("&lt;")?,
                '>' => to.write_str("&gt;")?,
                '"' => to.write_str("&quot;")?,
                '\t' | '\n' | '\r' => to.write_char(letter)?,
                '\0'..' ' | '\u{fffe}' | '\u{ffff}' => {}
                _ => to.write_char(letter)?,
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_text_can_stand_in_xml() {
        let text = "a < b && c > \"d\"\n\u{1b}[1mbold\u{0}é";
        let escaped = "a &lt; b &amp;&amp; c &gt; &quot;d&quot;\n[1mboldé";
        assert_eq!(Escaped(text).to_string(), escaped);
    }
}
