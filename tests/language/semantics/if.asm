// then, else, and nothing
asm if
import StandardLibrary
signature:
  controlled x: Integer
  controlled y: Integer
  controlled b: Boolean
definitions:
  main rule r_Main = par
    if b then x := 1 else x := 2 endif
    if b then y := 1 endif
    b := not b
  endpar
default init s0:
  function b = true
//= step 1: b := false, x := 1, y := 1
//= step 2: b := true, x := 2
