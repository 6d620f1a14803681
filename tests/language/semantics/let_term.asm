// a later binding sees the earlier ones
asm let_term
import StandardLibrary
signature:
  controlled x: Integer
definitions:
  main rule r_Main = x := let ($a = 2, $b = $a * 3) in $a + $b endlet
//= step 1: x := 8
