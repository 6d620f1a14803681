asm mismatch_number
import StandardLibrary
signature:
  controlled n: Natural
definitions:
  main rule r_Main = n := 3  //~ A007
