asm defines_controlled
import StandardLibrary
signature:
  controlled n: Integer
definitions:
  function n = 3  //~ A021
  main rule r_Main = skip
