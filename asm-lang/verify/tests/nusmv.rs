//! Verdicts of NuSMV on translations of specifications that were written by hand.

use crate::naive::Random;
use asmotion_lang::MemoryFiles;
use asmotion_verify::{Options, verify};
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
