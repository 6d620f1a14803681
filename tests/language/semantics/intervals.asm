// bounds are terms; the last one is included when the step reaches it
asm intervals
import StandardLibrary
signature:
  controlled s: Powerset(Integer)
  controlled q: Seq(Integer)
  controlled r: Powerset(Real)
  controlled n: Integer
  controlled e: Powerset(Integer)
  controlled z: Powerset(Real)
  controlled step: Real
definitions:
  main rule r_Main = par s := {1 : n}  q := [1 : 6, 2]  r := {0.0 : 0.3, 0.1}  e := {2 : 1}  z := {1.0 : 2.0, step} endpar
default init s0:
  function n = 3
  function step = 0.0
//= step 1: e := {}, q := [1,3,5], r := {0.0,0.1,0.2,0.3}, s := {1,2,3}, z := {}
