//! Verdicts of NuSMV on translations of specifications that were written by hand.

use crate::naive::Random;
use asmotion_lang::MemoryFiles;
use asmotion_verify::{Engine, Options, verify};
use std::fmt::Write;
use std::path::Path;

/// Number of random formulas of each logic for a specification.
const FORMULAS: usize = 30;

/// A specification with its translation, and conditions that are written in the same way in both languages.
const MODELS: &[(&str, &str, &[&str])] = &[
    (
        "estop",
        "estop.asm",
        &[
            "mode = RUN",
            "mode = ARMED",
            "speedLimit = 2",
            "button",
            "reset",
            "confirm",
        ],
    ),
    (
        "patrol",
        "patrol.asm",
        &[
            "mode = MOVING",
            "mode = PAUSED",
            "mode = CHARGING",
            "wp = 2",
            "target = wp",
            "estop",
            "lowBattery",
        ],
    ),
    (
        "recovery",
        "recovery.asm",
        &[
            "mode = WAIT",
            "mode = GIVE_UP",
            "mode = SUCCESS",
            "retries = 3",
            "recovery = SPIN",
            "cancelCall",
            "reply = FATAL",
            "replyIsForMe",
        ],
    ),
];

/// A formula in both languages.
struct Both {
    asm: String,
    smv: String,
}

impl Both {
    fn random(random: &mut Random, conditions: &[&str], depth: u32, is_linear: bool) -> Self {
        if depth == 0 {
            let condition = random.one_of(conditions);
            return Self {
                asm: condition.to_owned(),
                smv: condition.to_owned(),
            };
        }
        let mut operand = || Self::random(random, conditions, depth - 1, is_linear);
        let (left, right) = (operand(), operand());
        let unary: &[(&str, &str)] = if is_linear {
            &[
                ("x", "X"),
                ("g", "G"),
                ("f", "F"),
                ("y", "Y"),
                ("o", "O"),
                ("h", "H"),
            ]
        } else {
            &[
                ("ex", "EX"),
                ("ax", "AX"),
                ("ef", "EF"),
                ("af", "AF"),
                ("eg", "EG"),
                ("ag", "AG"),
            ]
        };
        let connectives = [("and", "&"), ("or", "|"), ("implies", "->"), ("iff", "<->")];
        match random.below(10) {
            0..5 => {
                let (asm, smv) = unary[random.below(unary.len() as u64) as usize];
                Self {
                    asm: format!("{asm}({})", left.asm),
                    smv: format!("{smv} ({})", left.smv),
                }
            }
            5..7 => {
                let (asm, smv) = connectives[random.below(4) as usize];
                Self {
                    asm: format!("(({}) {asm} ({}))", left.asm, right.asm),
                    smv: format!("(({}) {smv} ({}))", left.smv, right.smv),
                }
            }
            7 => Self {
                asm: format!("not ({})", left.asm),
                smv: format!("!({})", left.smv),
            },
            _ if is_linear => {
                let (asm, smv) = [("u", "U"), ("s", "S")][random.below(2) as usize];
                Self {
                    asm: format!("{asm}({}, {})", left.asm, right.asm),
                    smv: format!("(({}) {smv} ({}))", left.smv, right.smv),
                }
            }
            _ => {
                let (asm, smv) = [("eu", "E"), ("au", "A")][random.below(2) as usize];
                Self {
                    asm: format!("{asm}({}, {})", left.asm, right.asm),
                    smv: format!("{smv} [({}) U ({})]", left.smv, right.smv),
                }
            }
        }
    }
}

/// Translates a property of a file word by word.
fn translated(property: &str) -> String {
    let mut smv = String::new();
    let mut rest = property;
    while let Some(first) = rest.chars().next() {
        let is_word = |sign: char| sign.is_alphanumeric() || sign == '_';
        let end = rest.find(|sign| !is_word(sign)).unwrap_or(rest.len());
        let (word, after) = rest.split_at(end.max(first.len_utf8()));
        smv.push_str(match word {
            "ag" => "AG ",
            "ax" => "AX ",
            "ef" => "EF ",
            "and" => "&",
            "or" => "|",
            "not" => "!",
            "implies" => "->",
            "iff" => "<->",
            word => word,
        });
        rest = after;
    }
    smv
}

/// Runs NuSMV, and returns its verdicts in the order of the specifications, those of CTL before those of LTL.
fn verdicts(nusmv: &asmotion_skip::Nusmv, model: &Path) -> Vec<bool> {
    let output = nusmv.command().args(["-dcx"]).arg(model).output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout);
    let lines = text.lines().filter(|it| it.starts_with("-- specification"));
    let verdicts = lines.map(|line| {
        let (_, verdict) = line.rsplit_once("is ").unwrap();
        assert!(["true", "false"].contains(&verdict), "{line}");
        verdict == "true"
    });
    verdicts.collect()
}

