// a timer runs out
asm timer
import StandardLibrary
import TimeLibrary
signature:
  static t: Timer
  controlled x: Boolean
definitions:
  main rule r_Main = x := expired(t)
default init s0:
  function start($t in Timer) = currentTime($t)
  function duration($t in Timer) = 3
  function timerUnit($t in Timer) = SEC
//? step 1: time 2000000000
//= step 1: x := false
//? step 2: time 4000000000
//= step 2: x := false
//? step 3: time 5000000000
//= step 3: x := true
