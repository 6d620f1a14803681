// temporal properties and fairness constraints are parsed and typed, but no run verifies them
asm unverified
import StandardLibrary
import CTLLibrary
import LTLLibrary
signature:
  controlled n: Integer
definitions:
  CTLSPEC ag(n < 3)  //~ W031
  LTLSPEC g(n < 3)
  main rule r_Main = if n < 3 then n := n + 1 endif
default init s0:
  function n = 0
