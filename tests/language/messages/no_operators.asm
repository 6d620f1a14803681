asm no_operators

signature:
  controlled x: Integer
definitions:
  main rule r_Main = x := x + 1  //~ A036
