// all initial values speak of the initial state, in whatever order they stand
asm initial_values
import StandardLibrary
signature:
  controlled a: Integer
  controlled b: Integer
  controlled x: Integer
definitions:
  main rule r_Main = par b := 9  x := a endpar
default init s0:
  function a = b + 1
  function b = 2
//= step 1: b := 9, x := 3
//= step 2: b := 9, x := 3
