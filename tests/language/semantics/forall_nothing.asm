// an empty range: nothing
asm forall_nothing
import StandardLibrary
signature:
  controlled x: Integer
  controlled s: Powerset(Integer)
definitions:
  main rule r_Main = forall $a in s do x := $a
default init s0:
  function s = {}
//= step 1: nothing
