// nothing to choose from, and nothing to do then
asm choose_nothing
import StandardLibrary
signature:
  controlled x: Integer
definitions:
  main rule r_Main = choose $a in {1, 2} with $a > 2 do x := $a
//= step 1: nothing
