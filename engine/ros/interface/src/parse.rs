//! Reads definitions.
//!
//! Sources: the ROS wiki, "msg" and "srv"; ROS 2 documentation, "Interfaces"; REP 9 for the order of parts of actions.

use std::collections::BTreeSet;

use crate::definition::{
    Constant, Count, Element, Field, FieldType, Interface, Primitive, Structure,
};
use crate::distribution::Distribution;
use crate::error::{DefinitionError, DefinitionProblem};
use crate::name::{InterfaceKind, InterfaceName, is_identifier};

/// Reads the text of a definition.
pub(crate) fn interface(
    name: &InterfaceName,
    text: &str,
    distribution: Distribution,
) -> Result<Interface, DefinitionError> {
    let parser = Parser { name, distribution };
    let mut parts = vec![Vec::new()];
    for (index, line) in text.lines().enumerate() {
        if line.trim_end() == "---" {
            parts.push(Vec::new());
        } else if let Some(part) = parts.last_mut() {
            part.push((index + 1, line));
        }
    }
    let mut structures = Vec::new();
    for part in &parts {
        structures.push(parser.structure(part)?);
    }
    let found = structures.len();
    let mut structures = structures.into_iter();
    let mut next = || structures.next().unwrap_or_default();
    let (wanted, interface) = match name.kind() {
        InterfaceKind::Message => (1, Interface::Message(next())),
        InterfaceKind::Service => {
            let (request, response) = (next(), next());
            (2, Interface::Service { request, response })
        }
        InterfaceKind::Action => {
            let (goal, result, feedback) = (next(), next(), next());
            let action = Interface::Action {
                goal,
                result,
                feedback,
            };
            (3, action)
        }
    };
    if found != wanted {
        return Err(parser.error(None, DefinitionProblem::Parts { found, wanted }));
    }
    Ok(interface)
}

struct Parser<'a> {
    /// Name of the interface, for errors and for names without a package.
    name: &'a InterfaceName,
    distribution: Distribution,
}

