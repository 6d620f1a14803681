asm writes_static
import StandardLibrary
signature:
  static limit: Integer
definitions:
  function limit = 3
  main rule r_Main = limit := 4  //~ A016
