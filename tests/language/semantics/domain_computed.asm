// or computed
asm domain_computed
import StandardLibrary
signature:
  static limit: Integer
  domain Small subsetof Integer
  controlled x: Integer
definitions:
  function limit = 4
  domain Small = {$i in {1 : limit} | $i mod 2 = 0 : $i}
  main rule r_Main = x := size(Small)
//= step 1: x := 2
