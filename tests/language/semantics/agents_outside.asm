// outside a program, `self` is undef
asm agents_outside
import StandardLibrary
signature:
  controlled x: Boolean
definitions:
  main rule r_Main = x := isUndef(self)
//= step 1: x := true
