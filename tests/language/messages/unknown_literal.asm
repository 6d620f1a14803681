asm unknown_literal
import StandardLibrary
signature:
  enum domain Mode = {IDLE | MOVING}
  controlled mode: Mode
definitions:
  main rule r_Main = mode := MOVNG  //~ A005
