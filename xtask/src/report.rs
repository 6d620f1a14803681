//! The table of `cargo xtask house`.

use crate::arms::{self, MatchCount};
use crate::checkout::{Checkout, CheckoutError};
use crate::doc_blocks::{self, DocCount};
use crate::functions::{self, percentile};
use crate::history::{self, Addition};
use crate::lines::{self, LineCount};
use crate::module_laws::LARGEST_CYCLE;
use crate::modules::{self, CrateModules};
use crate::table::Rows;
use crate::type_names::{self, NameReuse};
use crate::{build_cost, graph, new_component};
use std::collections::BTreeMap;
use std::path::Path;

/// Keys of the composite dialect whose occurrences in the code are counted.
const SAMPLE_KEYS: &[&str] = &["on_stale", "unavailable", "deadline_ms"];

/// Measures a revision, or the working tree if `revision` is `None`.
///
/// # Errors
/// The sources cannot be read, or `git` fails.
pub fn rows(root: &Path, revision: Option<&str>) -> Result<Rows, CheckoutError> {
    let checkout = match revision {
        Some(revision) => Checkout::revision(root, revision)?,
        None => Checkout::working_tree(root)?,
    };
    let mut rows = Rows::new();
    line_rows(&checkout, &mut rows);
    function_rows(&checkout, &mut rows);
    arm_rows(&arms::count(&checkout), &mut rows);
    module_rows(&modules::of(&checkout), &mut rows);
    name_rows(&checkout, &mut rows);
    doc_rows(&checkout, &mut rows);
    for key in SAMPLE_KEYS {
        let files = mentions(&checkout, key);
        rows.push((
            format!("files of code that spell the key `{key}`"),
            files.to_string(),
        ));
    }
    if let Ok(files) = new_component::plan(&checkout.root, "pan-tilt") {
        let new = files.iter().filter(|file| file.new).count();
        let value = format!("{} changed, {new} made", files.len() - new);
        rows.push((
            "files that `cargo xtask new-component` writes".to_owned(),
            value,
        ));
    }
    for addition in Addition::ALL {
        let commit = history::latest(root, revision.unwrap_or("HEAD"), addition)?;
        let value = commit.map_or("–".to_owned(), |commit| commit.to_string());
        rows.push((format!("files touched by a new {}", addition.name()), value));
    }
    rows.extend(build_cost::rows(&checkout.root));
    Ok(rows)
}

fn line_rows(checkout: &Checkout, rows: &mut Rows) {
    let mut wings: BTreeMap<&str, LineCount> = BTreeMap::new();
    let mut total = LineCount::default();
    for file in &checkout.files {
        let count = lines::count(file);
        *wings.entry(file.wing()).or_default() += count;
        total += count;
    }
    let show = |count: &LineCount| {
        let thousand = |lines: usize| format!("{:.1}k", lines as f64 / 1000.0);
        format!(
            "{} / {} / {}",
            thousand(count.code),
            thousand(count.tests),
            thousand(count.docs)
        )
    };
    for (wing, count) in &wings {
        rows.push((format!("`{wing}`: code / tests / docs"), show(count)));
    }
    rows.push(("all: code / tests / docs".to_owned(), show(&total)));
    rows.push(("lines of Rust".to_owned(), total.total().to_string()));
    let comments = 100.0 * total.comments as f64 / total.total().max(1) as f64;
    rows.push(("comment lines".to_owned(), format!("{comments:.1} %")));
}

