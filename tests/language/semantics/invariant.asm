// holds in every state
asm invariant
import StandardLibrary
signature:
  controlled n: Integer
definitions:
  invariant inv_small over n: n < 3
  main rule r_Main = n := n + 1
default init s0:
  function n = 0
//= step 1: n := 1
//= step 2: n := 2
//= step 3: R014
