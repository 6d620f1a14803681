// its neighbours see the state before it
asm while_in_par
import StandardLibrary
signature:
  controlled n: Integer
  controlled m: Integer
definitions:
  main rule r_Main = par while n < 3 do n := n + 1  m := n endpar
default init s0:
  function n = 0
//= step 1: m := 0, n := 3
