// what the environment shares is known with the inputs of the first step, and checked before its rules
asm invariant_initially_shared
import StandardLibrary
signature:
  shared s: Integer
  monitored m: Boolean
  controlled n: Integer
definitions:
  invariant inv_positive over s: s > 0
  main rule r_Main = if m then n := 1 endif
//? step 1: s = 0, m = undef
//= step 1: R014
