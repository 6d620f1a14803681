// reads the old state, writes the new one
asm update
import StandardLibrary
signature:
  controlled x: Integer
definitions:
  main rule r_Main = x := x + 1
default init s0:
  function x = 1
//= step 1: x := 2
//= step 2: x := 3
