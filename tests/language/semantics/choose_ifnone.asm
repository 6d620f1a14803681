// nothing to choose from
asm choose_ifnone
import StandardLibrary
signature:
  controlled x: Integer
definitions:
  main rule r_Main = choose $a in {1, 2} with $a > 2 do x := $a ifnone x := 0
//= step 1: x := 0
