// an initial value outside a domain is run, and told
asm outside_initially
import StandardLibrary
signature:
  domain Floor subsetof Integer
  domain Cabin subsetof Integer
  domain Unknown subsetof Integer  //~ W004
  controlled at: Cabin -> Floor
  controlled calls: Seq(Prod(Floor, Boolean))
  controlled free: Unknown
  controlled limit: Integer
definitions:
  domain Cabin = {1 : 2}
  domain Floor = {$f in {0 : 9} | $f < limit : $f}
  main rule r_Main = skip
default init s0:
  function at($c in Cabin) = $c * 3  //~ W030
  function calls = [(1, true), (7, false)]  //~ W030
  function free = 1
  function limit = 6
