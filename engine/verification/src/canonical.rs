//! A form of a model that is equal for components whose verification has the same results, up to names of components.

use crate::rename::{label, tokens};
use std::collections::BTreeSet;

/// Replaces the names of components by their positions.
///
/// Names of an environment consist of parts between underscores, some of which are components: `steps_Rover1`,
/// `rover1_mode`. Replacing these parts is a renaming, so two texts with the same result are the same specification, up to
/// names. The names that the verified specification declares are not replaced: they mean the same in all environments.
pub(crate) struct CanonicalNames {
    /// The labels of components in the cases in which they occur, and what replaces them; long ones first.
    labels: Vec<(String, String)>,
    /// The components themselves, and what replaces them; long ones first.
    components: Vec<(String, String)>,
    declared: BTreeSet<String>,
}

impl CanonicalNames {
    /// Replaces these components, by position, but not in the names that the verified specification declares.
    pub(crate) fn of<'c>(
        components: impl Iterator<Item = &'c str>,
        declared: BTreeSet<String>,
    ) -> Self {
        let (mut labels, mut names) = (Vec::new(), Vec::new());
        for (position, component) in components.enumerate() {
            names.push((component.to_owned(), format!("#{position}")));
            let name = label(component);
            let mut rest = name.chars();
            let Some(first) = rest.next() else { continue };
            let rest = rest.as_str();
            // a function, a domain or a rule, and a literal
            labels.extend([
                (
                    format!("{}{rest}", first.to_ascii_lowercase()),
                    format!("#-{position}"),
                ),
                (
                    format!("{}{rest}", first.to_ascii_uppercase()),
                    format!("#{position}"),
                ),
                (name.to_ascii_uppercase(), format!("#^{position}")),
            ]);
        }
        for all in [&mut labels, &mut names] {
            all.sort_by_key(|(name, _)| std::cmp::Reverse(name.len()));
        }
        Self {
            labels,
            components: names,
            declared,
        }
    }

    /// A text for people with positions in place of components.
    pub(crate) fn prose(&self, text: &str) -> String {
        let mut done = String::with_capacity(text.len());
        let mut rest = text;
        while let Some(sign) = rest.chars().next() {
            let is_begin = !done.ends_with(char::is_alphanumeric);
            let mut names = self.components.iter().filter(|_| is_begin);
            let found = names.find_map(|(name, position)| {
                let after = rest.strip_prefix(name.as_str())?;
                (!after.starts_with(char::is_alphanumeric)).then_some((after, position))
            });
            match found {
                Some((after, position)) => {
                    done.push_str(position);
                    rest = after;
                }
                None => {
                    done.push(sign);
                    rest = rest.get(sign.len_utf8()..).unwrap_or_default();
                }
            }
        }
        done
    }

    /// The tokens of a text with positions in place of components, without its comments.
    pub(crate) fn text(&self, text: &str) -> String {
        let mut done = String::with_capacity(text.len());
        for token in tokens(text) {
            if token.starts_with("//") || token.starts_with("/*") || token.trim().is_empty() {
                continue;
            }
            self.push(token, &mut done);
            done.push(' ');
        }
        done
    }

    fn push(&self, token: &str, to: &mut String) {
        let is_word = token.starts_with(|it: char| it.is_alphanumeric() || it == '_');
        if !is_word || self.declared.contains(token) {
            to.push_str(token);
            return;
        }
        let mut rest = token;
        loop {
            let found = self.labels.iter().find_map(|(label, position)| {
                let after = rest.strip_prefix(label.as_str())?;
                // a word that is nothing but the name of a component comes from elsewhere: it is a keyword or a value
                let is_part =
                    after.starts_with('_') || after.is_empty() && rest.len() < token.len();
                is_part.then_some((after, position))
            });
            if let Some((after, position)) = found {
                to.push_str(position);
                rest = after;
            }
            let Some(end) = rest.find('_') else { break };
            let (part, after) = rest.split_at(end + 1);
            to.push_str(part);
            rest = after;
        }
        to.push_str(rest);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(components: &[&str], declared: &[&str], text: &str) -> String {
        let declared = declared.iter().map(|it| (*it).to_owned()).collect();
        CanonicalNames::of(components.iter().copied(), declared).text(text)
    }

    #[test]
    fn components_become_positions_in_the_names_of_their_environment_alone() {
        let one = "controlled steps_Rover1: Integer // Rover1\nrover1_mode := \"Rover1\"";
        let expected = "controlled steps_#0 : Integer #-0_mode : = \"Rover1\" ";
        assert_eq!(text(&["Rover1"], &[], one), expected);
        // another component, a part of a word, and the name of a component alone
        let others = "Rover12_mode arover1_mode Rover1";
        assert_eq!(
            text(&["Rover1"], &[], others),
            "Rover12_mode arover1_mode Rover1 "
        );
        // what the verified specification declares
        let own = "rover1_mode rover1_leg";
        assert_eq!(
            text(&["Rover1"], &["rover1_mode"], own),
            "rover1_mode #-0_leg "
        );
    }

    #[test]
    fn names_of_components_are_replaced_in_the_cases_of_their_kinds() {
        assert_eq!(
            text(&["Arm"], &[], "CALL_ARM_GO Arm_Mode arm_mode"),
            "CALL_#^0_GO #0_Mode #-0_mode "
        );
        let names = CanonicalNames::of(["Left/Arm", "Arm"].into_iter(), BTreeSet::new());
        assert_eq!(
            names.prose("Arm.event of Left/Arm, not Arm2, is faster than ARM"),
            "#1.event of #0, not Arm2, is faster than ARM"
        );
    }

    #[test]
    fn the_longest_name_of_a_component_counts() {
        let names = ["Rover1", "Rover1/arm"];
        assert_eq!(
            text(&names, &[], "r_Rover1_arm_go x_Rover1_y_Rover1"),
            "r_#1_go x_#0_y_#0 "
        );
    }
}
