asm invariant_undef
import StandardLibrary
signature:
  controlled n: Integer
definitions:
  invariant inv_small over n: n < 3  //~ R014
  main rule r_Main = n := 1
