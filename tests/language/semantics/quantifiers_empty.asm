// over nothing, all hold and none exists
asm quantifiers_empty
import StandardLibrary
signature:
  controlled a: Boolean
  controlled b: Boolean
  controlled s: Powerset(Integer)
definitions:
  main rule r_Main = par a := (forall $n in s with $n > 0)  b := (exists $n in s with $n > 0) endpar
default init s0:
  function s = {}
//= step 1: a := true, b := false
