// two values at once for a variable are a clash
asm variable_assigned_twice
import StandardLibrary
signature:
definitions:
  main rule r_Main = choose $a in {1 : 3} with true do par
    $a := 7
    $a := 8
  endpar
//= step 1: R001
