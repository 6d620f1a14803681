// equality is defined everywhere
asm undef_equals
import StandardLibrary
signature:
  controlled u: Integer
  controlled v: Integer
  controlled a: Boolean
  controlled b: Boolean
  controlled c: Boolean
  controlled d: Boolean
definitions:
  main rule r_Main = par a := u = v  b := u = 1  c := u != 1  d := isUndef(u) and isDef({1}) endpar
//= step 1: a := true, b := false, c := true, d := true
