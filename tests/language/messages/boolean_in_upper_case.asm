asm boolean_in_upper_case
import StandardLibrary
signature:
  enum domain Mode = {IDLE | RUN}
  controlled mode: Mode
  monitored go: Boolean
definitions:
  main rule r_Main = if go = True then mode := IDLE endif  //~ A005
