asm defines_enumeration
import StandardLibrary
signature:
  enum domain Mode = {IDLE | MOVING}
definitions:
  domain Mode = {IDLE}  //~ A021
  main rule r_Main = skip
