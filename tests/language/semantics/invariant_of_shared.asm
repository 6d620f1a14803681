// an invariant on what rules and the environment share holds in every state, the first one included
asm invariant_of_shared
import StandardLibrary
signature:
  shared s: Integer
definitions:
  invariant inv_positive over s: s > 0
  main rule r_Main = s := s - 1
//? step 1: s = 2
//= step 1: s := 1
