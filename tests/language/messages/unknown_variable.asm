asm unknown_variable
import StandardLibrary
signature:
  controlled x: Integer
definitions:
  main rule r_Main = let ($target = 1) in x := $taget endlet  //~ A002
