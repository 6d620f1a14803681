asm rule_twice
import StandardLibrary
signature:
definitions:
  rule r_go = skip
  rule r_go = skip  //~ A009
  main rule r_Main = r_go[]
