asm arity
import StandardLibrary
signature:
  controlled x: Integer
definitions:
  rule r_set($n in Integer) = x := $n
  main rule r_Main = r_set[1, 2]  //~ A008
