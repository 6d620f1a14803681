asm mismatch
import StandardLibrary
signature:
  enum domain Mode = {IDLE | MOVING}
  controlled mode: Mode
definitions:
  main rule r_Main = mode := 1  //~ A007