#[test]
fn verdicts_on_specifications_are_those_of_nusmv() {
    let Some(nusmv) = asmotion_skip::nusmv() else {
        return;
    };
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut random = Random(0x1234_5678_9abc_def1);
    let (mut held, mut violated) = (0, 0);
    for (name, file, conditions) in MODELS {
        let text = std::fs::read_to_string(root.join("../../specs").join(name).join(file)).unwrap();
        let text = text.replace("import CTLLibrary", "import CTLLibrary\nimport LTLLibrary");
        let mut files = MemoryFiles::new();
        files.add(file, text);
        let specification = asmotion_lang::open(file, &files).unwrap();
        let mut model =
            std::fs::read_to_string(root.join(format!("tests/smv/{name}.smv"))).unwrap();
        let mut properties = Vec::new();
        for property in &specification.model.properties {
            let text = specification
                .sources
                .snippet(property.formulas[0].root.span);
            let words: Vec<&str> = text.split_whitespace().collect();
            let text = words.join(" ");
            writeln!(model, "CTLSPEC {}", translated(&text)).unwrap();
            properties.push(text);
        }
        for is_linear in [false, true] {
            for at in 0..FORMULAS {
                let both = Both::random(&mut random, conditions, at as u32 % 3, is_linear);
                // a formula without temporal operators would be about all states
                let (asm, smv) = match (is_linear, at % 2) {
                    (true, 0) => ("g", "G"),
                    (true, _) => ("f", "F"),
                    (false, 0) => ("ag", "AG"),
                    (false, _) => ("ef", "EF"),
                };
                let both = Both {
                    asm: format!("{asm}({})", both.asm),
                    smv: format!("{smv} ({})", both.smv),
                };
                let keyword = if is_linear { "LTLSPEC" } else { "CTLSPEC" };
                writeln!(model, "{keyword} {}", both.smv).unwrap();
                properties.push(both.asm);
            }
        }
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.smv"));
        std::fs::write(&path, &model).unwrap();
        let expected = verdicts(&nusmv, &path);
        let options = Options {
            properties: properties.clone(),
            only: properties.clone(),
            ..Options::default()
        };
        let verification = verify(specification, &options, &mut |_| true);
        let verification = verification.unwrap_or_else(|it| panic!("{}", crate::refused(&it)));
        assert_eq!(expected.len(), properties.len(), "{}", path.display());
        for (property, expected) in properties.iter().zip(expected) {
            let found = verification
                .properties
                .iter()
                .find(|it| it.text == *property)
                .unwrap();
            assert_eq!(
                found.verdict.holds(),
                expected,
                "{property} in {}",
                path.display()
            );
            held += usize::from(expected);
            violated += usize::from(!expected);
        }
    }
    assert!(held > 50 && violated > 50, "{held} {violated}");
}

/// A condition on the state and the inputs of a random model, in both languages.
fn guard(random: &mut Random) -> Both {
    let one = random.one_of(MODEL_CONDITIONS);
    let other = random.one_of(MODEL_CONDITIONS);
    match random.below(5) {
        0 => Both {
            asm: format!("{one} and {other}"),
            smv: format!("{one} & {other}"),
        },
        1 => Both {
            asm: format!("not ({one}) or {other}"),
            smv: format!("!({one}) | {other}"),
        },
        2 => Both {
            asm: format!("not ({one})"),
            smv: format!("!({one})"),
        },
        _ => Both {
            asm: one.to_owned(),
            smv: one.to_owned(),
        },
    }
}

const MODEL_CONDITIONS: &[&str] = &[
    "mode = STOP",
    "mode = TURN",
    "mode != GO",
    "n = 0",
    "n < 2",
    "n = k",
    "k > 1",
    "locked",
    "estop",
    "seen",
];

/// The next value of a variable: those of the first guard that holds; it stays as it is otherwise.
fn next(random: &mut Random, variable: &str, values: &[&str]) -> Both {
    let mut both = Both {
        asm: String::new(),
        smv: format!("  next({variable}) := case\n"),
    };
    let count = 1 + random.below(3);
    for _ in 0..count {
        let when = guard(random);
        let (first, second) = (random.one_of(values), random.one_of(values));
        let (asm, smv) = if random.below(3) == 0 {
            (
                format!("choose $v in {{{first}, {second}}} with true do {variable} := $v"),
                format!("{{{first}, {second}}}"),
            )
        } else {
            (format!("{variable} := {first}"), first.to_owned())
        };
        write!(both.asm, "if {} then {asm} else ", when.asm).unwrap();
        writeln!(both.smv, "    {} : {smv};", when.smv).unwrap();
    }
    write!(both.asm, "skip{}", " endif".repeat(count as usize)).unwrap();
    write!(both.smv, "    TRUE : {variable};\n  esac;").unwrap();
    both
}

