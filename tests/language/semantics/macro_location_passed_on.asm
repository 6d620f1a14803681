// a location is handed from macro to macro
asm macro_location_passed_on
import StandardLibrary
signature:
  controlled f: Integer -> Integer
definitions:
  rule r_set($l in Integer, $v in Integer) = $l := $v
  rule r_clear($l in Integer) = r_set[$l, 0]
  main rule r_Main = forall $i in {1 : 2} do r_clear[f($i)]
//= step 1: f(1) := 0, f(2) := 0
