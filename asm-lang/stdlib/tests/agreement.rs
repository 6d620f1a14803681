//! Consistency of texts and table: every signature without a definition has exactly one body and
//! vice versa, and results of bodies belong to the declared codomains.

use asmotion_stdlib::{
    Builtin, BuiltinContext, BuiltinFault, builtin, builtins, libraries, library,
};
use asmotion_value::{Atom, RuleId, Value, ValueNames};
use proptest::prelude::*;
use proptest::test_runner::{TestCaseError, TestRunner};
use std::collections::BTreeSet;
use std::fmt;

#[test]
fn every_library_is_found_by_its_module_name() {
    for each in libraries() {
        assert!(
            each.text.contains(&format!("\nmodule {}\n", each.name)),
            "{}",
            each.name
        );
        for import in [each.name.to_owned(), format!("{}.asm", each.name)] {
            assert_eq!(library(&import).map(|found| found.name), Some(each.name));
        }
    }
    assert!(library("standardlibrary").is_none());
    assert!(library("").is_none());
}

#[test]
fn every_standard_signature_has_one_body_and_the_reverse() -> Result<(), String> {
    let reserved =
        |signature: &Signature| asmotion_stdlib::RESERVED.contains(&signature.name.as_str());
    let (machine, declared): (Vec<_>, Vec<_>) = undefined("StandardLibrary")?
        .into_iter()
        .partition(reserved);
    let mut signatures: Vec<_> = declared
        .iter()
        .map(|each| (each.name.as_str(), each.domain.as_str()))
        .collect();
    let mut bodies: Vec<_> = builtins().map(|each| (each.name, each.domain)).collect();
    signatures.sort_unstable();
    bodies.sort_unstable();
    assert_eq!(signatures, bodies);
    bodies.dedup();
    assert_eq!(
        signatures.len(),
        bodies.len(),
        "a signature is declared twice"
    );

    let machine: BTreeSet<_> = machine.iter().map(|each| each.name.as_str()).collect();
    for name in asmotion_stdlib::RESERVED {
        let controlled = text("StandardLibrary")?.contains(&format!("controlled {name}:"));
        assert!(controlled || machine.contains(name), "{name} is declared");
    }
    Ok(())
}

#[test]
fn what_the_machine_does_with_messages_is_declared() -> Result<(), String> {
    let text = text("CommonBehavior")?;
    let rules = text.split("rule r_act").skip(1);
    let declared: Vec<String> = rules
        .filter_map(|rest| Some(format!("r_act{}", rest.split_once('(')?.0)))
        .collect();
    let known: Vec<&str> = asmotion_stdlib::MessageAction::ALL
        .iter()
        .map(|(name, _)| *name)
        .collect();
    assert_eq!(declared, known);
    for (name, mail) in asmotion_stdlib::MessageQuery::ALL {
        assert!(text.contains(&format!("monitored {name}:")), "{name}");
        assert_eq!(asmotion_stdlib::MessageQuery::named(name), Some(mail));
    }
    for (name, act) in asmotion_stdlib::MessageAction::ALL {
        assert_eq!(asmotion_stdlib::MessageAction::named(name), Some(act));
    }
    Ok(())
}

#[test]
fn the_temporal_operators_are_listed() -> Result<(), String> {
    let mut declared: Vec<String> = Vec::new();
    for module in [
        "CTLLibrary",
        "LTLLibrary",
        "MAPEpatterns",
        "TimeLibrary",
        "TimeLibrarySimple",
    ] {
        declared.extend(undefined(module)?.into_iter().map(|each| each.name));
    }
    let mut listed = asmotion_stdlib::TEMPORAL.to_vec();
    declared.sort_unstable();
    listed.sort_unstable();
    assert_eq!(declared, listed);
    Ok(())
}

#[test]
fn every_definition_is_declared() -> Result<(), String> {
    for each in libraries() {
        let lines: Vec<&str> = lines(each.text).collect();
        let declared: Vec<&str> = lines
            .iter()
            .filter_map(|line| declaration(line))
            .map(|(_, name, _)| name)
            .collect();
        for name in lines.iter().filter_map(|line| definition(line)) {
            assert!(declared.contains(&name), "{}: {name}", each.name);
        }
        assert!(!declared.is_empty());
    }
    Ok(())
}

#[test]
fn lookup_finds_exactly_the_table() {
    for each in builtins() {
        for table in [builtin, asmotion_stdlib::compatible] {
            let found = table(each.name, each.domain).map(|found| (found.name, found.domain));
            assert_eq!(found, Some((each.name, each.domain)));
        }
    }
    assert!(
        builtin("plus", "Prod(Integer, Integer)").is_none(),
        "the canonical form has no blanks"
    );
    assert!(builtin("self", "").is_none());
}

