asm mismatch_number
import StandardLibrary
signature:
  controlled n: Natural
  controlled r: Real
  controlled s: Powerset(Real)
  static half: Prod(Real, Natural) -> Real
definitions:
  function half($x in Real, $n in Natural) = $x
  main rule r_Main = par
    n := 3  //~ W025
    r := 3  //~ A007
    r := -3  //~ A007
    r := half(3, 4)  //~ A006
    s := {1, 2.5}  //~ A019
    r := if r > 1.0 then 0.5 else 1 endif  //~ A019
  endpar
