// of an imported machine, the main rule and the initial state stay at home
asm import_of_a_machine
import StandardLibrary
import counter
signature:
definitions:
  main rule r_Main = par r_step[]  seen := n endpar
//= step 1: n := undef, seen := undef
//--- counter.asm
asm counter
import StandardLibrary
export *
signature:
  controlled n: Integer
  controlled seen: Integer
definitions:
  rule r_step = n := n + 1
  main rule r_Main = n := 100
default init s0:
  function n = 0
