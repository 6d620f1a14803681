// a module passes on what it exports of a missing file
asm import_not_found_beyond_a_module
import StandardLibrary
import crew
import fleet                                 //~ W003
signature:
  controlled n: Integer
definitions:
  main rule r_Main = par
    n := captain
    n := speed                               //~ A001
  endpar
//--- crew.asm
module crew
import people                                //~ A010
export captain
signature:
definitions:
//--- fleet.asm
module fleet
import ships                                 //~ A010
signature:
  static size: Integer
definitions:
  function size = 3
