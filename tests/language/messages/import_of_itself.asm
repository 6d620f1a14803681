asm import_of_itself
import import_of_itself  //~ A011
signature:
definitions:
  main rule r_Main = skip
