// a value outside a concrete codomain stops the step
asm domain_checked
import StandardLibrary
signature:
  domain Small subsetof Integer
  controlled x: Small
definitions:
  domain Small = {1 : 3}
  main rule r_Main = x := x + 1
default init s0:
  function x = 2
//= step 1: x := 3
//= step 2: R002
