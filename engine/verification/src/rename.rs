//! Renames the names that a specification declares, so that several specifications can be put together. Lines stay as they are.

use std::collections::BTreeMap;

/// Returns the text with other names; strings, characters, comments and variables stay as they are.
pub(crate) fn renamed(text: &str, names: &BTreeMap<String, String>) -> String {
    let mut done = String::with_capacity(text.len() + text.len() / 4);
    for token in tokens(text) {
        done.push_str(names.get(token).map_or(token, |name| name));
    }
    done
}

/// The tokens of a text, with comments and each white space.
pub(crate) fn tokens(text: &str) -> impl Iterator<Item = &str> {
    let mut rest = text;
    std::iter::from_fn(move || {
        let first = rest.chars().next()?;
        let (token, after) = rest.split_at(token_length(rest, first));
        rest = after;
        Some(token)
    })
}

/// Length of the token at the start of a text, in bytes.
fn token_length(text: &str, first: char) -> usize {
    let from = |start: usize, is_inside: fn(char) -> bool| {
        let rest = text.get(start..).unwrap_or_default();
        start + rest.find(|sign| !is_inside(sign)).unwrap_or(rest.len())
    };
    let is_word = |sign: char| sign.is_alphanumeric() || sign == '_';
    let behind = |end: &str, start: usize| {
        let rest = text.get(start..).unwrap_or_default();
        let found = rest.find(end).map(|at| start + at + end.len());
        found.unwrap_or(text.len())
    };
    if text.starts_with("//") {
        return from(2, |sign| sign != '\n');
    }
    if text.starts_with("/*") {
        return behind("*/", 2);
    }
    match first {
        '"' => behind("\"", 1),
        '$' => from(1, is_word),
        sign if is_word(sign) => from(0, is_word),
        sign => sign.len_utf8(),
    }
}

/// The part of a name that stands for a component: letters, digits and underscores.
pub(crate) fn label(component: &str) -> String {
    let sign = |sign: char| {
        if sign.is_ascii_alphanumeric() {
            sign
        } else {
            '_'
        }
    };
    component.chars().map(sign).collect()
}

/// The name of something that a component's specification declares, in the specification of the whole.
pub(crate) fn qualified(label: &str, name: &str) -> String {
    if let Some(rule) = name.strip_prefix("r_") {
        return format!("r_{label}_{rule}");
    }
    let is_upper = name.chars().next().is_some_and(char::is_uppercase);
    let mut start = label.chars();
    let first = start.next().unwrap_or('c');
    let first: String = if is_upper {
        first.to_uppercase().collect()
    } else {
        first.to_lowercase().collect()
    };
    format!("{first}{}_{name}", start.as_str())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_names_are_renamed() {
        let names = [
            ("mode", "arm_mode"),
            ("IDLE", "Arm_IDLE"),
            ("r_go", "r_Arm_go"),
        ];
        let names = names
            .map(|(from, to)| (from.to_owned(), to.to_owned()))
            .into();
        let text =
            "if mode = IDLE and moded then r_go[$mode, \"mode\"] endif // mode\n/* mode */ mode";
        assert_eq!(
            renamed(text, &names),
            "if arm_mode = Arm_IDLE and moded then r_Arm_go[$mode, \"mode\"] endif // mode\n/* mode */ arm_mode"
        );
        assert_eq!(renamed("\"open", &names), "\"open");
    }

    #[test]
    fn names_have_the_case_of_their_kind() {
        assert_eq!(qualified("Arm", "mode"), "arm_mode");
        assert_eq!(qualified("arm", "Mode"), "Arm_Mode");
        assert_eq!(qualified(&label("Left/Arm"), "r_go"), "r_Left_Arm_go");
    }
}
