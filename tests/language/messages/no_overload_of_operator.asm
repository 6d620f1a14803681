asm no_overload_of_operator
import StandardLibrary
signature:
  controlled r: Real
definitions:
  main rule r_Main = r := r + 1  //~ A006
