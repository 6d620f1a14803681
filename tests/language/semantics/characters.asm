// one letter
asm characters
import StandardLibrary
signature:
  controlled c: Char
  controlled b: Boolean
definitions:
  main rule r_Main = par c := 'x'  b := 'a' < 'b' endpar
//= step 1: b := true, c := 'x'
