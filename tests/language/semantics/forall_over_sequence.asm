// a sequence is a range as well
asm forall_over_sequence
import StandardLibrary
signature:
  controlled f: Integer -> Integer
definitions:
  main rule r_Main = forall $a in [3, 1, 3] do f($a) := $a
//= step 1: f(1) := 1, f(3) := 3
