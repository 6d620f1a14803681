asm c188_words
import StandardLibrary
signature:
  enum domain Mode = {IDLE | MOVING | CHARGING}
  monitored state: Mode
  out mode: Mode
definitions:
  main rule r_Main = mode := state
