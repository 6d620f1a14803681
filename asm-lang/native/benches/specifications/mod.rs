//! Specifications of any size, to measure cost against size.

use std::fmt::Write;

/// The rule of each agent.
const WORK: &str = "
  rule r_work($a in Agent_) = par
    count($a) := (count($a) * 3 + 1) mod 1009
    if count($a) > 500 then load($a) := load($a) + 1 else load($a) := 0 endif
  endpar
";

/// Agents that are numbers of an interval.
pub fn numbered(count: u64) -> String {
    format!(
        "asm scaling
import StandardLibrary
signature:
  domain Agent_ subsetof Integer
  controlled count: Agent_ -> Integer
  controlled load: Agent_ -> Integer
definitions:
  domain Agent_ = {{1 : {count}}}
{WORK}
  main rule r_Main = forall $a in Agent_ with true do r_work[$a]
default init s0:
  function count($a in Agent_) = $a mod 1009
  function load($a in Agent_) = 0
"
    )
}

/// Agents with a program: declared, or created in the first step.
pub fn agents(count: u64, is_created: bool) -> String {
    let mut declared = String::new();
    let mut create = String::new();
    if is_created {
        create = format!(
            "if begun then forall $a in Worker with true do program($a)
    else par begun := true forall $n in {{1 : {count}}} do extend Worker with $w do skip endpar endif"
        );
    } else {
        for agent in 0..count {
            let _ = writeln!(declared, "  static w{agent}: Worker");
        }
        create.push_str("forall $a in Worker with true do program($a)");
    }
    let work = WORK
        .replace("r_work($a in Agent_)", "r_work")
        .replace("$a", "self");
    format!(
        "asm scaling
import StandardLibrary
signature:
  domain Worker subsetof Agent
  controlled begun: Boolean
  controlled count: Worker -> Integer
  controlled load: Worker -> Integer
{declared}
definitions:
{work}
  main rule r_Main = {create}
default init s0:
  function begun = false
  function count($a in Worker) = 1
  function load($a in Worker) = 0
  agent Worker: r_work[]
"
    )
}

/// Agents whose initial values are listed in a map.
pub fn listed(count: u64) -> String {
    let mut declared = String::new();
    let mut pairs = Vec::new();
    for agent in 0..count {
        let _ = writeln!(declared, "  static w{agent}: Worker");
        pairs.push(format!("w{agent} -> {}", agent * 7 % 1009));
    }
    format!(
        "asm scaling
import StandardLibrary
signature:
  abstract domain Worker
  controlled count: Worker -> Integer
{declared}
definitions:
  main rule r_Main = skip
default init s0:
  function count($w in Worker) = at({{{}}}, $w)
",
        pairs.join(", ")
    )
}

/// Each zone chooses one of the robots that go there.
pub fn chosen(robots: u64, zones: u64) -> String {
    format!(
        "asm scaling
import StandardLibrary
signature:
  domain Robot subsetof Integer
  domain Zone subsetof Integer
  controlled target: Robot -> Zone
  controlled picked: Zone -> Robot
  controlled shift: Integer
definitions:
  domain Robot = {{1 : {robots}}}
  domain Zone = {{0 : {last}}}
  main rule r_Main = par
    shift := (shift + 1) mod {zones}
    forall $z in Zone with true do
      choose $w in Robot with target($w) = $z do par
        picked($z) := $w
        target($w) := ($z + shift) mod {zones}
      endpar
  endpar
default init s0:
  function target($w in Robot) = $w mod {zones}
  function shift = 1
",
        last = zones - 1
    )
}
