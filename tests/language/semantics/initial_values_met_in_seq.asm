// and those that a sequence meets
asm initial_values_met_in_seq
import StandardLibrary
signature:
  controlled a: Integer
  controlled f: Integer -> Integer
  controlled x: Integer
definitions:
  main rule r_Main = seq a := 5  x := f(1000000) endseq
default init s0:
  function a = 1
  function f($n in Integer) = $n + a
//= step 1: a := 5, x := 1000001
