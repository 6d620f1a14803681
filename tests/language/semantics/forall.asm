// all updates at once, a range may depend on the variable before it
asm forall
import StandardLibrary
signature:
  domain Small subsetof Integer
  controlled f: Prod(Small, Small) -> Integer
definitions:
  domain Small = {1 : 3}
  main rule r_Main = forall $a in Small, $b in {1 : $a} with $a + $b > 4 do f($a, $b) := $a * $b
//= step 1: f(3,2) := 6, f(3,3) := 9
