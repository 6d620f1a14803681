asm mismatch_number
import StandardLibrary
signature:
  controlled n: Natural
  controlled r: Real
definitions:
  main rule r_Main = par
    n := 3  //~ W025
    r := 3  //~ A007
  endpar
