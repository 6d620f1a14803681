// the environment first, then the rules
asm shared
import StandardLibrary
signature:
  shared s: Integer
  controlled x: Integer
definitions:
  main rule r_Main = par x := s  s := s + 1 endpar
//? step 1: s = 5
//= step 1: s := 6, x := 5
//= step 2: s := 7, x := 6
//? step 3: s = 0
//= step 3: s := 1, x := 0
