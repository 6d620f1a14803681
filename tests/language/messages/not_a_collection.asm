asm not_a_collection
import StandardLibrary
signature:
  controlled n: Integer
definitions:
  main rule r_Main = forall $i in n do skip  //~ A018
