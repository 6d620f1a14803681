asm main_with_parameters
import StandardLibrary
signature:
definitions:
  main rule r_Main($n in Integer) = skip  //~ A023