/// A model of a robot that stops, goes and turns, with two counters, a lock and two inputs.
fn random_model(random: &mut Random) -> Both {
    let numbers = [
        "0",
        "1",
        "3",
        "(n + 1) mod 4",
        "(n + k) mod 4",
        "(k + 3) mod 4",
    ];
    let mode = next(random, "mode", &["STOP", "GO", "TURN"]);
    let n = next(random, "n", &numbers);
    let k = next(random, "k", &numbers);
    let locked = next(random, "locked", &["true", "false"]);
    let just = (random.below(2) == 0).then(|| guard(random));
    let justice = just.as_ref().map(|it| format!("  JUSTICE {}\n", it.asm));
    let fairness = just.as_ref().map(|it| format!("FAIRNESS {}\n", it.smv));
    Both {
        asm: format!(
            "asm model
import StandardLibrary
import CTLLibrary
import LTLLibrary
signature:
  enum domain Mode = {{STOP | GO | TURN}}
  domain Number subsetof Integer
  monitored estop: Boolean
  monitored seen: Boolean
  controlled mode: Mode
  controlled n: Number
  controlled k: Number
  controlled locked: Boolean
definitions:
  domain Number = {{0 : 3}}
{}  main rule r_Main = par
    {}
    {}
    {}
    {}
  endpar
default init s0:
  function mode = STOP
  function n = 0
  function k = 0
  function locked = false
",
            justice.unwrap_or_default(),
            mode.asm,
            n.asm,
            k.asm,
            locked.asm
        ),
        smv: format!(
            "MODULE main
VAR
  estop : boolean;
  seen : boolean;
  mode : {{STOP, GO, TURN}};
  n : 0..3;
  k : 0..3;
  locked : boolean;
ASSIGN
  init(mode) := STOP;
  init(n) := 0;
  init(k) := 0;
  init(locked) := FALSE;
{}
{}
{}
{}
{}",
            mode.smv,
            n.smv,
            k.smv,
            locked.smv.replace("true", "TRUE").replace("false", "FALSE"),
            fairness.unwrap_or_default()
        ),
    }
}

#[test]
fn verdicts_on_random_models_are_those_of_nusmv() {
    let Some(nusmv) = asmotion_skip::nusmv() else {
        return;
    };
    let seed = std::env::var("ASMOTION_NUSMV_SEED").ok();
    let seed = seed.and_then(|it| it.parse().ok());
    let mut random = Random(seed.unwrap_or(0x0b5e_55ed_0000_0001));
    let (mut held, mut violated) = (0, 0);
    for _ in 0..40 {
        let mut model = random_model(&mut random);
        let mut properties = Vec::new();
        for is_linear in [false, true] {
            for at in 0..8 {
                let depth = 1 + at % 3;
                let both = Both::random(&mut random, MODEL_CONDITIONS, depth, is_linear);
                let (asm, smv, keyword) = match (is_linear, at % 2) {
                    (true, 0) => ("g", "G", "LTLSPEC"),
                    (true, _) => ("f", "F", "LTLSPEC"),
                    (false, 0) => ("ag", "AG", "CTLSPEC"),
                    (false, _) => ("ef", "EF", "CTLSPEC"),
                };
                // NuSMV's states have values of both inputs; ours do if the property mentions them
                writeln!(model.smv, "{keyword} {smv} ({})", both.smv).unwrap();
                let mentions = "(estop or not estop) and (seen or not seen)";
                properties.push(format!("{asm}({mentions} and {})", both.asm));
            }
        }
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("random.smv");
        std::fs::write(&path, &model.smv).unwrap();
        let expected = verdicts(&nusmv, &path);
        assert_eq!(expected.len(), properties.len(), "{}", model.smv);
        let mut files = MemoryFiles::new();
        files.add("model.asm", model.asm.clone());
        for engine in [Engine::Explicit, Engine::Symbolic] {
            let specification = asmotion_lang::open("model.asm", &files);
            let specification = specification.unwrap_or_else(|it| panic!("{it}{}", model.asm));
            let options = Options {
                properties: properties.clone(),
                only: properties.clone(),
                engine,
                ..Options::default()
            };
            let verification = verify(specification, &options, &mut |_| true);
            let verification = verification.unwrap_or_else(|it| panic!("{}", crate::refused(&it)));
            for (property, expected) in properties.iter().zip(&expected) {
                let mut found = verification.properties.iter();
                let found = found.find(|it| it.text == *property).unwrap();
                assert_eq!(
                    found.verdict.holds(),
                    *expected,
                    "{property} ({engine:?})\n{}\n{}",
                    model.asm,
                    model.smv
                );
                held += usize::from(*expected);
                violated += usize::from(!expected);
            }
        }
    }
    assert!(held > 200 && violated > 200, "{held} {violated}");
}