/// Bodies respect their signatures: for arguments of the domain, the result is a value of the
/// codomain, or a fault about the values rather than their shape.
#[test]
fn bodies_keep_their_signatures() -> Result<(), String> {
    let reserved =
        |signature: &Signature| asmotion_stdlib::RESERVED.contains(&signature.name.as_str());
    for signature in undefined("StandardLibrary")?
        .into_iter()
        .filter(|each| !reserved(each))
    {
        let function = builtin(&signature.name, &signature.domain).ok_or("no body")?;
        let codomain = Domain::parse(&signature.codomain)?;
        let arguments = components(&signature.domain)?
            .iter()
            .map(Domain::values)
            .collect();
        let strategy: Vec<BoxedStrategy<Value>> = arguments;
        let outcome = TestRunner::default().run(&strategy, |arguments| {
            match call(function, &arguments) {
                Ok(value) => prop_assert!(codomain.has(&value), "{value:?} is no {codomain:?}"),
                Err(BuiltinFault::Shape { expected, found }) => {
                    return Err(TestCaseError::fail(format!(
                        "expected {expected}, found {found}"
                    )));
                }
                Err(fault) => prop_assert!(!fault.help().is_empty()),
            }
            Ok(())
        });
        outcome.map_err(|why| format!("{function:?}: {why}"))?;
    }
    Ok(())
}

proptest! {
    /// No body panics, whatever its arguments: type errors by the caller are not memory or panic
    /// hazards.
    #[test]
    fn bodies_take_anything(arguments in prop::collection::vec(any_value(), 0..4)) {
        for function in builtins() {
            let mut printed = Vec::new();
            let mut context = BuiltinContext { names: &Nameless, now_ns: 0, printed: &mut printed };
            let _ = (function.body)(&arguments, &mut context);
        }
    }
}

/// Calls a function as the machine does.
fn call(function: &Builtin, arguments: &[Value]) -> Result<Value, BuiltinFault> {
    if function.strict && arguments.iter().any(Value::is_undef) {
        return Ok(Value::Undef);
    }
    let mut printed = Vec::new();
    let mut context = BuiltinContext {
        names: &Nameless,
        now_ns: 1_500_000_000,
        printed: &mut printed,
    };
    (function.body)(arguments, &mut context)
}

struct Nameless;

impl ValueNames for Nameless {
    fn atom(&self, atom: Atom, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(to, "{}", atom.0)
    }

    fn rule(&self, rule: RuleId, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(to, "{}", rule.0)
    }
}

/// The signature of a function as declared in a text, without blanks.
struct Signature {
    name: String,
    domain: String,
    codomain: String,
}

/// Returns the static functions that a library declares without a definition.
fn undefined(module: &str) -> Result<Vec<Signature>, String> {
    let text = text(module)?;
    let defined: BTreeSet<&str> = lines(text).filter_map(definition).collect();
    let declarations = lines(text).filter_map(declaration);
    let open = declarations.filter(|(kind, name, _)| *kind == "static" && !defined.contains(name));
    Ok(open
        .map(|(_, name, profile)| {
            let profile: String = profile
                .chars()
                .filter(|each| !each.is_whitespace())
                .collect();
            let (domain, codomain) = profile.split_once("->").unwrap_or(("", &profile));
            Signature {
                name: name.into(),
                domain: domain.into(),
                codomain: codomain.into(),
            }
        })
        .collect())
}

fn text(module: &str) -> Result<&'static str, String> {
    library(module)
        .map(|library| library.text)
        .ok_or(format!("no library {module}"))
}

fn lines(text: &str) -> impl Iterator<Item = &str> {
    text.lines()
        .map(|line| line.split("//").next().unwrap_or(line).trim())
}

/// Splits `static f: D -> C` into kind, name and signature.
fn declaration(line: &str) -> Option<(&str, &str, &str)> {
    let (head, profile) = line.split_once(':')?;
    let (kind, name) = head.trim().split_once(' ')?;
    let kinds = ["static", "derived", "controlled", "monitored"];
    kinds.contains(&kind).then(|| (kind, name.trim(), profile))
}

/// Returns the name in `function f(...) =`.
fn definition(line: &str) -> Option<&str> {
    line.strip_prefix("function ")?
        .split(['(', '='])
        .next()
        .map(str::trim)
}

/// A domain as written: a name, and its arguments.
#[derive(Debug)]
struct Domain {
    name: String,
    of: Vec<Domain>,
}

/// Splits a domain into the domains of the arguments: the components of a product.
fn components(domain: &str) -> Result<Vec<Domain>, String> {
    if domain.is_empty() {
        return Ok(Vec::new());
    }
    let domain = Domain::parse(domain)?;
    Ok(if domain.name == "Prod" {
        domain.of
    } else {
        vec![domain]
    })
}