fn function_rows(checkout: &Checkout, rows: &mut Rows) {
    let functions: Vec<_> = checkout.files.iter().flat_map(functions::lengths).collect();
    let mut all: Vec<usize> = functions.iter().map(|function| function.lines).collect();
    let product = functions.iter().filter(|function| !function.test);
    let mut product: Vec<usize> = product.map(|function| function.lines).collect();
    for (label, lengths) in [("with tests", &mut all), ("product", &mut product)] {
        lengths.sort_unstable();
        let at = |share| percentile(lengths, share);
        let max = lengths.last().copied().unwrap_or_default();
        let value = format!("{} / {} / {} / {max}", at(0.5), at(0.9), at(0.99));
        rows.push((
            format!("function length p50 / p90 / p99 / max, {label}"),
            value,
        ));
    }
    let long = product.iter().filter(|lines| **lines > 60).count();
    let share = 100.0 * long as f64 / product.len().max(1) as f64;
    rows.push((
        "functions over 60 lines, product".to_owned(),
        format!("{long} ({share:.1} %)"),
    ));
}

fn arm_rows(count: &MatchCount, rows: &mut Rows) {
    let value = format!("{} of {}", count.wildcards, count.matches);
    rows.push(("`_ =>` beside own variants".to_owned(), value));
}

fn module_rows(crates: &[CrateModules], rows: &mut Rows) {
    let (mut rooms, mut arrows, mut in_cycles, mut climbing) = (0, 0, 0, 0);
    let (mut large, mut largest, mut hub) = (0, (0, String::new()), 0);
    for modules in crates {
        let between = modules.room_arrows();
        rooms += modules.room_names().len();
        arrows += between.len();
        in_cycles += graph::cycles(&between).iter().map(Vec::len).sum::<usize>();
        climbing += graph::climbing(&between).len();
        hub += modules.hub_uses.len();
        for cycle in graph::cycles(&modules.arrows()) {
            large += usize::from(cycle.len() > LARGEST_CYCLE);
            if cycle.len() > largest.0 {
                largest = (cycle.len(), modules.name.clone());
            }
        }
    }
    let mut row = |label: &str, value: String| rows.push((label.to_owned(), value));
    row("crates", crates.len().to_string());
    row(
        "first-level modules in a cycle",
        format!("{in_cycles} of {rooms}"),
    );
    row(
        "arrows up between first-level modules",
        format!("{climbing} of {arrows}"),
    );
    row("file cycles of more than five files", large.to_string());
    row(
        "largest file cycle",
        format!("{} ({})", largest.0, largest.1),
    );
    row("uses of a name through `lib.rs`", hub.to_string());
}

fn name_rows(checkout: &Checkout, rows: &mut Rows) {
    let reuse = NameReuse::of(&type_names::definitions(checkout));
    let value = format!(
        "{} of {} ({:.1} %)",
        reuse.reused,
        reuse.names,
        reuse.percent()
    );
    rows.push(("type names with several meanings".to_owned(), value));
}

fn doc_rows(checkout: &Checkout, rows: &mut Rows) {
    let mut count = DocCount::default();
    for file in &checkout.files {
        doc_blocks::count(file, &mut count);
    }
    let share = |part: usize| {
        format!(
            "{part} ({:.1} %)",
            100.0 * part as f64 / count.blocks.max(1) as f64
        )
    };
    let mut row = |label: &str, value: String| rows.push((label.to_owned(), value));
    row("doc comments", count.blocks.to_string());
    row("doc comments of at most three words", share(count.short));
    row(
        "doc comments that begin with What, How, Whether, Where, Who",
        share(count.clauses),
    );
    row(
        "`# Errors` sections / public functions that return a `Result`",
        format!("{} / {}", count.errors, count.fallible),
    );
}

/// Returns the number of product files whose code contains a word.
fn mentions(checkout: &Checkout, word: &str) -> usize {
    let in_line = |line: &str| {
        let mut words = line.split(|letter: char| !letter.is_alphanumeric() && letter != '_');
        words.any(|it| it == word)
    };
    let in_file = checkout.files.iter().filter(|file| {
        let mut lines = file.text.lines().enumerate();
        lines.any(|(index, line)| {
            !line.trim_start().starts_with("//") && !file.is_test(index + 1) && in_line(line)
        })
    });
    in_file.count()
}
