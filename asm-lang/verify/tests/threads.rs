//! Exploration by several threads: everything that is found is the same.

use crate::grounded::specifications;
use crate::naive::Random;
use crate::open;
use asmotion_lang::{MemoryFiles, Specification};
use asmotion_verify::{Limits, Options, Refusal, Verification, verify};
use std::fmt::Write as _;
use std::path::Path;

/// Numbers of threads that are compared with one thread.
const THREADS: [usize; 3] = [2, 3, 5];

/// Everything that a verification says, apart from the machines.
pub fn everything(result: &Result<Verification, Refusal>) -> String {
    match result {
        Ok(found) => {
            let mut text = format!(
                "{} {} {} {} {:?} {} {:?} {:?} {:?}\n",
                found.states,
                found.transitions,
                found.excluded,
                found.depth,
                found.incomplete,
                found.is_grounded,
                found.growing,
                found.advice,
                found.has_advice_on_steps,
            );
            for property in &found.properties {
                writeln!(text, "{property:#?}").unwrap();
            }
            text
        }
        Err(refusal) => format!("{:#?}", refusal.report.diagnostics),
    }
}

/// Verifies with one thread and with several; returns the result.
pub fn compared(
    text: &str,
    specification: impl Fn() -> Specification,
    options: &Options,
) -> Option<Verification> {
    let with = |threads| {
        let options = Options {
            threads,
            ..options.clone()
        };
        verify(specification(), &options, &mut |_| true)
    };
    let one = with(1);
    let expected = everything(&one);
    for threads in THREADS {
        let found = with(threads);
        assert_eq!(everything(&found), expected, "{threads} threads: {text}");
        if let (Ok(found), Ok(one)) = (&found, &one) {
            assert_eq!(found.memory, one.memory, "{threads} threads: {text}");
        }
    }
    one.ok()
}

/// Two counters besides what the random rules do, so that there are enough states for several threads.
fn wide(text: &str) -> String {
    let rule = text.find("main rule r_Main = ").unwrap();
    let init = text.find("default init").unwrap();
    let own = &text[rule + "main rule r_Main = ".len()..init];
    let main = "main rule r_Main = par r_Own[] choose $x in Wide with true do if $x = 0 then a := (a + 1) mod 40 else if $x = 1 then b := (b + 1) mod 40 endif endif endpar\n";
    let text = format!(
        "{}rule r_Own = {own}  {main}{}",
        &text[..rule],
        &text[init..]
    );
    let text = text.replace(
        "definitions:\n",
        "  domain Wide subsetof Integer\n  domain Day subsetof Integer\n  controlled a: Day\n  controlled b: Day\ndefinitions:\n  domain Wide = {0 : 2}\n  domain Day = {0 : 39}\n",
    );
    format!("{text}  function a = 0\n  function b = 0\n")
}

/// Options of several kinds, in turn.
fn options(index: usize) -> Options {
    let properties: &[&str] = match index % 3 {
        0 => &["ag(p or n < 3)", "ef(q and n = 2)", "n = m(2) implies p"],
        1 => &["ag(ef(m(1) = 2))", "af(q)", "ag(left implies ax(p or q))"],
        _ => &[],
    };
    Options {
        properties: properties.iter().map(|it| (*it).to_owned()).collect(),
        limits: Limits {
            states: (index % 5 == 3).then_some(700),
            depth: (index % 7 == 4).then_some(9),
            ..Limits::default()
        },
        assumptions: (index % 4 == 2)
            .then(|| "not (left and right)".to_owned())
            .into_iter()
            .collect(),
        without_grounding: index % 2 == 1,
        ..Options::default()
    }
}

#[test]
fn random_specifications_have_equal_results() {
    let mut random = Random(0x51f1_5ead_0a11_0bad);
    let (mut shared, mut grounded, mut limited) = (0, 0, 0);
    for index in 0..240 {
        let text = wide(&random.specification());
        let text = text.replace(
            "import StandardLibrary",
            "import StandardLibrary\nimport CTLLibrary",
        );
        let Some(found) = compared(&text, || open(&text), &options(index)) else {
            continue;
        };
        shared += u32::from(found.states > 1100);
        grounded += u32::from(found.is_grounded);
        limited += u32::from(found.incomplete.is_some());
    }
    assert!(
        shared > 40 && grounded > 30 && limited > 20,
        "{shared} {grounded} {limited}"
    );
}

/// Compares the specifications of a folder that can be opened; returns how many there are.
fn compare_folder(folder: &Path, states: u64) -> u32 {
    let mut paths = Vec::new();
    specifications(folder, &mut paths);
    let mut opened = 0;
    for path in paths {
        let mut files = MemoryFiles::new();
        for neighbour in std::fs::read_dir(path.parent().unwrap()).unwrap().flatten() {
            let neighbour = neighbour.path();
            let name = neighbour.file_name().unwrap().to_str().unwrap();
            if name.ends_with(".asm") {
                files.add(name, &*std::fs::read_to_string(&neighbour).unwrap());
            }
        }
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        let specification = || asmotion_lang::open(&name, &files);
        if !specification().is_ok_and(|it| it.model.main.is_some()) {
            continue;
        }
        opened += 1;
        for without_grounding in [false, true] {
            let options = Options {
                limits: Limits {
                    states: Some(if without_grounding {
                        states / 4
                    } else {
                        states
                    }),
                    ..Limits::default()
                },
                without_grounding,
                ..Options::default()
            };
            compared(
                path.to_str().unwrap(),
                || specification().unwrap(),
                &options,
            );
        }
    }
    opened
}

#[test]
fn the_specifications_of_the_repository_have_equal_results() {
    let specs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../specs");
    assert!(compare_folder(&specs, 3_000) > 10);
}

#[test]
fn the_shared_models_have_equal_results() {
    for folder in ["specs", "verify"] {
        if let Some(folder) = asmotion_skip::shared(folder) {
            assert!(compare_folder(&folder, 12_000) > 2);
        }
    }
}
