// where a domain has no end and the guard is `true`, `choose` draws: the first candidate is 0
asm choose_endless
import StandardLibrary
signature:
  controlled k: Integer
  controlled n: Natural
  controlled r: Real
  controlled b: Boolean
definitions:
  main rule r_Main = choose $i in Integer, $n in Natural, $r in Real, $b in Boolean with true do par
    k := $i
    n := $n
    r := $r
    b := $b
  endpar
//? step 1: choose 0, choose 0, choose 0, choose 0
//? step 2: choose 3, choose 7, choose 4503599627370496, choose 1
//? step 3: choose 4, choose 4294967295, choose 0, choose 1
//= step 1: b := false, k := 0, n := 0, r := 0.0
//= step 2: b := true, k := 2, n := 7, r := 0.5
//= step 3: b := true, k := -2, n := 4294967295, r := 0.0
