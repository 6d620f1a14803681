// the first element, in ascending order, unless another one is chosen
asm choose
import StandardLibrary
signature:
  controlled x: Integer
definitions:
  main rule r_Main = choose $a in {5, 3, 4} with $a > 3 do x := $a
//= step 1: x := 4
//? step 2: choose 1
//= step 2: x := 5
