asm cannot_extend_enumeration
import StandardLibrary
signature:
  enum domain Mode = {IDLE | MOVING}
definitions:
  main rule r_Main = extend Mode with $m do skip  //~ A026
