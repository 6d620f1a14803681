asm no_result
import StandardLibrary
signature:
  controlled x: Integer
definitions:
  macro rule r_go = x := 1
  main rule r_Main = x <- r_go()  //~ A024
