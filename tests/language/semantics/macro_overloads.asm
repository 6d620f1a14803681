// of rules with one name, the parameters pick
asm macro_overloads
import StandardLibrary
signature:
  controlled x: Integer
  controlled y: String
definitions:
  rule r_set($n in Integer) = x := $n
  rule r_set($s in String) = y := $s
  main rule r_Main = par r_set[1]  r_set["a"] endpar
//= step 1: x := 1, y := "a"
