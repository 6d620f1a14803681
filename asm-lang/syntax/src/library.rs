//! Parsing of library texts, most of which is read without the grammar.
//!
//! Every specification imports a library of two hundred and fifty declarations, whose form is simple and whose text does not change.
//! They are read word by word, with a small part of the instructions that the grammar needs for them. The reader has no messages: a
//! text that it does not understand is left to [`parse`](crate::parse()), and a test of `hir` compares both for each library.

use crate::ast::{Domain, DomainKind, Export, File, Function, FunctionKind, Import, NameText};
use crate::ast::{Type, TypeKind};
use crate::explain::Explainer;
use crate::findings::SyntaxFindings;
use crate::lexer::TextKind;
use crate::nesting::NestedTokens;
use crate::node::{Nodes, ParsedText, empty_file};
use crate::parse::{Parsed, read};
use asmotion_diagnostics::{FileId, Report, Span};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Parses a module without errors, as [`parse`](crate::parse()) does, in less time. Returns `None` if the text has another form than
/// that of libraries.
pub fn parse_library(file: FileId, text: &str) -> Option<Parsed> {
    let mut reader = DeclarationReader {
        text,
        position: 0,
        end: 0,
        file,
        names: BTreeMap::new(),
    };
    let mut tree = reader.header()?;
    while reader.declaration(&mut tree)? {}
    let start = reader.position;
    reader.expect_word("definitions")?;
    reader.expect(":")?;
    reader.skip_blanks();
    if !reader.rest().is_empty() {
        let defined = definitions(file, text, start)?;
        tree.domain_definitions = defined.domain_definitions;
        tree.function_definitions = defined.function_definitions;
        tree.rules = defined.rules;
        tree.annotations = defined.annotations;
    }
    Some(Parsed {
        file: tree,
        report: Report::new(),
    })
}

/// Parses the section of a text that begins with `definitions` at `start`. Returns `None` if a part of it could not be read. Its findings,
/// of which the missing sections are some, are dropped.
fn definitions(file: FileId, text: &str, start: usize) -> Option<File> {
    let (findings, unheard) = (SyntaxFindings::new(file), SyntaxFindings::new(file));
    let explainer = Explainer::new(text, &findings, &unheard).starting_at(start);
    let nodes = Nodes::new(text, &findings, explainer);
    let mut tokens = NestedTokens::new(text, &findings);
    tokens.lexer.start_at(start);
    let ParsedText::File(mut tree) = read(TextKind::File, start, &nodes, tokens.by_ref()).ok()?
    else {
        return None;
    };
    tree.annotations = tokens.lexer.annotations;
    (!findings.has_caught()).then_some(tree)
}

/// Reads the heading and the signature of a library. Each function returns `None` at a text of another form.
struct DeclarationReader<'a> {
    text: &'a str,
    /// Offset of the next byte.
    position: usize,
    /// Offset after the last word or sign.
    end: usize,
    file: FileId,
    /// The names read so far: most of them occur often.
    names: BTreeMap<&'a str, Arc<str>>,
}

impl<'a> DeclarationReader<'a> {
    /// Reads `module NAME`, the imports, `export *` and `signature:`.
    fn header(&mut self) -> Option<File> {
        let mut tree = empty_file();
        self.expect_word("module")?;
        tree.module = true;
        tree.name = Some(self.name()?);
        loop {
            let (word, at) = self.word()?;
            match word {
                "import" => tree.imports.push(Import {
                    path: self.name()?,
                    names: None,
                }),
                "export" => {
                    self.expect("*")?;
                    let span = self.span(at);
                    tree.export = Some(Export { names: None, span });
                }
                "signature" => break,
                _ => return None,
            }
        }
        self.expect(":")?;
        Some(tree)
    }

    /// Reads a declaration. Returns `false` before the definitions.
    fn declaration(&mut self, tree: &mut File) -> Option<bool> {
        self.skip_blanks();
        let before = self.position;
        let (word, start) = self.word()?;
        let kind = match word {
            "definitions" => {
                self.position = before;
                return Some(false);
            }
            "static" => FunctionKind::Static,
            "derived" => FunctionKind::Derived,
            "monitored" => FunctionKind::Monitored,
            "controlled" => FunctionKind::Controlled,
            _ => {
                tree.domains.push(self.domain(word, start)?);
                return Some(true);
            }
        };
        let name = self.name()?;
        self.expect(":")?;
        let first = self.domain_in_use()?;
        let (domain, codomain) = match self.expect("->") {
            Some(()) => (Some(first), self.domain_in_use()?),
            None => (None, first),
        };
        tree.functions.push(Function {
            name,
            kind,
            domain,
            codomain,
            span: self.span(start),
        });
        Some(true)
    }

