asm result_undeclared
import StandardLibrary
signature:
  controlled x: Integer
definitions:
  turbo rule r_two = result := 2
  main rule r_Main = x <- r_two()  //~ W022
