// what a module imports it exports again, if it exports everything
asm import_again
import StandardLibrary
import upper
signature:
definitions:
  main rule r_Main = r_set[3]
//= step 1: n := 3
//--- upper.asm
module upper
import lower
export *
signature:
definitions:
//--- lower.asm
module lower
import StandardLibrary
export *
signature:
  controlled n: Integer
definitions:
  rule r_set($n in Integer) = n := $n
