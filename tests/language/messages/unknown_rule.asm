asm unknown_rule
import StandardLibrary
signature:
  controlled x: Integer
definitions:
  rule r_move = x := 1
  main rule r_Main = r_mvoe[]  //~ A003
