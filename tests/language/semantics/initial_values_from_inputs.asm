// an initial value may depend on the first inputs
asm initial_values_from_inputs
import StandardLibrary
signature:
  monitored m: Integer
  controlled a: Integer
  controlled f: Integer -> Integer
  controlled x: Integer
definitions:
  main rule r_Main = par x := a + m  if a > 0 then a := f(7) endif endpar
default init s0:
  function a = m
  function f($n in Integer) = $n * m
//? step 1: m = 3
//= step 1: a := 21, x := 6
//? step 2: m = 100
//= step 2: a := 21, x := 121
