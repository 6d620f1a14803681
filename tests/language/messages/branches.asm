asm branches
import StandardLibrary
signature:
  controlled x: Integer
definitions:
  main rule r_Main = x := if x > 1 then 1 else "many" endif  //~ A019
