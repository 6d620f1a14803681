asm writes_variable
import StandardLibrary
signature:
  controlled x: Integer
definitions:
  main rule r_Main = let ($a = 1) in $a := 2 endlet  //~ W020
