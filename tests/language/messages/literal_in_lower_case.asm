asm literal_in_lower_case
import StandardLibrary
signature:
  enum domain Mode = {IDLE | RUN}
  controlled mode: Mode
  monitored go: Boolean
definitions:
  main rule r_Main = mode := idle  //~ A001
