// literals that nothing yields; those of a range, an input, an argument or a definition are reached
asm unreached_literal
import StandardLibrary
signature:
  enum domain Mode = {IDLE | RUNNING | FAILED | PARKED | MOVED} //~ W033
  enum domain Robot = {ROB1 | ROB2}
  enum domain Event = {DONE | LOST}
  enum domain Colour = {RED | GREEN}
  enum domain Place = {DOCK | SHELF}
  enum domain Level = {LOW | HIGH}
  monitored event: Event
  controlled mode: Mode
  controlled at: Robot -> Place
  derived colour: Colour
  static home: Robot -> Place
  controlled level: Level
  controlled n: Integer
definitions:
  function colour = if event = LOST then RED else GREEN endif
  function home($r in Robot) = if $r = ROB1 then DOCK else SHELF endif
  rule r_never = if colour = RED then n := 2 endif
  main rule r_Main =
    par
      switch mode
        case IDLE: mode := RUNNING
        case RUNNING: skip
        case FAILED: mode := IDLE //~ W033
      endswitch
      if at(ROB2) = SHELF then n := 1 endif
      choose $l in Level with $l = HIGH do level := $l
    endpar
default init s0:
  function mode = IDLE
  function at($r in Robot) = home($r)
