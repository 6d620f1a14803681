// what cannot change the answer is not evaluated
asm logic_does_not_look_further
import StandardLibrary
signature:
  controlled a: Boolean
  controlled s: Seq(Integer)
definitions:
  main rule r_Main = a := not isEmpty(s) and first(s) > 0
default init s0:
  function s = []
//= step 1: a := false
