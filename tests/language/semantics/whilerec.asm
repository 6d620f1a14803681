// `whilerec` repeats its rule until the guard fails, even where it changes nothing
asm whilerec
import StandardLibrary
signature:
  controlled n: Integer
definitions:
  main rule r_Main = whilerec n < 3 do n := n + 1
default init s0:
  function n = 0
//= step 1: n := 3
//= step 2: nothing
