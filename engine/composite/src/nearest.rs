//! Suggestions for misspelled names.

use asmotion_diagnostics::{Diagnostic, Span};

/// A similar known name and the location of its declaration, if in a source file.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Nearest {
    pub name: String,
    pub declared: Option<Span>,
}

/// Returns the known name most similar to `written`; `None` if none is similar enough.
pub(crate) fn nearest<'n>(
    written: &str,
    known: impl IntoIterator<Item = (&'n str, Option<Span>)>,
) -> Option<Nearest> {
    known
        .into_iter()
        .filter_map(|(name, declared)| {
            let distance = distance(written, name)?;
            Some((
                distance,
                Nearest {
                    name: name.to_owned(),
                    declared,
                },
            ))
        })
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, nearest)| nearest)
}

/// Like `nearest`, for names without source locations.
pub(crate) fn nearest_name<'n>(
    written: &str,
    known: impl IntoIterator<Item = &'n str>,
) -> Option<Nearest> {
    nearest(written, known.into_iter().map(|name| (name, None)))
}

/// Edit distance of two names; `None` if it is too large for a typing error.
///
/// At most a third of the letters may differ. A path is also compared by its last segment alone, since users write
/// `MapServer` for `nav::MapServer`.
fn distance(written: &str, name: &str) -> Option<usize> {
    if written == name || written.len() > MAX_LENGTH {
        return None;
    }
    let (lower, known) = (written.to_lowercase(), name.to_lowercase());
    if lower == known {
        return Some(0);
    }
    let last = known.rsplit("::").next().unwrap_or(&known);
    if lower.rsplit("::").next() == Some(last) && last.len() > 3 {
        return Some(1);
    }
    let letters = lower.chars().count().max(known.chars().count());
    let distance = strsim::osa_distance(&lower, &known);
    (distance * 3 <= letters).then_some(distance + 1)
}

/// Maximum length in bytes of a name considered for suggestions.
const MAX_LENGTH: usize = 80;

/// Adds spelling suggestions to a diagnostic about the text at `span`.
pub(crate) trait Suggest {
    /// Adds "did you mean" as a fix, with the location of the declaration.
    fn suggest(self, span: Span, nearest: &Option<Nearest>) -> Self;

    /// Like `suggest`, with `help` as the fallback if there is no similar name.
    fn suggest_or(self, span: Span, nearest: &Option<Nearest>, help: impl Into<String>) -> Self;
}

impl Suggest for Diagnostic {
    fn suggest(self, span: Span, nearest: &Option<Nearest>) -> Self {
        let Some(Nearest { name, declared }) = nearest else {
            return self;
        };
        let diagnostic = match declared {
            Some(declared) => self.label(*declared, "similar name declared here"),
            None => self,
        };
        diagnostic.did_you_mean(span, Some(name))
    }

    fn suggest_or(self, span: Span, nearest: &Option<Nearest>, help: impl Into<String>) -> Self {
        match nearest {
            Some(_) => self.suggest(span, nearest),
            None => self.help(help),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::nearest_name;

    fn suggestion(written: &str, known: &[&str]) -> Option<String> {
        nearest_name(written, known.iter().copied()).map(|nearest| nearest.name)
    }

    #[test]
    fn it_finds_swapped_letters() {
        assert_eq!(
            suggestion("trajectroy", &["map", "trajectory"]).as_deref(),
            Some("trajectory")
        );
    }

    #[test]
    fn it_finds_a_path_by_its_last_part() {
        let known = ["nav::MapServer", "nav::Planner"];
        assert_eq!(
            suggestion("MapServer", &known).as_deref(),
            Some("nav::MapServer")
        );
    }

    #[test]
    fn it_stays_silent_about_other_names() {
        assert_eq!(suggestion("goal", &["pose", "map"]), None);
        assert_eq!(suggestion("a", &["b"]), None);
    }
}
