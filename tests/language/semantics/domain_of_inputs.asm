// an input outside its domain stops the step that reads it
asm domain_of_inputs
import StandardLibrary
signature:
  domain Odd subsetof Integer
  monitored m: Seq(Odd)
  controlled x: Integer
definitions:
  domain Odd = {$x in {0 : 9} | $x mod 2 = 1 : $x}
  main rule r_Main = x := length(m)
//? step 1: m = [1]
//= step 1: x := 1
//? step 2: m = [undef]
//= step 2: x := 1
//? step 3: m = [4]
//= step 3: R022
