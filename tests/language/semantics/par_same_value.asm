// the same value twice is no clash
asm par_same_value
import StandardLibrary
signature:
  controlled x: Integer
definitions:
  main rule r_Main = par x := 1  x := 3 - 2 endpar
//= step 1: x := 1
