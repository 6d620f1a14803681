asm null_for_undef
import StandardLibrary
signature:
  enum domain Mode = {IDLE | RUN}
  controlled mode: Mode
  monitored go: Boolean
definitions:
  main rule r_Main = mode := null  //~ A001
