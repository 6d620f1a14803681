// for all, for some, for exactly one
asm quantifiers
import StandardLibrary
signature:
  controlled a: Boolean
  controlled b: Boolean
  controlled c: Boolean
  controlled d: Boolean
definitions:
  main rule r_Main = par
    a := (forall $n in {1 : 3} with $n > 0)
    b := (exists $n in {1 : 3}, $m in {1 : 3} with $n + $m = 6)
    c := (exists unique $n in {1 : 3} with $n > 2)
    d := (exists unique $n in {1 : 3} with $n > 1)
  endpar
//= step 1: a := true, b := true, c := true, d := false
