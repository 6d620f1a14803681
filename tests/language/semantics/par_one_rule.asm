// a block may hold a single rule
asm par_one_rule
import StandardLibrary
signature:
  controlled x: Integer
definitions:
  main rule r_Main = par x := 1 endpar
//= step 1: x := 1
