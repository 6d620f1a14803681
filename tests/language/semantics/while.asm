// runs as long as the guard holds, on the state it makes
asm while
import StandardLibrary
signature:
  controlled n: Integer
  controlled sum: Integer
definitions:
  main rule r_Main = while n > 0 do par sum := sum + n  n := n - 1 endpar
default init s0:
  function n = 3
  function sum = 0
//= step 1: n := 0, sum := 6
