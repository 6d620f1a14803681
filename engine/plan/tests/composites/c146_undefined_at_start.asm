asm c146_undefined_at_start
import StandardLibrary
signature:
  enum domain Word = {GO | HALT}
  monitored near: Boolean
  monitored far: Boolean
  monitored word: Word
  monitored pulse: Boolean
  monitored old: Boolean
  out lamp: Boolean
definitions:
  main rule r_Main = par
    if pulse then lamp := true endif
    if isDef(word) then if word = GO then lamp := true endif endif
    if near and far then if old then lamp := false endif endif
  endpar
