// a macro may call itself
asm macro_recursive
import StandardLibrary
signature:
  controlled f: Integer -> Integer
definitions:
  rule r_fill($n in Integer) = if $n > 0 then par f($n) := $n  r_fill[$n - 1] endpar endif
  main rule r_Main = r_fill[3]
//= step 1: f(1) := 1, f(2) := 2, f(3) := 3
