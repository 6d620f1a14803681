asm unknown_function
import StandardLibrary
signature:
  controlled speed: Integer
definitions:
  main rule r_Main = sped := 3  //~ A001
