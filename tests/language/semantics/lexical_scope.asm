// a variable lives in its rule alone; an inner one hides an outer one
asm lexical_scope
import StandardLibrary
signature:
  controlled f: Integer -> Integer
  controlled x: Integer
definitions:
  main rule r_Main = par
    forall $a in {1 : 2} do f($a) := 1
    forall $a in {3 : 4} do f($a) := 2
    let ($a = 1) in let ($a = $a + 1) in x := $a endlet endlet
  endpar
//= step 1: f(1) := 1, f(2) := 1, f(3) := 2, f(4) := 2, x := 2
