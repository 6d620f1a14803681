// a later binding sees the earlier ones
asm let
import StandardLibrary
signature:
  controlled x: Integer
definitions:
  main rule r_Main = let ($a = 2, $b = $a * 3) in x := $b endlet
//= step 1: x := 6
