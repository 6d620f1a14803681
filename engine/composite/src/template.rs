//! Strings with substitutions: `${properties.x}`, `${VARIABLE}` and `${VARIABLE:-default}`.

use std::fmt;

use asmotion_diagnostics::Span;

use crate::address::mask;

/// A string with substitutions, as in `amqp://${AMQP_USER:-guest}@127.0.0.1`.
#[derive(Clone, PartialEq)]
pub struct Template {
    /// Its parts in order.
    pub pieces: Vec<Piece>,
}

/// A part of a [`Template`].
#[derive(Clone, Debug, PartialEq)]
pub enum Piece {
    /// Literal text.
    Text(String),
    /// `${properties.name}`.
    Property {
        /// The property of the composite.
        name: String,
        /// Location of the name.
        span: Span,
    },
    /// `${NAME}` or `${NAME:-default}`.
    Variable {
        /// The environment variable.
        name: String,
        /// Default value; `None` if the variable must be set.
        default: Option<String>,
        /// Location of the name.
        span: Span,
    },
}

/// Displays the string as written, with the password of a URL masked.
impl fmt::Debug for Template {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let pieces = self.pieces.iter().map(|piece| match piece {
            Piece::Text(text) => text.clone(),
            Piece::Property { name, .. } => format!("${{properties.{name}}}"),
            Piece::Variable { name, .. } => format!("${{{name}}}"),
        });
        let written: String = pieces.collect();
        fmt::Debug::fmt(&mask(&written), f)
    }
}

impl Template {
    /// Returns the text if nothing is substituted.
    pub fn literal(&self) -> Option<&str> {
        match self.pieces.as_slice() {
            [] => Some(""),
            [Piece::Text(text)] => Some(text),
            _ => None,
        }
    }
}

/// Parses the substitutions of a string. Set `exact` if the string contains no escapes; otherwise errors are located at
/// the whole string.
pub(crate) fn parse(text: &str, span: Span, exact: bool) -> Result<Template, (&'static str, Span)> {
    let place = |start: usize, end: usize| {
        if exact {
            Span::new(
                span.file,
                span.start as usize + start,
                span.start as usize + end,
            )
        } else {
            span
        }
    };
    let mut pieces = Vec::new();
    let mut plain = String::new();
    let mut position = 0;
    while let Some(found) = text[position..].find('$') {
        let dollar = position + found;
        plain.push_str(&text[position..dollar]);
        let rest = &text[dollar + 1..];
        if rest.starts_with('$') {
            plain.push('$');
            position = dollar + 2;
            continue;
        }
        let Some(rest) = rest.strip_prefix('{') else {
            plain.push('$');
            position = dollar + 1;
            continue;
        };
        let Some(length) = rest.find('}') else {
            return Err(("missing `}`", place(dollar, dollar + 2)));
        };
        if !plain.is_empty() {
            pieces.push(Piece::Text(std::mem::take(&mut plain)));
        }
        let start = dollar + 2;
        pieces.push(piece(&rest[..length], |from, to| {
            place(start + from, start + to)
        })?);
        position = start + length + 1;
    }
    plain.push_str(&text[position..]);
    if !plain.is_empty() {
        pieces.push(Piece::Text(plain));
    }
    Ok(Template { pieces })
}

/// Parses the text between the braces.
fn piece(inner: &str, place: impl Fn(usize, usize) -> Span) -> Result<Piece, (&'static str, Span)> {
    if let Some(name) = inner.strip_prefix("properties.") {
        let span = place(inner.len() - name.len(), inner.len());
        return Ok(Piece::Property {
            name: name.to_owned(),
            span,
        });
    }
    let (name, default) = match inner.split_once(":-") {
        Some((name, default)) => (name, Some(default.to_owned())),
        None => (inner, None),
    };
    let span = place(0, name.len());
    let starts = name.starts_with(|first: char| first.is_ascii_uppercase() || first == '_');
    let letters =
        |letter: char| letter.is_ascii_uppercase() || letter.is_ascii_digit() || letter == '_';
    if !starts || !name.chars().all(letters) {
        return Err((
            "expected a property, or an environment variable in capital letters",
            place(0, inner.len().max(1)),
        ));
    }
    Ok(Piece::Variable {
        name: name.to_owned(),
        default,
        span,
    })
}

#[cfg(test)]
mod tests {
    use asmotion_diagnostics::{FileId, Span};

    use super::{Piece, parse};

    fn pieces(text: &str) -> Result<Vec<Piece>, &'static str> {
        let span = Span::new(FileId(0), 0, text.len());
        parse(text, span, true)
            .map(|template| template.pieces)
            .map_err(|(reason, _)| reason)
    }

    #[test]
    fn it_reads_all_three_forms() {
        let read = pieces("a${properties.b}${C:-d}$${e}").unwrap();
        let at = |start, end| Span::new(FileId(0), start, end);
        assert_eq!(
            read,
            [
                Piece::Text("a".into()),
                Piece::Property {
                    name: "b".into(),
                    span: at(14, 15)
                },
                Piece::Variable {
                    name: "C".into(),
                    default: Some("d".into()),
                    span: at(18, 19)
                },
                Piece::Text("${e}".into()),
            ]
        );
    }

    #[test]
    fn it_refuses_what_it_does_not_know() {
        assert!(pieces("${").is_err());
        assert!(pieces("${}").is_err());
        assert!(pieces("${lower}").is_err());
        assert!(pieces("${property.x}").is_err());
    }
}
