// a rule by name, declared before or after
asm macro
import StandardLibrary
signature:
  controlled x: Integer
definitions:
  main rule r_Main = par r_set[3] endpar
  rule r_set($n in Integer) = r_twice[$n + 1]
  rule r_twice($n in Integer) = x := 2 * $n
//= step 1: x := 8
