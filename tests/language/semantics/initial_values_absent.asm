// what has no initial value is undef
asm initial_values_absent
import StandardLibrary
signature:
  controlled a: Integer
  controlled x: Boolean
definitions:
  main rule r_Main = x := isUndef(a)
//= step 1: x := true
