// all rules see the same state, so two locations swap
asm par
import StandardLibrary
signature:
  controlled a: Integer
  controlled b: Integer
definitions:
  main rule r_Main = par a := b  b := a endpar
default init s0:
  function a = 1
  function b = 2
//= step 1: a := 2, b := 1
//= step 2: a := 1, b := 2
