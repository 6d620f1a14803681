// the elements of a domain may be listed
asm domain_listed
import StandardLibrary
signature:
  domain Prime subsetof Integer
  controlled x: Integer
  controlled f: Prime -> Boolean
definitions:
  domain Prime = {2, 3, 5, 7}
  main rule r_Main = par x := size(Prime)  forall $p in Prime with $p > 3 do f($p) := true endpar
//= step 1: f(5) := true, f(7) := true, x := 4
