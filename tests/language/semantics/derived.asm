// a derived function follows the state
asm derived
import StandardLibrary
signature:
  controlled n: Integer
  derived twice: Integer
  controlled x: Integer
definitions:
  function twice = 2 * n
  main rule r_Main = par x := twice  n := n + 1 endpar
default init s0:
  function n = 1
//= step 1: n := 2, x := 2
//= step 2: n := 3, x := 4