    /// Reads the declaration of a domain after its first word.
    fn domain(&mut self, first: &str, start: usize) -> Option<Domain> {
        if !matches!(first, "anydomain" | "domain") {
            self.expect_word("domain")?;
        }
        let name = self.name()?;
        let kind = match first {
            "anydomain" => DomainKind::Any,
            "basic" => DomainKind::Basic,
            "abstract" => DomainKind::Abstract,
            "enum" => DomainKind::Enum(self.literals()?),
            "domain" => {
                self.expect_word("subsetof")?;
                DomainKind::Concrete(self.domain_in_use()?)
            }
            _ => return None,
        };
        Some(Domain {
            name,
            kind,
            dynamic: false,
            span: self.span(start),
        })
    }

    /// Reads `= {A | B}`.
    fn literals(&mut self) -> Option<Vec<NameText>> {
        self.expect("=")?;
        self.expect("{")?;
        let mut literals = vec![self.name()?];
        while self.expect("|").is_some() {
            literals.push(self.name()?);
        }
        self.expect("}")?;
        Some(literals)
    }

    fn domain_in_use(&mut self) -> Option<Type> {
        let (word, start) = self.word()?;
        let kind = match word {
            "Rule" if self.expect("(").is_some() => TypeKind::Rule(self.arguments()?),
            "Rule" => TypeKind::Rule(Vec::new()),
            "Prod" | "Seq" | "Powerset" | "Bag" | "Map" => {
                self.expect("(")?;
                structured(word, self.arguments()?)?
            }
            name => TypeKind::Named(self.shared(name)),
        };
        Some(Type {
            kind,
            span: self.span(start),
        })
    }

    /// Reads domains, separated by commas, and the closing bracket.
    fn arguments(&mut self) -> Option<Vec<Type>> {
        let mut arguments = vec![self.domain_in_use()?];
        while self.expect(",").is_some() {
            arguments.push(self.domain_in_use()?);
        }
        self.expect(")")?;
        Some(arguments)
    }

    fn name(&mut self) -> Option<NameText> {
        let (word, start) = self.word()?;
        Some(NameText {
            text: self.shared(word),
            span: self.span(start),
        })
    }

    fn shared(&mut self, name: &'a str) -> Arc<str> {
        let known = self.names.entry(name);
        Arc::clone(known.or_insert_with(|| Arc::from(name)))
    }

    /// Reads a word, and returns it with its offset.
    fn word(&mut self) -> Option<(&'a str, usize)> {
        self.skip_blanks();
        let (start, rest) = (self.position, self.rest());
        let is_part = |byte: &u8| byte.is_ascii_alphanumeric() || *byte == b'_';
        let length = rest.bytes().take_while(is_part).count();
        self.position += length;
        self.end = self.position;
        let word = rest.get(..length)?;
        (!word.is_empty()).then_some((word, start))
    }

    fn expect_word(&mut self, expected: &str) -> Option<()> {
        (self.word()?.0 == expected).then_some(())
    }

    /// Skips a sign, or returns `None` if there is another one.
    fn expect(&mut self, sign: &str) -> Option<()> {
        self.skip_blanks();
        if !self.rest().starts_with(sign) {
            return None;
        }
        self.position += sign.len();
        self.end = self.position;
        Some(())
    }

    /// Skips white space and comments, but no annotations.
    fn skip_blanks(&mut self) {
        loop {
            let rest = self.rest();
            let blanks = rest.bytes().take_while(u8::is_ascii_whitespace).count();
            self.position += blanks;
            let rest = self.rest();
            if !rest.starts_with("//") || rest.starts_with("//@") {
                return;
            }
            self.position += rest.find('\n').unwrap_or(rest.len());
        }
    }

    fn rest(&self) -> &'a str {
        self.text.get(self.position..).unwrap_or("")
    }

    /// The span from an offset to the end of the last word or sign.
    fn span(&self, start: usize) -> Span {
        Span::new(self.file, start, self.end)
    }
}

fn structured(word: &str, arguments: Vec<Type>) -> Option<TypeKind> {
    if word == "Prod" {
        return Some(TypeKind::Prod(arguments));
    }
    let mut arguments = arguments.into_iter().map(Box::new);
    let (first, second) = (arguments.next()?, arguments.next());
    Some(match (word, second) {
        ("Seq", None) => TypeKind::Seq(first),
        ("Powerset", None) => TypeKind::Powerset(first),
        ("Bag", None) => TypeKind::Bag(first),
        ("Map", Some(second)) => TypeKind::Map(first, second),
        _ => return None,
    })
}
