asm too_deep
import StandardLibrary
signature:
  static down: Integer -> Integer
  controlled x: Integer
definitions:
  function down($n in Integer) = down($n + 1)  //~ R010
  main rule r_Main = x := down(0)
