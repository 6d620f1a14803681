// stops when its body changes nothing
asm while_idle
import StandardLibrary
signature:
  controlled n: Integer
definitions:
  main rule r_Main = while true do if n < 3 then n := n + 1 endif
default init s0:
  function n = 0
//= step 1: n := 3
//= step 2: nothing
