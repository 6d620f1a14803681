asm infinite
import StandardLibrary
signature:
  controlled x: Integer
definitions:
  main rule r_Main = choose $n in Integer with $n > 3 do x := $n  //~ R005
