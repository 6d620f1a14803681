//! Compares what a command prints with what a document shows.

/// Stands for any text; alone on a line, for any lines.
const ANY: &str = "…";

/// Whether the lines are those that the document shows.
pub fn fits(shown: &[String], printed: &[&str]) -> bool {
    match shown {
        [] => printed.is_empty(),
        [first, rest @ ..] if first.trim() == ANY => {
            (0..=printed.len()).any(|from| fits(rest, &printed[from..]))
        }
        [first, rest @ ..] => printed.split_first().is_some_and(|(line, after)| {
            fits_line(first.trim_end(), line.trim_end()) && fits(rest, after)
        }),
    }
}

fn fits_line(shown: &str, printed: &str) -> bool {
    let mut parts = shown.split(ANY);
    let Some(mut rest) = parts.next().and_then(|first| printed.strip_prefix(first)) else {
        return false;
    };
    let parts: Vec<&str> = parts.collect();
    let Some((last, between)) = parts.split_last() else {
        return rest.is_empty();
    };
    for part in between {
        let Some(at) = rest.find(part) else {
            return false;
        };
        rest = &rest[at + part.len()..];
    }
    rest.ends_with(last)
}

#[test]
fn an_ellipsis_stands_for_any_text() {
    let fits = |shown: &[&str], printed: &[&str]| {
        let shown: Vec<String> = shown.iter().map(|line| (*line).to_owned()).collect();
        fits(&shown, printed)
    };
    assert!(fits(&["a … c", "…", "z"], &["a b c", "x", "y", "z"]));
    assert!(fits(&["…"], &[]));
    assert!(!fits(&["a … c"], &["a b d"]));
    assert!(!fits(&["a"], &["a", "b"]), "all lines are shown");
    assert!(!fits(&["a", "b"], &["a"]));
    assert!(!fits(&["a b"], &["a b c"]));
}
