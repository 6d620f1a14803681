//! A line-based scanner for the subset of AsmetaL used in tests. Specifications with annotations or imports are read
//! by the language crates.

use std::cell::OnceCell;

use asmotion_composite::AsmFiles;
use asmotion_composite::signature::{
    Codomain, FunctionInfo, FunctionKind, ParameterInfo, Signature, Specifications,
    StatedProperties,
};
use asmotion_diagnostics::{Loader, Report, Sources, Span};

use super::Files;

impl Specifications for Files {
    fn open(
        &self,
        path: &str,
        sources: &mut Sources,
    ) -> Result<Option<Box<dyn Signature>>, Report> {
        let Ok(text) = self.read(path) else {
            return Ok(None);
        };
        if text.contains("//@") || text.contains("import ") {
            return AsmFiles::new(self).open(path, sources);
        }
        let file = sources.add(path, text.clone());
        let mut scanner = Scanner::default();
        let mut offset = 0;
        for line in text.split_inclusive('\n') {
            let start = offset + line.len() - line.trim_start().len();
            scanner.line(line.trim(), |length| Span::new(file, start, start + length));
            offset += line.len();
        }
        Ok(Some(Box::new(scanner)))
    }
}

/// Functions and domains found by the scanner.
#[derive(Default)]
pub struct Scanner {
    domains: Vec<(String, Vec<String>, Span)>,
    functions: Vec<(FunctionKind, String, String, Span)>,
    main: Option<(String, Span)>,
    described: OnceCell<Vec<FunctionInfo>>,
}

impl Scanner {
    fn line(&mut self, line: &str, span: impl Fn(usize) -> Span) {
        if let Some(rest) = line.strip_prefix("enum domain ")
            && let Some((name, literals)) = rest.split_once('=')
        {
            let literals = literals.trim().trim_matches(['{', '}']).split('|');
            let literals = literals.map(|literal| literal.trim().to_owned()).collect();
            self.domains
                .push((name.trim().to_owned(), literals, span(line.len())));
        }
        if let Some(rest) = line.strip_prefix("main rule ") {
            let name: String = rest
                .chars()
                .take_while(|c| c.is_alphanumeric() || *c == '_')
                .collect();
            self.main = Some((name, span(line.len())));
        }
        let kinds = [
            FunctionKind::Monitored,
            FunctionKind::Shared,
            FunctionKind::Out,
            FunctionKind::Controlled,
            FunctionKind::Static,
        ];
        for kind in kinds {
            if let Some(rest) = line.strip_prefix(kind.word())
                && let Some((name, domains)) =
                    rest.strip_prefix(' ').and_then(|it| it.split_once(':'))
            {
                let domains = domains.trim().to_owned();
                self.functions
                    .push((kind, name.trim().to_owned(), domains, span(line.len())));
            }
        }
    }

    fn codomain(&self, name: &str) -> Codomain {
        if let Some((constructor, parts)) = applied(name) {
            let name = name.to_owned();
            return match constructor {
                "Prod" => Codomain::Tuple {
                    name,
                    items: parts.split(", ").map(|part| self.codomain(part)).collect(),
                },
                _ => Codomain::List {
                    name,
                    item: Box::new(self.codomain(parts)),
                },
            };
        }
        match name {
            "Boolean" => Codomain::Boolean,
            "Integer" | "Natural" => Codomain::Integer,
            "Real" => Codomain::Real,
            "String" => Codomain::Text,
            _ => match self.domains.iter().find(|(domain, _, _)| domain == name) {
                Some((name, literals, declared)) => Codomain::Enum {
                    name: name.clone(),
                    literals: literals.clone(),
                    declared: Some(*declared),
                },
                None => Codomain::Other(name.to_owned()),
            },
        }
    }
}

/// Splits `Seq(Integer)` into its constructor and its parts.
fn applied(name: &str) -> Option<(&str, &str)> {
    name.strip_suffix(')')?.split_once('(')
}

impl Scanner {
    fn parameter(&self, name: &str) -> ParameterInfo {
        let domain = self.codomain(name);
        let elements = match &domain {
            Codomain::Enum { literals, .. } => Some(literals.clone()),
            Codomain::Boolean
            | Codomain::Integer
            | Codomain::Real
            | Codomain::Text
            | Codomain::List { .. }
            | Codomain::Tuple { .. }
            | Codomain::Map { .. }
            | Codomain::Character
            | Codomain::Abstract(_)
            | Codomain::Other(_) => None,
        };
        let name = name.to_owned();
        ParameterInfo {
            name,
            domain,
            elements,
        }
    }
}

impl Signature for Scanner {
    /// Specifications with properties import libraries, so the scanner does not read them.
    fn stated_properties(&self) -> Option<StatedProperties> {
        Some(StatedProperties::default())
    }

    fn functions(&self) -> &[FunctionInfo] {
        let described = |(kind, name, domains, declared): &(_, String, String, _)| {
            let (domain, codomain) = domains.split_once(" -> ").unwrap_or(("", domains));
            let names = domain.split(", ").filter(|name| !name.is_empty());
            FunctionInfo {
                name: name.clone(),
                kind: *kind,
                domain: domain.to_owned(),
                parameters: names.map(|name| self.parameter(name)).collect(),
                codomain: self.codomain(codomain),
                declared: *declared,
            }
        };
        self.described
            .get_or_init(|| self.functions.iter().map(described).collect())
    }

    fn main_rule(&self) -> Option<(String, Span)> {
        self.main.clone()
    }
}
