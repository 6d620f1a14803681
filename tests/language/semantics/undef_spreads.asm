// a function of undef is undef
asm undef_spreads
import StandardLibrary
signature:
  controlled u: Integer
  controlled a: Integer
  controlled b: Boolean
  controlled c: Integer
definitions:
  main rule r_Main = par a := u + 1  b := u > 1  c := size({1, 2}) endpar
//= step 1: a := undef, b := undef, c := 2
