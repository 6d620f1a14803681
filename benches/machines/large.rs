//! Measures reading and checking of a large, generated specification.

use asmotion_lang::MemoryFiles;
use std::fmt::Write;
use std::time::Instant;

/// Minimum number of lines.
const LINES: usize = 1_000;

/// Number of times it is read.
const TURNS: usize = 50;

/// A coordinator of many stations, each with a mode, a counter and a rule.
fn text() -> String {
    let mut domains = String::new();
    let mut signature = String::new();
    let mut definitions = String::new();
    let mut calls = String::new();
    let mut initial = String::new();
    let mut station = 0;
    loop {
        let _ = writeln!(
            domains,
            "  enum domain Mode{station} = {{IDLE_{station} | BUSY_{station} | BROKEN_{station}}}"
        );
        let _ = write!(
            signature,
            "
  // station {station}
  dynamic controlled mode{station}: Mode{station}
  dynamic controlled load{station}: Slot -> Integer
  dynamic monitored request{station}: Boolean
  derived full{station}: Boolean
"
        );
        let _ = write!(
            definitions,
            "
  function full{station} = (forall $s in Slot with load{station}($s) > 0 and load{station}($s) < 100)

  /* what the station does with a request */
  rule r_station_{station} =
    switch mode{station}
      case IDLE_{station}:
        if request{station} and not full{station} then
          par
            mode{station} := BUSY_{station}
            choose $s in Slot with load{station}($s) = 0 do
              load{station}($s) := 1 + {station}
          endpar
        endif
      case BUSY_{station}:
        let ($n = load{station}(0) + load{station}(1) * 2) in
          if $n > 50 or $n mod 7 = 3 then
            mode{station} := BROKEN_{station}
          else
            forall $s in Slot with load{station}($s) != 0 do
              load{station}($s) := (load{station}($s) + $n) mod 101
          endif
        endlet
      otherwise
        if (exist $s in Slot with load{station}($s) > 90) then
          mode{station} := IDLE_{station}
        endif
    endswitch
"
        );
        let _ = writeln!(calls, "      r_station_{station}[]");
        let _ = write!(
            initial,
            "
  function mode{station} = IDLE_{station}
  function load{station}($s in Slot) = if $s = 0 then 1 else 0 endif
"
        );
        station += 1;
        let text = format!(
            "asm large
import StandardLibrary

signature:
  domain Slot subsetof Integer
{domains}{signature}
definitions:
  domain Slot = {{0 : 9}}
{definitions}
  main rule r_Main =
    par
{calls}    endpar

default init s0:
{initial}"
        );
        if text.lines().count() >= LINES {
            return text;
        }
    }
}

/// Prints the minimum and the median time of reading and checking, and of building the program.
pub fn print() {
    let text = text();
    let mut files = MemoryFiles::new();
    files.add("large.asm", text.as_str());
    let mut checked = Vec::new();
    let mut opened = Vec::new();
    for _ in 0..TURNS {
        let started = Instant::now();
        let specification =
            asmotion_lang::open("large.asm", &files).unwrap_or_else(|failure| panic!("{failure}"));
        opened.push(started.elapsed());
        drop(specification);
        let started = Instant::now();
        let mut sources = asmotion_lang::Sources::new();
        let mut loaded = asmotion_lang::hir::load("large.asm", &files, &mut sources);
        let (model, found) = asmotion_lang::hir::analyse(&mut loaded, &sources);
        checked.push(started.elapsed());
        assert!(model.is_some() && !found.has_errors());
    }
    println!();
    println!(
        "| {} lines | least, ms | median, ms |",
        text.lines().count()
    );
    println!("|---|---|---|");
    for (what, mut times) in [("parse and check", checked), ("open", opened)] {
        times.sort_unstable();
        let milliseconds = |at: usize| times[at].as_secs_f64() * 1e3;
        let (least, median) = (milliseconds(0), milliseconds(TURNS / 2));
        println!("| {what} | {least:.1} | {median:.1} |");
    }
}
