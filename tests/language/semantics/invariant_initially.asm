// also in the initial state
asm invariant_initially
import StandardLibrary
signature:
  controlled n: Integer
definitions:
  invariant inv_small over n: n < 3
  main rule r_Main = n := n + 1
default init s0:
  function n = 3
//= step 0: R014
