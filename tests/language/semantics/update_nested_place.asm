// a location may be the argument of a location
asm update_nested_place
import StandardLibrary
signature:
  controlled f: Integer -> Integer
definitions:
  main rule r_Main = f(f(1)) := 7
default init s0:
  function f($n in Integer) = $n + 1
//= step 1: f(2) := 7
