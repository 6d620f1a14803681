asm endless_expansion
import StandardLibrary
signature:
  controlled x: Integer
definitions:
  rule r_down($l in Integer, $n in Integer) = seq $l := $n  r_down[$l, $n + x] endseq  //~ A031
  main rule r_Main = r_down[x, x]
