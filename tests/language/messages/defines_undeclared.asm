asm defines_undeclared
import StandardLibrary
signature:
  static limit: Integer
definitions:
  function limits = 3  //~ A020
  main rule r_Main = skip
