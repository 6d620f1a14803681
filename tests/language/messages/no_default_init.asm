asm no_default_init
import StandardLibrary
signature:
  controlled n: Integer
definitions:
  main rule r_Main = skip
init s0:  //~ A027
  function n = 1
init s1:
  function n = 2
