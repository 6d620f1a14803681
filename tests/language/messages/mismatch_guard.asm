asm mismatch_guard
import StandardLibrary
signature:
  controlled x: Integer
definitions:
  main rule r_Main = if x then skip endif  //~ A007
