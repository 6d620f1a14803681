// a variable of the caller is not the variable of the same name in the macro
asm macro_capture
import StandardLibrary
signature:
  controlled x: Integer
definitions:
  rule r_set($n in Integer) = let ($m = 5) in x := $n + $m endlet
  main rule r_Main = let ($m = 1) in r_set[$m] endlet
//= step 1: x := 6
