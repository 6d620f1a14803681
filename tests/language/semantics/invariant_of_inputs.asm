// on inputs it is an assumption: the step fails before it writes
asm invariant_of_inputs
import StandardLibrary
signature:
  monitored m: Integer
  controlled n: Integer
definitions:
  invariant inv_positive over m: m > 0
  main rule r_Main = n := m
//? step 1: m = 1
//= step 1: n := 1
//? step 2: m = 0
//= step 2: R014
