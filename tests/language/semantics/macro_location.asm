// a parameter may stand for a location
asm macro_location
import StandardLibrary
signature:
  controlled x: Integer
  controlled f: Integer -> Integer
definitions:
  rule r_inc($l in Integer) = $l := $l + 1
  main rule r_Main = par r_inc[x]  r_inc[f(2)] endpar
default init s0:
  function x = 10
  function f($n in Integer) = $n * 10
//= step 1: f(2) := 21, x := 11
