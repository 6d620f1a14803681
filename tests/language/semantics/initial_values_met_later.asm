// also those of locations that no step met before
asm initial_values_met_later
import StandardLibrary
signature:
  controlled a: Integer
  controlled f: Integer -> Integer
  controlled x: Integer
definitions:
  main rule r_Main = if a = 1 then a := 5 else x := f(1000000) endif
default init s0:
  function a = 1
  function f($n in Integer) = $n + a
//= step 1: a := 5
//= step 2: x := 1000001
