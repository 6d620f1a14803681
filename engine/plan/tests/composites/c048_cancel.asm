asm c048_cancel
signature:
  enum domain Command = {NONE | GET | STOP | SAY | REST}
  out command: Command
  out lamp: Boolean
definitions:
  main rule r_Main =
    par
      choose $c in Command with true do command := $c
      lamp := true
    endpar
