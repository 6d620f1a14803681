asm import_not_found
import StandardLibrary
import lib/robots  //~ A010
signature:
definitions:
  main rule r_Main = skip
