//! A specification may have several initial states; the default one is used unless another is
//! requested.

use asmotion_lang::{MemoryFiles, ReadOptions};

const TEXT: &str = "asm several
import StandardLibrary
signature:
  controlled x: Integer
definitions:
  main rule r_Main = x := x + 1
init low:
  function x = 1
default init middle:
  function x = 5
init high:
  function x = 9
";

fn begins_with(initial: Option<&str>) -> Result<String, String> {
    let mut files = MemoryFiles::new();
    files.add("several.asm", TEXT);
    let options = ReadOptions {
        compatible: false,
        initial: initial.map(str::to_owned),
    };
    let specification = asmotion_lang::open_with("several.asm", &files, &options)
        .map_err(|failure| failure.report.diagnostics[0].message.clone())?;
    let machine = specification
        .machine()
        .map_err(|fault| format!("{fault:?}"))?;
    let x = specification.function("x", 0).ok_or("no x")?;
    let slot = machine
        .state()
        .slot(machine.program(), x, &[])
        .ok_or("no slot")?;
    let value = machine.state().get(slot);
    Ok(value.show(&machine.naming()).to_string())
}

#[test]
fn the_default_one_counts() {
    assert_eq!(begins_with(None), Ok("5".to_owned()));
}

#[test]
fn another_one_counts_where_it_is_asked_for() {
    assert_eq!(begins_with(Some("low")), Ok("1".to_owned()));
    assert_eq!(begins_with(Some("high")), Ok("9".to_owned()));
}

#[test]
fn one_that_is_not_there_is_missed() {
    let missed = "no initial state is called `lower`";
    assert_eq!(begins_with(Some("lower")), Err(missed.to_owned()));
}
