asm undefined_guard
import StandardLibrary
signature:
  controlled speed: Integer
definitions:
  main rule r_Main = if speed > 3 then skip endif  //~ R003
