//! Compares with the reference implementation: its verdicts on the scenarios of its whole corpus.
//!
//! The verdicts are in `../shared/conformance`, the corpus (a checkout of asmeta/asmeta) at the path in the environment
//! variable `ASMETA_CORPUS`. Without them, the test prints a notice and passes.

use asmotion::DiskLoader;
use asmotion_lang::scenario::{ScenarioSettings, test};
use asmotion_lang::simulate::scenario::Verdict;
use rayon::prelude::*;

/// Scenarios with different verdicts, by the end of their paths, with the reason that ours is right.
const DIFFERENT: &[(&str, &str)] = &[
    ("tutorial_FM26/S3_InvariantViolation", CHANCE),
    ("tutorial_FM26/S8_RandomScenario", CHANCE),
    ("nfm25/scenario_ground_flaky", CHANCE),
    ("coffee_vending_machine/scenario_pickchooseone2", CHANCE),
    ("lift/lift1", ENDLESS),
    ("validation/scenario1_fromT0stepUntil", ENDLESS),
    (
        "example/block_w4",
        "it runs a block of a scenario that does not exist",
    ),
    ("example/block_w5", "it runs a block that does not exist"),
    (
        "scenariosfortest/emptyScenario",
        "its specification does not exist",
    ),
    (
        "choose_integer/scenario_out_of_domain",
        "what is picked outside the range is not a candidate, and no fault",
    ),
];

const CHANCE: &str = "what is not picked is drawn otherwise";
const ENDLESS: &str = "its `step until` never ends";

/// Number of equal verdicts, of the 219 scenarios that the reference runs.
const AGREED: usize = 209;

#[test]
fn agrees_on_the_corpus() {
    let table = asmotion_skip::shared("conformance/avalla.tsv");
    let (Some(corpus), Some(table)) = (asmotion_skip::corpus(), table) else {
        return;
    };
    let table = std::fs::read_to_string(table).unwrap();
    let mut rows = table.lines().map(|row| row.split('\t').collect::<Vec<_>>());
    let head = rows.next().unwrap();
    let column = |name: &str| head.iter().position(|known| *known == name).unwrap();
    let (path, verdict) = (column("path"), column("verdict"));
    let reference: Vec<(String, String)> = rows
        .map(|row| (row[path].to_owned(), row[verdict].to_owned()))
        .collect();
    let compared: Vec<(String, bool)> = reference
        .into_par_iter()
        .filter_map(|(path, verdict)| {
            let expected = expected_verdict(&verdict)?;
            let ours = test(
                &corpus.join(&path).to_string_lossy(),
                &DiskLoader,
                &ScenarioSettings::default(),
            );
            let agreed = ours.is_ok_and(|ours| ours.outcome.verdict == expected);
            Some((path, agreed))
        })
        .collect();
    let agreed = compared.iter().filter(|(_, agreed)| *agreed).count();
    println!("{} scenarios, {agreed} verdicts agree", compared.len());
    let unexplained: Vec<&String> = compared
        .iter()
        .filter(|(path, agreed)| !agreed && !is_explained(path))
        .map(|(path, _)| path)
        .collect();
    assert_eq!(unexplained, Vec::<&String>::new());
    assert!(agreed >= AGREED, "{agreed}");
}

/// The reference's verdict, if it has one.
fn expected_verdict(verdict: &str) -> Option<Verdict> {
    match verdict.split(':').next()? {
        "PASS" => Some(Verdict::Pass),
        "FAIL" => Some(Verdict::Fail),
        "FAIL_INV" => Some(Verdict::Invariant),
        "EXC" => Some(Verdict::Fault),
        // a scenario that cannot be loaded, translated or parsed
        _ => None,
    }
}

fn is_explained(path: &str) -> bool {
    let path = path.strip_suffix(".avalla").unwrap_or(path);
    DIFFERENT.iter().any(|(end, _)| path.ends_with(end))
}
