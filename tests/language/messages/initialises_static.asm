asm initialises_static
import StandardLibrary
signature:
  static limit: Integer
definitions:
  function limit = 3
  main rule r_Main = skip
default init s0:
  function limit = 4  //~ A021
