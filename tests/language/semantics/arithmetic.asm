// operators bind as in the reference: `not` tighter than comparisons, sign tighter than power
asm arithmetic
import StandardLibrary
signature:
  controlled x: Integer
  controlled y: Real
  controlled z: Boolean
  controlled w: Integer
definitions:
  main rule r_Main = par
    x := 2 + 3 * 4 - 10 mod 4
    y := -2.0 ^ 2.0
    z := (not true) = false
    w := -7 mod 3
  endpar
//= step 1: w := -1, x := 12, y := 4.0, z := true
