// the arguments of a location are terms of the same state
asm update_at_computed_place
import StandardLibrary
signature:
  controlled f: Integer -> Integer
  controlled n: Integer
definitions:
  main rule r_Main = par f(n + 1) := n  n := n + 1 endpar
default init s0:
  function n = 0
//= step 1: f(1) := 0, n := 1
//= step 2: f(2) := 1, n := 2
