// all binary operators associate to the left
asm associativity
import StandardLibrary
signature:
  controlled a: Boolean
  controlled b: Real
definitions:
  main rule r_Main = par a := false implies true implies false  b := 2.0 ^ 3.0 ^ 2.0 endpar
//= step 1: a := false, b := 64.0