/// The inputs of random models.
const INPUTS: [&str; 2] = ["estop", "seen"];

/// Returns the verdicts of both on formulas that mention the same inputs. In the model for NuSMV, those that they do not mention label
/// transitions (`IVAR`), instead of being part of the state.
fn compared(nusmv: &asmotion_skip::Nusmv, model: &Both, formulas: &[&Both]) -> Vec<(bool, bool)> {
    let fairness = model.smv.find("FAIRNESS").unwrap_or(model.smv.len());
    let is_state =
        |input: &str| formulas[0].asm.contains(input) || model.smv[fairness..].contains(input);
    let mut smv = model.smv.clone();
    for input in INPUTS.iter().filter(|input| !is_state(input)) {
        let declared = format!("  {input} : boolean;\n");
        smv = smv.replacen(&declared, "", 1);
        smv = smv.replacen(
            "MODULE main\n",
            &format!("MODULE main\nIVAR\n{declared}"),
            1,
        );
    }
    for formula in formulas {
        writeln!(smv, "CTLSPEC {}", formula.smv).unwrap();
    }
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("inputs.smv");
    std::fs::write(&path, &smv).unwrap();
    let theirs = verdicts(nusmv, &path);
    assert_eq!(theirs.len(), formulas.len(), "{smv}");
    let properties: Vec<String> = formulas.iter().map(|it| it.asm.clone()).collect();
    let ours = verified_as_a_whole(&model.asm, &properties);
    ours.into_iter().zip(theirs).collect()
}

/// Verifies properties with both engines, which agree.
fn verified_as_a_whole(model: &str, properties: &[String]) -> Vec<bool> {
    let of_engine = |engine| {
        let options = Options {
            properties: properties.to_vec(),
            only: properties.to_vec(),
            engine,
            ..Options::default()
        };
        let verification = crate::verified(model, &options);
        let verdict = |property: &String| {
            let mut found = verification.properties.iter();
            let found = found.find(|it| it.text == *property).unwrap();
            found.verdict.holds()
        };
        properties.iter().map(verdict).collect::<Vec<bool>>()
    };
    let explicit = of_engine(Engine::Explicit);
    assert_eq!(
        explicit,
        of_engine(Engine::Symbolic),
        "{properties:?}\n{model}"
    );
    explicit
}

/// A state has values of the inputs that a property mentions. This is the only difference to NuSMV: where its states have no others
/// either, because they are declared with `IVAR`, the verdicts are the same.
#[test]
fn inputs_that_a_property_does_not_mention_are_ivar_of_nusmv() {
    let Some(nusmv) = asmotion_skip::nusmv() else {
        return;
    };
    let seed = std::env::var("ASMOTION_NUSMV_SEED").ok();
    let seed = seed.and_then(|it| it.parse().ok());
    let mut random = Random(seed.unwrap_or(0x0b5e_55ed_0000_0002));
    let (mut held, mut violated, mut different) = (0, 0, 0);
    for _ in 0..20 {
        let model = random_model(&mut random);
        let mut groups: [Vec<Both>; 4] = Default::default();
        for at in 0..32 {
            let known: Vec<&str> = MODEL_CONDITIONS
                .iter()
                .filter(|it| !INPUTS.contains(it) || at % 2 == 0)
                .copied()
                .collect();
            let both = Both::random(&mut random, &known, 2 + at % 2, false);
            let both = Both {
                asm: format!("ag({})", both.asm),
                smv: format!("AG ({})", both.smv),
            };
            let mentioned = INPUTS.map(|it| usize::from(both.asm.contains(it)));
            groups[mentioned[0] + 2 * mentioned[1]].push(both);
        }
        for group in groups.iter().filter(|group| !group.is_empty()) {
            let formulas: Vec<&Both> = group.iter().collect();
            let verdicts = compared(&nusmv, &model, &formulas);
            let mut whole = model.smv.clone();
            for (formula, (ours, theirs)) in group.iter().zip(&verdicts) {
                assert_eq!(
                    ours, theirs,
                    "{}\n{}\n{}",
                    formula.asm, model.asm, model.smv
                );
                held += u32::from(*ours);
                violated += u32::from(!ours);
                writeln!(whole, "CTLSPEC {}", formula.smv).unwrap();
            }
            let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("whole.smv");
            std::fs::write(&path, &whole).unwrap();
            let of_whole = self::verdicts(&nusmv, &path).into_iter().zip(&verdicts);
            different += of_whole.filter(|(whole, (ours, _))| whole != ours).count();
        }
    }
    assert!(
        held > 50 && violated > 50 && different > 0,
        "{held} {violated} {different}"
    );
    println!(
        "{held} hold, {violated} are violated, {different} differ if all inputs are part of the state"
    );
}
