asm literal_twice
import StandardLibrary
signature:
  enum domain Mode = {IDLE | MOVING}
  enum domain Light = {ON | IDLE}  //~ A009
definitions:
  main rule r_Main = skip
