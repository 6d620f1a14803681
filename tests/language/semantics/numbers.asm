// Integer, Natural and Real are apart; functions lead from one to the other
asm numbers
import StandardLibrary
signature:
  controlled n: Natural
  controlled r: Real
  controlled q: Real
  controlled k: Integer
definitions:
  main rule r_Main = par n := iton(3)  r := itor(1) + 0.5  q := 7 / 2  k := rtoi(-1.5) endpar
//= step 1: k := -1, n := 3, q := 3.5, r := 1.5
