// a subset of a product
asm domain_of_pairs
import StandardLibrary
signature:
  domain Point subsetof Prod(Integer, Integer)
  controlled at: Point
  controlled x: Integer
definitions:
  domain Point = {(0, 0), (1, 0)}
  main rule r_Main = par at := (1, 0)  x := first(at) endpar
default init s0:
  function at = (0, 0)
//= step 1: at := (1,0), x := 0
//= step 2: at := (1,0), x := 1
