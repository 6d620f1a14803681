//! JSON values as YAML 1.2 in block style, with strings quoted as in JSON.

use serde_json::Value;

/// Returns the text of a document.
pub fn text(value: &Value) -> String {
    let mut text = String::new();
    write(value, 0, &mut text);
    text
}

fn write(value: &Value, depth: usize, text: &mut String) {
    let indent = "  ".repeat(depth);
    match value {
        Value::Object(members) if !members.is_empty() => {
            for (name, member) in members {
                text.push_str(&format!("{indent}{}:", Value::from(name.as_str())));
                write_nested(member, depth, text);
            }
        }
        Value::Array(elements) if !elements.is_empty() => {
            for element in elements {
                text.push_str(&format!("{indent}-"));
                write_nested(element, depth, text);
            }
        }
        Value::Object(_)
        | Value::Array(_)
        | Value::Null
        | Value::Bool(_)
        | Value::Number(_)
        | Value::String(_) => text.push_str(&format!("{indent}{value}\n")),
    }
}

/// Writes the value of a key or list item: on the same line, or on the following ones.
fn write_nested(value: &Value, depth: usize, text: &mut String) {
    let is_block = match value {
        Value::Object(members) => !members.is_empty(),
        Value::Array(elements) => !elements.is_empty(),
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => false,
    };
    if is_block {
        text.push('\n');
        write(value, depth + 1, text);
    } else {
        text.push_str(&format!(" {value}\n"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn it_is_in_blocks_and_quotes_what_is_text() {
        let value = json!({ "a": { "b/c": [1, { "d": "yes: \"no\"" }, []] }, "e": null });
        let wanted = "\"a\":\n  \"b/c\":\n    - 1\n    -\n      \"d\": \"yes: \\\"no\\\"\"\n    - []\n\"e\": null\n";
        assert_eq!(text(&value), wanted);
    }
}
