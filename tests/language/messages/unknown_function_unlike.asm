asm unknown_function_unlike
import StandardLibrary
signature:
  controlled speed: Integer
definitions:
  main rule r_Main = speed := battery  //~ A001
