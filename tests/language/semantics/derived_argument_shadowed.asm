// a parameter is a variable of its own
asm derived_argument_shadowed
import StandardLibrary
signature:
  controlled x: Integer
  derived f: Integer -> Integer
  controlled n: Integer
definitions:
  function f($a in Integer) = let ($b = $a + n) in (if $b > 5 then $b else f($b) endif) endlet
  main rule r_Main = x := f(1)
default init s0:
  function n = 2
//= step 1: x := 7
