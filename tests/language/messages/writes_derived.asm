asm writes_derived
import StandardLibrary
signature:
  controlled n: Integer
  derived twice: Integer
definitions:
  function twice = 2 * n
  main rule r_Main = twice := 4  //~ A016
