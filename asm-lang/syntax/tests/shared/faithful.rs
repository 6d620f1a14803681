//! Checks that formatting keeps the meaning of a text.

#[allow(dead_code, reason = "other tests use other parts of it")]
#[path = "tree.rs"]
mod tree;

use asmotion_diagnostics::{FileId, Report};
use asmotion_syntax::{format, format_scenario, parse, parse_scenario};

/// Formats a specification and checks the result; returns `None` if the text has errors.
pub fn formatted(text: &str) -> Result<Option<String>, String> {
    faithful(text, format, |text| {
        let parsed = parse(FileId(0), text);
        (tree::file(&parsed.file), parsed.report)
    })
}

/// Formats a scenario and checks the result; returns `None` if the text has errors.
#[allow(dead_code, reason = "other tests use other parts of it")]
pub fn formatted_scenario(text: &str) -> Result<Option<String>, String> {
    faithful(text, format_scenario, |text| {
        let (scenario, report) = parse_scenario(FileId(0), text);
        (tree::scenario(&scenario), report)
    })
}

fn faithful(
    text: &str,
    format: fn(FileId, &str) -> Result<String, Report>,
    read: fn(&str) -> (String, Report),
) -> Result<Option<String>, String> {
    let Ok(once) = format(FileId(0), text) else {
        return Ok(None);
    };
    let (before, _) = read(text);
    let (after, report) = read(&once);
    if report.has_errors() {
        return Err(format!(
            "has errors: {:?}\n{once}",
            report.diagnostics.first()
        ));
    }
    if before != after {
        return Err(format!(
            "is another tree: {}",
            first_difference(&before, &after)
        ));
    }
    if comments(text) != comments(&once) {
        let (before, after) = (comments(text).join("\n"), comments(&once).join("\n"));
        return Err(format!(
            "has other comments: {}",
            first_difference(&before, &after)
        ));
    }
    match format(FileId(0), &once) {
        Ok(twice) if twice == once => Ok(Some(once)),
        Ok(twice) => Err(format!(
            "is not stable: {}",
            first_difference(&once, &twice)
        )),
        Err(report) => Err(format!("is refused: {report:?}\n{once}")),
    }
}

/// Returns the first line that differs, with the preceding ones.
fn first_difference(left: &str, right: &str) -> String {
    let (left, right): (Vec<&str>, Vec<&str>) = (left.lines().collect(), right.lines().collect());
    let same = left.iter().zip(&right).take_while(|(a, b)| a == b).count();
    let context = left[same.saturating_sub(3)..same].join("\n");
    format!(
        "line {}\n{context}\n- {:?}\n+ {:?}",
        same + 1,
        left.get(same),
        right.get(same)
    )
}

/// Returns the comments of a text in order, without trailing blanks in their lines.
fn comments(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let length = if rest.starts_with("//") {
            rest.find(['\n', '\r']).unwrap_or(rest.len())
        } else if let Some(inside) = rest.strip_prefix("/*") {
            inside.find("*/").map_or(rest.len(), |end| end + 4)
        } else if first == '"' || first == '\'' {
            quoted(rest, first)
        } else {
            first.len_utf8()
        };
        if length > 1 && rest.starts_with('/') {
            let lines = rest[..length].lines().map(str::trim);
            found.push(lines.collect::<Vec<_>>().join("\n"));
        }
        rest = &rest[length..];
    }
    found
}

pub fn quoted(text: &str, quote: char) -> usize {
    let mut escaped = false;
    let end = text[1..].find(|c| {
        let ends = c == quote && !escaped;
        escaped = c == '\\' && !escaped;
        ends
    });
    end.map_or(1, |end| end + 2)
}
