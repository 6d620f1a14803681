// a tuple may stand for all arguments
asm tuple_as_arguments
import StandardLibrary
signature:
  controlled f: Prod(Integer, Integer) -> Integer
  controlled p: Prod(Integer, Integer)
  controlled x: Integer
definitions:
  main rule r_Main = par f(p) := 5  x := f(p) endpar
default init s0:
  function p = (1, 2)
  function f($a in Integer, $b in Integer) = 0
//= step 1: f(1,2) := 5, x := 0
//= step 2: f(1,2) := 5, x := 5