impl Parser<'_> {
    fn error(&self, line: Option<usize>, problem: DefinitionProblem) -> DefinitionError {
        DefinitionError {
            interface: self.name.clone(),
            line,
            problem,
        }
    }

    fn structure(&self, lines: &[(usize, &str)]) -> Result<Structure, DefinitionError> {
        let mut structure = Structure::default();
        let mut names = BTreeSet::new();
        for (number, line) in lines {
            let name = self
                .line(line, &mut structure)
                .map_err(|problem| self.error(Some(*number), problem))?;
            if let Some(name) = name
                && !names.insert(name.clone())
            {
                return Err(self.error(Some(*number), DefinitionProblem::Twice(name)));
            }
        }
        Ok(structure)
    }

    /// Reads a line, and returns the name that it declares.
    fn line(
        &self,
        line: &str,
        structure: &mut Structure,
    ) -> Result<Option<String>, DefinitionProblem> {
        let code = line.split('#').next().unwrap_or_default().trim();
        if code.is_empty() {
            return Ok(None);
        }
        let wrong = || DefinitionProblem::Line(code.to_owned());
        let (type_text, rest) = code.split_once(char::is_whitespace).ok_or_else(wrong)?;
        let of = self.field_type(type_text)?;
        let rest = rest.trim_start();
        let end = rest.find(|sign: char| sign == '=' || sign.is_whitespace());
        let (name, after) = rest.split_at(end.unwrap_or(rest.len()));
        if !is_identifier(name) {
            return Err(DefinitionProblem::Name(name.to_owned()));
        }
        let after = after.trim_start();
        if let Some(value) = after.strip_prefix('=') {
            if of.count != Count::One || matches!(of.element, Element::Message(_)) {
                return Err(DefinitionProblem::Constant(of.to_string()));
            }
            structure.constants.push(Constant {
                value: self.constant_text(&of.element, line, value),
                element: of.element,
                name: name.to_owned(),
            });
            return Ok(Some(name.to_owned()));
        }
        let default = match (after, self.distribution) {
            ("", _) => None,
            (default, Distribution::Ros2) => Some(self.quoted(line, default)),
            (_, Distribution::Ros1) => return Err(wrong()),
        };
        structure.fields.push(Field {
            of,
            name: name.to_owned(),
            default,
        });
        Ok(Some(name.to_owned()))
    }

    /// The value of a constant. A string of ROS 1 ends with its line, and includes `#`.
    fn constant_text(&self, element: &Element, line: &str, value: &str) -> String {
        match (element, self.distribution) {
            (Element::String(_), Distribution::Ros1) => {
                let (_, text) = line.split_once('=').unwrap_or_default();
                text.trim().to_owned()
            }
            (_, Distribution::Ros1) => value.trim().to_owned(),
            (_, Distribution::Ros2) => self.quoted(line, value.trim()),
        }
    }

    /// A value of ROS 2. A `#` in quotes does not begin a comment.
    fn quoted(&self, line: &str, value: &str) -> String {
        let Some(quote) = value.chars().next().filter(|it| matches!(it, '"' | '\'')) else {
            return value.to_owned();
        };
        let whole = line.find(value).and_then(|start| line.get(start..));
        let text = whole.unwrap_or(value);
        let mut escaped = false;
        for (index, sign) in text.char_indices().skip(1) {
            if sign == quote && !escaped {
                return text.get(..=index).unwrap_or(text).to_owned();
            }
            escaped = sign == '\\' && !escaped;
        }
        value.to_owned()
    }

    fn field_type(&self, text: &str) -> Result<FieldType, DefinitionProblem> {
        let wrong = || DefinitionProblem::Type(text.to_owned());
        let (element, count) = match text.strip_suffix(']') {
            None => (text, Count::One),
            Some(front) => {
                let (element, count) = front.rsplit_once('[').ok_or_else(wrong)?;
                let number = |digits: &str| digits.parse::<usize>().map_err(|_| wrong());
                let count = match count.strip_prefix("<=") {
                    Some(most) => Count::AtMost(number(most)?),
                    None if count.is_empty() => Count::Any,
                    None => Count::Exactly(number(count)?),
                };
                (element, count)
            }
        };
        let element = self.element(element).ok_or_else(wrong)?;
        let is_new = matches!(count, Count::AtMost(_))
            || matches!(element, Element::WideString(_) | Element::String(Some(_)));
        let is_old = matches!(
            element,
            Element::Primitive(Primitive::Time | Primitive::Duration)
        );
        let is_other = match self.distribution {
            Distribution::Ros1 => is_new,
            Distribution::Ros2 => is_old,
        };
        if is_other {
            return Err(DefinitionProblem::OtherGeneration(text.to_owned()));
        }
        Ok(FieldType { element, count })
    }

    fn element(&self, text: &str) -> Option<Element> {
        if let Some(primitive) = Primitive::of_name(text) {
            return Some(Element::Primitive(primitive));
        }
        let (word, bound) = match text.split_once("<=") {
            Some((word, bound)) => (word, Some(bound.parse::<usize>().ok()?)),
            None => (text, None),
        };
        match (word, bound) {
            ("string", bound) => return Some(Element::String(bound)),
            ("wstring", bound) => return Some(Element::WideString(bound)),
            (_, Some(_)) => return None,
            (_, None) => {}
        }
        let name = match text.split_once('/') {
            // a header of ROS 1 needs no package
            None if text == "Header" && self.distribution == Distribution::Ros1 => {
                InterfaceName::message("std_msgs", "Header")
            }
            None if is_identifier(text) => InterfaceName::message(self.name.package(), text),
            None => return None,
            Some(_) => text.parse().ok()?,
        };
        (name.kind() == InterfaceKind::Message).then_some(Element::Message(name))
    }
}
