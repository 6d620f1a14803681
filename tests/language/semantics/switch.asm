// the first case that is equal counts
asm switch
import StandardLibrary
signature:
  enum domain Colour = {RED | GREEN | BLUE}
  controlled c: Colour
  controlled n: Integer
definitions:
  main rule r_Main = switch c
    case RED: par n := 1  c := GREEN endpar
    case GREEN: par n := 2  c := BLUE endpar
    case GREEN: n := 3
    otherwise n := 4
  endswitch
default init s0:
  function c = RED
//= step 1: c := GREEN, n := 1
//= step 2: c := BLUE, n := 2
//= step 3: n := 4
