asm not_a_rule
import StandardLibrary
signature:
  controlled n: Integer
definitions:
  main rule r_Main = n  //~ A028
