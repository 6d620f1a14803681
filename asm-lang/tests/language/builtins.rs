//! The functions of the libraries: a table with a section for each signature, and rows of a term and its value or the
//! code of its failure.

use asmotion_lang::diagnostics::FileId;
use asmotion_lang::hir::Meaning;
use asmotion_lang::syntax::parse_term;
use asmotion_lang::{Model, NoInputs, Session};
use std::collections::BTreeSet;

const TABLE: &str = include_str!("../../../tests/language/builtins.txt");

/// A specification with the names used in the rows.
const SPECIFICATION: &str = "asm builtins
import StandardLibrary
import TimeLibrary
signature:
  enum domain Color = {RED | GREEN | BLUE}
  domain Worker subsetof Agent
  static ann: Worker
  static bob: Worker
  static plain: Timer
  static fine: Timer
  static milli: Timer
  static minutes: Timer
  static hours: Timer
  static inf: Real
  static nan: Real
  controlled n: Integer
  controlled uB: Boolean
  controlled uI: Integer
  controlled uN: Natural
  controlled uR: Real
  controlled uC: Complex
  controlled uCh: Char
  controlled uS: String
  controlled uA: Agent
  controlled uT: Timer
  controlled uSet: Powerset(Integer)
  controlled uSetR: Powerset(Real)
  controlled uSeq: Seq(Integer)
  controlled uBag: Bag(Integer)
  controlled uBagR: Bag(Real)
  controlled uMap: Map(Integer, Integer)
definitions:
  function inf = 1.0 / 0.0
  function nan = 0.0 / 0.0
  rule r_work = skip
  main rule r_Main = skip
default init s0:
  function n = 5
  function timerUnit($t in Timer) = switch $t
    case fine: NANOSEC case milli: MILLISEC case minutes: MIN case hours: HOUR
  endswitch
  function start($t in Timer) = switch $t case plain: 0 case milli: 0 case minutes: 0 case hours: 0 endswitch
  function duration($t in Timer) = switch $t case plain: 1 case milli: 2000 case fine: 0 endswitch
  agent Worker: r_work[]
";

/// A term and its expected value.
struct Row {
    signature: &'static str,
    term: &'static str,
    expected: &'static str,
}

fn rows() -> Vec<Row> {
    let mut rows = Vec::new();
    for section in TABLE.split("\n\n").skip(1) {
        let (signature, lines) = section.split_once('\n').unwrap();
        for line in lines.lines() {
            let (term, expected) = line.trim().split_once(" => ").unwrap();
            rows.push(Row {
                signature,
                term,
                expected,
            });
        }
    }
    rows
}

#[test]
fn are_what_the_table_says() {
    let mut session = Session::new(super::opened("builtins", SPECIFICATION)).unwrap();
    let rows = rows();
    let mut wrong = String::new();
    let mut terms = Vec::new();
    for row in &rows {
        let tree = parse_term(FileId::default(), row.term).unwrap();
        match session.specification.model.add_term(&tree) {
            Ok(term) => {
                let model = &session.specification.model;
                let applied = applied(model);
                if applied != row.signature {
                    wrong.push_str(&format!("{}\n  is of {applied}\n", row.term));
                }
                terms.push((row, term));
            }
            Err(report) => wrong.push_str(&format!("{}\n  {report:?}\n", row.term)),
        }
    }
    session.specification.lower().unwrap();
    let program = session.specification.program.clone();
    session.machine.replace_program(program).unwrap();
    for (row, term) in terms {
        let value = session.machine.evaluate(term, &mut NoInputs, 1_999_999_999);
        let found = match value {
            Ok(value) => value.show(&session.machine.naming()).to_string(),
            Err(fault) => {
                let finding = session.specification.explain_in(&fault, &session.machine);
                finding.code.to_string()
            }
        };
        if found != row.expected {
            wrong.push_str(&format!(
                "{} => {}\n  found {found}\n",
                row.term, row.expected
            ));
        }
    }
    assert!(wrong.is_empty(), "\n{wrong}");
}

/// Every function has rows, and every function with arguments a row about undef.
#[test]
fn have_rows_each() {
    let specification = super::opened("builtins", SPECIFICATION);
    let model = &specification.model;
    let functions = model.functions.iter().filter(|function| function.library);
    let computed = functions.filter(|function| match function.meaning {
        Meaning::Builtin(_) | Meaning::Defined(_) => true,
        // `self` and `result` are locations
        Meaning::Machine => !function.parameters.is_empty(),
        Meaning::State | Meaning::Constant(_) | Meaning::Missing => false,
    });
    let declared: BTreeSet<String> = computed
        .map(|function| signature(model, function))
        .collect();
    let rows = rows();
    let tried: BTreeSet<String> = rows.iter().map(|row| row.signature.to_owned()).collect();
    assert_eq!(
        declared.symmetric_difference(&tried).collect::<Vec<_>>(),
        Vec::<&String>::new()
    );
    for signature in declared.iter().filter(|signature| signature.contains("->")) {
        let mut rows = rows.iter().filter(|row| row.signature == signature);
        let is_about_undef = |row: &Row| {
            row.term.contains("undef")
                || row
                    .term
                    .split(|letter: char| !letter.is_alphanumeric())
                    .any(|word| word.starts_with('u') && word[1..].starts_with(char::is_uppercase))
        };
        assert!(rows.clone().count() > 1, "{signature}");
        assert!(rows.any(is_about_undef), "{signature} of undef");
    }
}

/// The signature of the function applied by the most recently added term.
fn applied(model: &Model) -> String {
    let term = &model.added.terms.last().unwrap().root;
    match term.kind.function() {
        Some(function) => signature(model, model.function(function)),
        None => format!("no function: {:?}", term.kind),
    }
}

/// Formats a signature as in `plus: Prod(Integer,Integer) -> Integer`.
fn signature(model: &Model, function: &asmotion_lang::hir::Function) -> String {
    let parameters: Vec<String> = function
        .parameters
        .iter()
        .map(|&ty| model.show_type(ty))
        .collect();
    let codomain = model.show_type(function.codomain);
    match parameters.as_slice() {
        [] => format!("{}: {codomain}", function.name),
        [one] => format!("{}: {one} -> {codomain}", function.name),
        several => format!(
            "{}: Prod({}) -> {codomain}",
            function.name,
            several.join(",")
        ),
    }
}
