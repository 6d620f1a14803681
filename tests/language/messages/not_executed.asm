asm not_executed
import StandardLibrary
signature:
  controlled n: Integer
definitions:
  main rule r_Main = iterate n := n + 1 enditerate  //~ A030