impl Domain {
    fn parse(text: &str) -> Result<Self, String> {
        let Some((name, rest)) = text.split_once('(') else {
            return Ok(Self {
                name: text.into(),
                of: Vec::new(),
            });
        };
        let inner = rest
            .strip_suffix(')')
            .ok_or(format!("`)` is missing in {text}"))?;
        let mut depth = 0;
        let parts = inner.split(|each| {
            depth += i32::from(each == '(') - i32::from(each == ')');
            depth == 0 && each == ','
        });
        Ok(Self {
            name: name.into(),
            of: parts.map(Self::parse).collect::<Result<_, _>>()?,
        })
    }

    /// Generates values of the domain and `undef`; type variables stand for Integer.
    fn values(&self) -> BoxedStrategy<Value> {
        let element = || self.of.first().map_or(integers(), Self::values);
        let defined = match self.name.as_str() {
            "Boolean" => any::<bool>().prop_map(Value::Bool).boxed(),
            "Natural" => naturals(),
            "Real" => any::<f64>().prop_map(Value::real).boxed(),
            "Complex" => complexes(),
            "Char" => any::<char>().prop_map(Value::Char).boxed(),
            "String" => "[-+.0-9a-zi n]{0,4}".prop_map(Value::text).boxed(),
            "Agent" => (0_u32..3).prop_map(|each| Value::Atom(Atom(each))).boxed(),
            "Powerset" => prop::collection::vec(element(), 0..4)
                .prop_map(Value::set)
                .boxed(),
            "Seq" => prop::collection::vec(element(), 0..4)
                .prop_map(Value::seq)
                .boxed(),
            "Bag" => prop::collection::vec(element(), 0..4)
                .prop_map(Value::bag)
                .boxed(),
            "Map" => {
                let pair = (integers(), integers());
                prop::collection::vec(pair, 0..4)
                    .prop_map(Value::map)
                    .boxed()
            }
            "Prod" => {
                let each: Vec<_> = self.of.iter().map(Self::values).collect();
                each.prop_map(Value::tuple).boxed()
            }
            _ => integers(),
        };
        prop_oneof![9 => defined, 1 => Just(Value::Undef)].boxed()
    }

    /// Returns `true` if the value is `undef` or belongs to the domain.
    fn has(&self, value: &Value) -> bool {
        let element = |value| self.of.first().is_some_and(|domain| domain.has(value));
        match (self.name.as_str(), value) {
            (_, Value::Undef)
            | ("Any", _)
            | ("Boolean", Value::Bool(_))
            | ("Real", Value::Real(_))
            | ("Complex", Value::Complex(_))
            | ("Char", Value::Char(_))
            | ("String", Value::Text(_)) => true,
            ("Natural", Value::Int(number)) => *number >= 0,
            ("Powerset", Value::Set(elements)) => elements.iter().all(element),
            ("Seq", Value::Seq(elements)) => elements.iter().all(element),
            ("Bag", Value::Bag(elements)) => elements
                .iter()
                .all(|(value, &times)| element(value) && times > 0),
            ("Map", Value::Map(_)) => true,
            (name, Value::Int(_)) => name == "Integer" || name.starts_with('D'),
            _ => false,
        }
    }
}

/// Generates small integers, so that equal ones occur, and the extremes.
fn integers() -> BoxedStrategy<Value> {
    let ends = prop::sample::select(vec![i64::MIN, i64::MIN + 1, i64::MAX - 1, i64::MAX]);
    prop_oneof![6 => -3_i64..4, 1 => ends]
        .prop_map(Value::Int)
        .boxed()
}

fn naturals() -> BoxedStrategy<Value> {
    let ends = prop::sample::select(vec![i64::MAX - 1, i64::MAX]);
    prop_oneof![6 => 0_i64..4, 1 => ends]
        .prop_map(Value::Int)
        .boxed()
}

fn complexes() -> BoxedStrategy<Value> {
    let parts = (any::<f64>(), any::<f64>());
    parts
        .prop_map(|(re, im)| asmotion_stdlib::complex::Complex::new(re, im).value())
        .boxed()
}

/// Generates values of every kind.
fn any_value() -> impl Strategy<Value = Value> {
    let kinds = [
        "Boolean", "Integer", "Natural", "Real", "Complex", "Char", "String", "Agent",
    ];
    let leaves: Vec<_> = kinds
        .map(|name| {
            Domain {
                name: name.into(),
                of: Vec::new(),
            }
            .values()
        })
        .into_iter()
        .chain([Just(Value::Rule(RuleId(0))).boxed()])
        .collect();
    prop::strategy::Union::new(leaves).prop_recursive(2, 12, 4, |inner| {
        let many = || prop::collection::vec(inner.clone(), 0..4);
        prop_oneof![
            prop::collection::vec(inner.clone(), 2..4).prop_map(Value::tuple),
            many().prop_map(Value::seq),
            many().prop_map(Value::set),
            many().prop_map(Value::bag),
            prop::collection::vec((inner.clone(), inner.clone()), 0..4).prop_map(Value::map),
        ]
    })
}
