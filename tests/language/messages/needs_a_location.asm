asm needs_a_location
import StandardLibrary
signature:
  controlled x: Integer
definitions:
  rule r_clear($l in Integer) = $l := 0
  main rule r_Main = r_clear[x + 1]  //~ A032
