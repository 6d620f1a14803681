// pairs of reals, with arithmetic of their own
asm complex_numbers
import StandardLibrary
signature:
  controlled z: Complex
  controlled a: Real
  controlled b: Real
  controlled n: Real
  controlled zero: Boolean
definitions:
  main rule r_Main = par
    z := (1.0+i2.0) * (3.0-i1.0)
    a := re(2.5+i4.0)
    b := im(2.5+i4.0)
    n := re(norm(3.0+i4.0))
    zero := iszero((1.0+i1.0) - (1.0+i1.0))
  endpar
//= step 1: a := 2.5, b := 4.0, n := 5.0, z := 5.0+i5.0, zero := true
