// a result that nobody wants is lost
asm turbo_result_dropped
import StandardLibrary
signature:
  controlled x: Integer
definitions:
  turbo rule r_set($n in Integer) in Integer = par x := $n  result := $n endpar
  main rule r_Main = r_set(3)
//= step 1: x := 3
