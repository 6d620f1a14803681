// a file may declare a function of the library anew
asm import_shadows_the_library
import StandardLibrary
signature:
  static max: Prod(Integer, Integer) -> Integer
  enum domain D1 = {ONE | TWO}
  controlled x: Integer
definitions:
  function max($a in Integer, $b in Integer) = 42
  main rule r_Main = x := max(1, 2) + size(D1)
//= step 1: x := 44
