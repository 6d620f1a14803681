// a location outside the domain of its function is undef, and cannot be written
asm domain_of_arguments
import StandardLibrary
signature:
  domain Cell subsetof Integer
  domain Even subsetof Integer
  controlled f: Cell -> Integer
  controlled g: Prod(Even, Integer) -> Integer
  controlled x: Integer
definitions:
  domain Cell = {1 : 3}
  domain Even = {$x in {0 : 9} | $x mod 2 = 0 : $x}
  main rule r_Main = par
    if isUndef(f(x)) then f(x) := x endif
    g(2 * x, 100) := x
    x := x + 1
  endpar
default init s0:
  function x = 2
//= step 1: f(2) := 2, g(4,100) := 2, x := 3
//= step 2: f(3) := 3, g(6,100) := 3, x := 4
//= step 3: R023
